//! Options with named values: one table has each name, its value and its description.

/// An option with a few values, each with a name.
///
/// Command lines, their help, drop-down lists and written files all come from [`CHOICES`](Self::CHOICES).
/// [`choices!`](crate::choices) writes this with `FromStr` and `Display`.
pub trait Choice: Copy + PartialEq + 'static {
    /// The option's name in messages: "kd-tree builder".
    const OPTION: &'static str;
    /// Name, value and a one-line description without a full stop. Names are words without spaces.
    const CHOICES: &'static [(&'static str, Self, &'static str)];

    /// All values, in the table's order.
    fn all() -> impl Iterator<Item = Self> {
        Self::CHOICES.iter().map(|(_, value, _)| *value)
    }

    /// All names with their descriptions.
    #[must_use]
    fn names() -> Vec<(&'static str, &'static str)> {
        Self::CHOICES.iter().map(|(name, _, about)| (*name, *about)).collect()
    }

    /// Its name; empty if the table lacks it.
    fn name(self) -> &'static str {
        Self::CHOICES.iter().find(|(_, value, _)| *value == self).map_or("", |(name, ..)| name)
    }

    /// The value's description; empty if the table lacks it.
    fn about(self) -> &'static str {
        Self::CHOICES.iter().find(|(_, value, _)| *value == self).map_or("", |(.., about)| about)
    }

    /// The value of a name.
    ///
    /// # Errors
    /// If there is no such name.
    fn named(name: &str) -> Result<Self, UnknownChoice> {
        let found = Self::CHOICES.iter().find(|(known, ..)| *known == name);
        found.map(|(_, value, _)| *value).ok_or_else(|| Self::unknown(name))
    }

    /// The error for a name that isn't in the table.
    #[must_use]
    fn unknown(name: &str) -> UnknownChoice {
        UnknownChoice::new(Self::OPTION, name, Self::CHOICES.iter().map(|(known, ..)| *known))
    }
}

/// Gives a type its table of choices: `choices! { Type, "option": "name" => Variant, "description"; … }`.
#[macro_export]
macro_rules! choices {
    ($type:ty, $option:literal: $($name:literal => $value:ident, $about:literal;)+) => {
        impl $crate::Choice for $type {
            const OPTION: &'static str = $option;
            const CHOICES: &'static [(&'static str, Self, &'static str)] = &[$(($name, Self::$value, $about)),+];
        }

        impl std::fmt::Display for $type {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.pad($crate::Choice::name(*self))
            }
        }

        impl std::str::FromStr for $type {
            type Err = $crate::UnknownChoice;

            fn from_str(name: &str) -> Result<Self, $crate::UnknownChoice> {
                $crate::Choice::named(name)
            }
        }
    };
}

/// The error for a name that no choice has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no {option} `{name}`: choose one of {known}")]
pub struct UnknownChoice {
    /// The option, such as "kd-tree builder".
    pub option: &'static str,
    /// The unknown name.
    pub name: String,
    /// The known names, separated by commas.
    pub known: String,
}

impl UnknownChoice {
    /// The error for a name that isn't one of `known`.
    pub fn new(option: &'static str, name: &str, known: impl IntoIterator<Item = &'static str>) -> Self {
        let known: Vec<&str> = known.into_iter().collect();
        Self { option, name: name.to_owned(), known: known.join(", ") }
    }
}

#[cfg(test)]
mod tests {
    use std::fmt::{Debug, Display};
    use std::str::FromStr;

    use super::*;
    use crate::TracedBy;

    fn is_a_table<T: Choice + Debug + Display + FromStr<Err = UnknownChoice>>() {
        for &(name, value, about) in T::CHOICES {
            assert_eq!((name.parse(), value.to_string().as_str()), (Ok(value), name));
            assert!(
                !name.contains(char::is_whitespace) && !about.is_empty() && !about.ends_with('.'),
                "{name}: {about}"
            );
        }
        let refused = "no-such".parse::<T>().unwrap_err().to_string();
        assert!(refused.contains("`no-such`") && refused.contains(T::OPTION), "{refused}");
        assert!(T::CHOICES.iter().all(|(name, ..)| refused.contains(name)), "{refused}");
    }

    #[test]
    fn choices_are_found_by_their_names_and_others_are_refused_with_those_that_there_are() {
        is_a_table::<TracedBy>();
    }
}
