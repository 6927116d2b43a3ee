//! The papers' structures for users: names, options, and the making of each.

mod grid;
mod kd_tree;
mod listed;

use std::fmt::Display;
use std::str::FromStr;

use umbrage::Structures;
use umbrage::rays::Choice;

pub use grid::Uniform;
pub use kd_tree::KdTrees;
pub use listed::Listed;

/// All structures: those built into `umbrage`, and the papers'.
#[must_use]
pub fn structures() -> Structures {
    Structures::default().with::<Listed>().with::<Uniform>().with::<KdTrees>()
}

/// An option of a kind: its name, `gpu` if a GPU has it, its description, its possible values, and how it is read and set.
macro_rules! option {
    ($name:literal $(, $gpu:ident)?; $about:literal; $values:expr; |$kind:ident| $get:expr; |$changed:ident, $value:ident| $set:expr) => {
        umbrage::KindOption {
            option: umbrage::StructureOption {
                name: $name,
                about: $about,
                values: $values,
                is_on_gpu: option!(@ $($gpu)?),
            },
            get: |$kind| $get.to_string(),
            set: |$changed, $value| {
                $set;
                Ok(())
            },
        }
    };
    (@ gpu) => { true };
    (@) => { false };
}
use option;

/// Reads a number, or anything else with a text form.
fn parsed<T: FromStr<Err: Display>>(value: &str) -> Result<T, String> {
    value.parse().map_err(|error: T::Err| error.to_string())
}

/// Reads one of a type's named choices.
fn choice<T: Choice>(value: &str) -> Result<T, String> {
    T::named(value).map_err(|unknown| format!("choose one of {}", unknown.known))
}

/// Reads one of a few whole numbers.
fn whole_among(value: &str, names: fn() -> Vec<(&'static str, &'static str)>) -> Result<u32, String> {
    let names: Vec<&str> = names().into_iter().map(|(name, _)| name).collect();
    let is_known = names.contains(&value);
    value.parse().ok().filter(|_| is_known).ok_or_else(|| format!("choose one of {}", names.join(", ")))
}
