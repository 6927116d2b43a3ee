//! What people call the choices.

use std::fmt;
use std::str::FromStr;

use super::{KdBuilder, KdLayout, KdTraversal};

impl KdBuilder {
    /// All of them, exact ones first.
    pub const ALL: [Self; 8] = [
        Self::Naive,
        Self::Resorting,
        Self::Presorted,
        Self::Nested,
        Self::InPlace,
        Self::Binned,
        Self::Streaming,
        Self::Adaptive,
    ];

    /// A word without spaces.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Naive => "naive",
            Self::Resorting => "resorting",
            Self::Presorted => "presorted",
            Self::Nested => "nested",
            Self::InPlace => "in-place",
            Self::Binned => "binned",
            Self::Streaming => "streaming",
            Self::Adaptive => "adaptive",
        }
    }
}

impl KdLayout {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::DepthFirst, Self::Subtrees];

    /// A word without spaces.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::DepthFirst => "depth-first",
            Self::Subtrees => "subtrees",
        }
    }
}

impl KdTraversal {
    /// Entries of a short stack where nobody says how many.
    pub const DEFAULT_ENTRIES: u8 = 4;

    /// One of each kind.
    pub const KINDS: [Self; 4] = [Self::Stack, Self::Restart, Self::PushDown, Self::ShortStack(Self::DEFAULT_ENTRIES)];
}

impl fmt::Display for KdBuilder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl fmt::Display for KdLayout {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl fmt::Display for KdTraversal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Stack => f.write_str("stack"),
            Self::Restart => f.write_str("restart"),
            Self::PushDown => f.write_str("push-down"),
            Self::ShortStack(entries) => write!(f, "short-stack:{entries}"),
        }
    }
}

/// A word that names no builder, layout or traversal of a kd-tree.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownKdName {
    /// The word.
    pub name: String,
    /// Those that there are.
    pub known: &'static str,
}

impl fmt::Display for UnknownKdName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "`{}` isn't one of {}", self.name, self.known)
    }
}

impl std::error::Error for UnknownKdName {}

impl FromStr for KdBuilder {
    type Err = UnknownKdName;

    /// The builder of a [name](Self::name).
    fn from_str(name: &str) -> Result<Self, UnknownKdName> {
        let known = "naive, resorting, presorted, nested, in-place, binned, streaming, adaptive";
        let found = Self::ALL.into_iter().find(|builder| builder.name() == name);
        found.ok_or_else(|| UnknownKdName { name: name.to_owned(), known })
    }
}

impl FromStr for KdLayout {
    type Err = UnknownKdName;

    /// The layout of a [name](Self::name).
    fn from_str(name: &str) -> Result<Self, UnknownKdName> {
        let known = "depth-first, subtrees";
        let found = Self::ALL.into_iter().find(|layout| layout.name() == name);
        found.ok_or_else(|| UnknownKdName { name: name.to_owned(), known })
    }
}

impl FromStr for KdTraversal {
    type Err = UnknownKdName;

    /// `stack`, `restart`, `push-down`, `short-stack`, or `short-stack:N` with a stack of N entries.
    fn from_str(name: &str) -> Result<Self, UnknownKdName> {
        let entries = |text: &str| {
            let entries = text.parse().ok().filter(|entries| (1..=Self::MOST_ENTRIES).contains(entries));
            entries.map(Self::ShortStack)
        };
        let found = match name.split_once(':') {
            None => match name {
                "stack" => Some(Self::Stack),
                "restart" => Some(Self::Restart),
                "push-down" => Some(Self::PushDown),
                "short-stack" => Some(Self::ShortStack(Self::DEFAULT_ENTRIES)),
                _ => None,
            },
            Some(("short-stack", number)) => entries(number),
            Some(_) => None,
        };
        let known = "stack, restart, push-down, short-stack, short-stack:N with N from 1 to 48";
        found.ok_or_else(|| UnknownKdName { name: name.to_owned(), known })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn choices_are_found_by_their_names() {
        for builder in KdBuilder::ALL {
            assert_eq!(builder.name().parse(), Ok(builder));
        }
        for layout in KdLayout::ALL {
            assert_eq!(layout.name().parse(), Ok(layout));
        }
        for traversal in KdTraversal::KINDS.into_iter().chain([KdTraversal::ShortStack(KdTraversal::MOST_ENTRIES)]) {
            assert_eq!(traversal.to_string().parse(), Ok(traversal));
        }
        assert_eq!("short-stack".parse(), Ok(KdTraversal::ShortStack(KdTraversal::DEFAULT_ENTRIES)));
    }

    #[test]
    fn other_names_are_refused_with_those_that_there_are() {
        let builder = "fast".parse::<KdBuilder>().unwrap_err();
        assert!(KdBuilder::ALL.iter().all(|known| builder.known.contains(known.name())), "{builder}");
        let layout = "fast".parse::<KdLayout>().unwrap_err();
        assert!(KdLayout::ALL.iter().all(|known| layout.known.contains(known.name())), "{layout}");
        for bad in ["short-stack:0", "short-stack:49", "short-stack:", "short-stack:x", "stack:3", ""] {
            let error = bad.parse::<KdTraversal>().unwrap_err();
            assert!(error.to_string().contains(&KdTraversal::MOST_ENTRIES.to_string()), "{error}");
        }
    }
}
