//! Options of structures: names, descriptions and possible values.

use std::fmt;
use std::ops::RangeInclusive;
use std::str::FromStr;

/// An option of a structure, for [`Structure::option`](crate::Structure::option) and
/// [`Structure::set_option`](crate::Structure::set_option).
#[derive(Debug)]
pub struct StructureOption {
    /// The name: a word without spaces, `:`, `,` and `=`.
    pub name: &'static str,
    /// The meaning, in a line that ends without a full stop.
    pub about: &'static str,
    /// The values that it can have.
    pub values: OptionValues,
    /// Whether a structure on a GPU has it.
    pub is_on_gpu: bool,
}

/// The values that an option can have.
#[derive(Debug)]
pub enum OptionValues {
    /// One of a few names, each with its meaning, or another value that the option's own `set` accepts.
    Names(fn() -> Vec<(&'static str, &'static str)>),
    /// A whole number.
    Whole(RangeInclusive<u32>),
    /// A whole number, or `auto`.
    WholeOrAuto(RangeInclusive<u32>),
    /// The four angles of a [`LightClamp`] in degrees, or `auto`.
    Rectangle,
    /// A finite number above 0.
    Positive,
    /// A number from 0 to 1.
    Share,
    /// `true` or `false`.
    Switch,
}

/// An option that a structure lacks, or a value that it can't have.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{structure}:{option}={value}: {why}")]
pub struct ImpossibleOption {
    /// The structure's name.
    pub structure: &'static str,
    /// The option's name.
    pub option: String,
    /// The refused value.
    pub value: String,
    /// The reason, with the possible values.
    pub why: String,
}

impl OptionValues {
    /// Checks that an option can have a value; the error gives the reason.
    pub(super) fn check(&self, value: &str) -> Result<(), String> {
        let in_range = |range: &RangeInclusive<u32>| value.parse().is_ok_and(|value| range.contains(&value));
        let is_possible = match self {
            Self::Names(_) => true,
            Self::Whole(range) => in_range(range),
            Self::WholeOrAuto(range) => value == "auto" || in_range(range),
            Self::Rectangle => value == "auto" || value.parse::<LightClamp>().is_ok(),
            Self::Positive => value.parse().is_ok_and(|value: f64| value > 0.0 && value.is_finite()),
            Self::Share => value.parse().is_ok_and(|value: f64| (0.0..=1.0).contains(&value)),
            Self::Switch => matches!(value, "true" | "false"),
        };
        if is_possible { Ok(()) } else { Err(format!("give {}", self.in_words())) }
    }

    /// The possible values in words: `a whole number from 1 to 64`.
    #[must_use]
    pub fn in_words(&self) -> String {
        match self {
            Self::Names(names) => {
                let names: Vec<_> = names().into_iter().map(|(name, _)| name).collect();
                format!("one of {}", names.join(", "))
            }
            Self::Whole(range) => format!("a whole number from {} to {}", range.start(), range.end()),
            Self::WholeOrAuto(range) => format!("`auto` or a whole number from {} on", range.start()),
            Self::Rectangle => "`auto`, or the lowest and highest α and β in degrees from -180 to 180, as \
                                -30:30:-20:20"
                .to_owned(),
            Self::Positive => "a number above 0".to_owned(),
            Self::Share => "a number from 0 to 1".to_owned(),
            Self::Switch => "`true` or `false`".to_owned(),
        }
    }
}

/// The reason why `name` isn't one of the `known` names, with the nearest of these and all.
pub(super) fn unknown(name: &str, known: &[&str]) -> String {
    if known.is_empty() {
        return "it has no options".to_owned();
    }
    let all = format!("choose one of {}", known.join(", "));
    match known.iter().map(|known| (edits(name, known), known)).min() {
        Some((changes, nearest)) if 2 * changes <= name.len().max(nearest.len()) => {
            format!("did you mean `{nearest}`? {all}")
        }
        _ => all,
    }
}

/// The number of letters to insert, remove or replace between two words (Levenshtein 1966).
pub(crate) fn edits(from: &str, to: &str) -> usize {
    // Those between the letters of `from` so far and each start of `to`.
    let mut row: Vec<usize> = (0..=to.len()).collect();
    for (index, letter) in from.bytes().enumerate() {
        let mut diagonal = row[0];
        row[0] = index + 1;
        for (column, other) in to.bytes().enumerate() {
            let replaced = diagonal + usize::from(letter != other);
            diagonal = row[column + 1];
            row[column + 1] = replaced.min(diagonal + 1).min(row[column] + 1);
        }
    }
    row[to.len()]
}

/// A rectangle of angles α and β around a light, in degrees from −180 to 180.
///
/// Both are measured from the light's forward direction: a spot's own, or towards the middle of the camera's points. α is to
/// the right, along the image's rows, and β to the third side. The rectangle's border cells also hold everything outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightClamp {
    /// Lowest and highest α, lowest and highest β.
    degrees: [f32; 4],
}

impl LightClamp {
    /// A rectangle from the lowest and highest α, and the lowest and highest β; `None` for an empty range or angles beyond
    /// ±180.
    #[must_use]
    pub fn new(degrees: [f32; 4]) -> Option<Self> {
        let [left, right, low, high] = degrees;
        let is_range = |low: f32, high: f32| -180.0 <= low && low < high && high <= 180.0;
        (is_range(left, right) && is_range(low, high)).then_some(Self { degrees })
    }

    /// The angles, as for [`new`](Self::new).
    #[must_use]
    pub fn degrees(self) -> [f32; 4] {
        self.degrees
    }

    /// Lowest and highest α, and β, in radians.
    #[must_use]
    pub fn radians(self) -> [[f32; 2]; 2] {
        let [left, right, low, high] = self.degrees.map(f32::to_radians);
        [[left, right], [low, high]]
    }
}

/// As `-30:30:-20:20`.
impl fmt::Display for LightClamp {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [left, right, low, high] = self.degrees;
        write!(f, "{left}:{right}:{low}:{high}")
    }
}

impl FromStr for LightClamp {
    type Err = NoLightClamp;

    fn from_str(text: &str) -> Result<Self, NoLightClamp> {
        let mut numbers = text.split(':').map(|number| number.parse().ok());
        let degrees = std::array::from_fn(|_| numbers.next().flatten().unwrap_or(f32::NAN));
        Self::new(degrees).filter(|_| numbers.next().is_none()).ok_or(NoLightClamp)
    }
}

/// The error for a text that is no [`LightClamp`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("give the lowest and highest α and β in degrees from -180 to 180, as -30:30:-20:20")]
pub struct NoLightClamp;
