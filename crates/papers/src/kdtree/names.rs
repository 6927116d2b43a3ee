//! Names of the choices.

use std::fmt;
use std::str::FromStr;

use super::{Clipping, KdBuilder, KdLayout, KdMailbox, KdPacketWidth, KdRebuild, KdTraversal};
use umbrage_rays::{Choice, UnknownChoice, choices};

choices! { KdBuilder, "kd-tree builder":
    "naive" => Naive, "counts triangles anew for each plane: exact, O(N²), for small scenes only";
    "resorting" => Resorting, "sorts the faces of boxes at each node: exact, O(N log² N)";
    "presorted" => Presorted, "sorts them once: exact, O(N log N)";
    "nested" => Nested, "as presorted, with threads that share the work of large nodes";
    "in-place" => InPlace, "as presorted, with threads that share the levels near the root";
    "binned" => Binned, "compares 16 planes across each axis: by far the fastest";
    "streaming" => Streaming, "compares 1024 planes, level after level";
    "adaptive" => Adaptive, "compares eight planes, and eight more where counts change";
    "spatial-median" => SpatialMedian, "halves the longest side: for comparison";
    "spatial-in-turn" => SpatialInTurn, "halves x, y and z in turn: for comparison";
    "object-median" => ObjectMedian, "halves the triangles across the longest side: for comparison";
    "object-in-turn" => ObjectInTurn, "halves the triangles across x, y and z in turn: for comparison";
}

choices! { KdLayout, "kd-tree layout":
    "depth-first" => DepthFirst, "the left child follows its parent";
    "subtrees" => Subtrees, "cache lines hold subtrees";
    "scattered" => Scattered, "pairs of children anywhere: for comparison";
}

choices! { Clipping, "kd-tree clipping":
    "boxes" => Boxes, "a triangle's box is cut at the plane";
    "triangles" => Triangles, "it is shrunk around the triangle's part on each side";
}

choices! { KdRebuild, "kd-tree rebuild":
    "whole" => Whole, "from scratch for each frame, by any builder";
    "hierarchy" => Hierarchy, "the same, from what the first frame's tree says about which triangles lie together";
    "background" => Background, "beside tracing, while rays go through an earlier tree";
    "two-level" => TwoLevel, "a tree for each object: kept where the object moved as a whole, else built again";
    "groups" => Groups, "a tree for each object, built again where the object moved: a gkDtree";
    "fuzzy" => Fuzzy, "a tree for each part, over boxes that hold its triangles in all frames so far";
}

choices! { KdPacketWidth, "kd-tree packet":
    "4" => Four, "4 rays";
    "8" => Eight, "8 rays";
    "16" => Sixteen, "16 rays";
}

choices! { KdMailbox, "kd-tree mailbox":
    "none" => None, "remembers nothing";
    "ring" => Ring, "remembers the last eight triangles";
    "hashed" => Hashed, "remembers the last triangle of each of 64 hashes";
}

impl KdTraversal {
    /// Entries of a short stack if no number is given.
    pub const DEFAULT_ENTRIES: u8 = 4;
}

impl Choice for KdTraversal {
    const OPTION: &'static str = "kd-tree traversal";
    const CHOICES: &'static [(&'static str, Self, &'static str)] = &[
        ("stack", Self::Stack, "keeps all far children that wait on a stack"),
        ("restart", Self::Restart, "without a stack: from the root to each leaf"),
        ("push-down", Self::PushDown, "as restart, from the lowest node that holds the rest of the ray"),
        (
            "short-stack:4",
            Self::ShortStack(Self::DEFAULT_ENTRIES),
            "a stack of 4 entries, or of 1 to 48, then as push-down",
        ),
    ];
}

impl fmt::Display for KdTraversal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ShortStack(entries) => write!(f, "short-stack:{entries}"),
            _ => f.pad(self.name()),
        }
    }
}

impl FromStr for KdTraversal {
    type Err = UnknownChoice;

    /// A name, `short-stack`, or `short-stack:N` with a stack of N entries.
    fn from_str(name: &str) -> Result<Self, UnknownChoice> {
        let entries = match name {
            "short-stack" => Some(Self::DEFAULT_ENTRIES),
            _ => name.strip_prefix("short-stack:").and_then(|entries| entries.parse().ok()),
        };
        match entries {
            Some(entries) if (1..=Self::MOST_ENTRIES).contains(&entries) => Ok(Self::ShortStack(entries)),
            Some(_) => Err(UnknownChoice::new(Self::OPTION, name, ["short-stack:N with N from 1 to 48"])),
            None => Self::named(name),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::fmt::{Debug, Display};

    use super::*;

    fn is_a_table<T: Choice + Debug + Display + FromStr<Err = UnknownChoice>>() {
        for &(name, value, about) in T::CHOICES {
            assert_eq!((name.parse(), value.to_string().as_str()), (Ok(value), name));
            assert!(!name.contains(char::is_whitespace) && !about.is_empty() && !about.ends_with('.'), "{name}");
        }
        let refused = "no-such".parse::<T>().unwrap_err().to_string();
        assert!(refused.contains("`no-such`") && refused.contains(T::OPTION), "{refused}");
        assert!(T::CHOICES.iter().all(|(name, ..)| refused.contains(name)), "{refused}");
    }

    #[test]
    fn choices_are_found_by_their_names_and_others_are_refused_with_those_that_there_are() {
        is_a_table::<KdBuilder>();
        is_a_table::<KdLayout>();
        is_a_table::<KdTraversal>();
        is_a_table::<Clipping>();
        is_a_table::<KdPacketWidth>();
        is_a_table::<KdMailbox>();
        is_a_table::<KdRebuild>();
    }

    #[test]
    fn short_stacks_have_as_many_entries_as_is_said() {
        assert_eq!("short-stack".parse(), Ok(KdTraversal::ShortStack(KdTraversal::DEFAULT_ENTRIES)));
        assert_eq!("short-stack:48".parse(), Ok(KdTraversal::ShortStack(KdTraversal::MOST_ENTRIES)));
        assert_eq!(KdTraversal::ShortStack(9).to_string().parse(), Ok(KdTraversal::ShortStack(9)));
        for bad in ["short-stack:0", "short-stack:49"] {
            let error = bad.parse::<KdTraversal>().unwrap_err();
            assert!(error.to_string().contains(&KdTraversal::MOST_ENTRIES.to_string()), "{error}");
        }
        for bad in ["short-stack:", "short-stack:x", "stack:3", ""] {
            assert!(bad.parse::<KdTraversal>().is_err(), "{bad}");
        }
    }
}
