//! The papers' structures for users: names, options, and the making of each. `umbrage-rays` has their code.

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

#[cfg(test)]
mod tests {
    use umbrage::{OptionValues, Structure, StructureOption};

    use super::structures;

    /// Some values that an option can have.
    fn values(option: &StructureOption) -> Vec<String> {
        match &option.values {
            OptionValues::Names(names) => names().iter().map(|(name, _)| (*name).to_owned()).collect(),
            OptionValues::Whole(range) | OptionValues::WholeOrAuto(range) => {
                // Blocks of rays are multiples of 16.
                vec![range.end().to_string(), 48.min(*range.end()).to_string()]
            }
            OptionValues::Positive => vec!["0.25".to_owned(), "100".to_owned()],
            OptionValues::Rectangle => vec!["auto".to_owned(), "-30:30:-20:20.5".to_owned()],
            OptionValues::Share => vec!["0".to_owned(), "0.3".to_owned(), "1".to_owned()],
            OptionValues::Switch => vec!["true".to_owned(), "false".to_owned()],
        }
    }

    #[test]
    fn every_option_of_every_structure_is_set_read_and_written() {
        for known in structures().iter() {
            assert!(!known.about().is_empty() && !known.about().ends_with('.'), "{known}");
            for option in known.options() {
                assert!(!option.about.ends_with('.') && !option.name.contains([' ', ':', ',', '=']), "{}", option.name);
                for value in values(option) {
                    let mut structure = known.clone();
                    if option.name == "tracing-tiles" {
                        structure.set_option("sorting-tile", "8").unwrap();
                    }
                    structure.set_option(option.name, &value).unwrap();
                    assert_eq!(structure.option(option.name), Some(value));
                    assert_eq!(structures().parse(&structure.to_string()), Ok(structure));
                }
            }
        }
    }

    #[test]
    fn names_stay_and_need_no_options() {
        let named: Vec<String> = structures().iter().map(ToString::to_string).collect();
        assert_eq!(named, ["perspective", "bvh", "listed", "grid", "kdtree"]);
        let tuned = structures().parse("kdtree:lazy=64").unwrap();
        assert_eq!(tuned.to_string(), "kdtree:lazy=64");
        assert!(named.iter().all(|name| structures().parse(name).unwrap() == structures().named(name).unwrap()));
    }

    #[test]
    fn options_that_exclude_each_other_or_lack_sense_are_refused_in_words() {
        for (text, why) in [
            ("tree", "there is no structure `tree`: did you mean `kdtree`?"),
            ("bvh:packet=4", "it has no options"),
            ("grid:packet=7", "choose one of 2, 4, 8, 16, 32"),
            ("grid:density=0", "a number above 0"),
            ("grid:density=1e300", "a number above 0"),
            ("grid:nested=0", "`auto` or a whole number from 1 on"),
            ("listed:sorting-tile=7", "choose one of 8, 16, 32, 64"),
            ("listed:sorting-tile=16,tracing-tiles=8", "64"),
            ("listed:slices=65", "from 1 to 64"),
            ("listed:light-rays=17", "16"),
            ("listed:light-clamp=10:-10:0:20", "from -180 to 180, as -30:30:-20:20"),
            ("listed:light-clamp=0:10:0", "as -30:30:-20:20"),
            ("listed:whole-tiles=", "`true` or `false`"),
            ("kdtree:builder=fast", "choose one of naive"),
            ("kdtree:bilder=binned", "did you mean `builder`?"),
            ("kdtree:kd-builder=binned", "choose one of builder"),
            ("kdtree:traversal=short-stack:49", "1 to 48"),
            ("kdtree:rebuild=never", "choose one of whole, hierarchy, background"),
            ("kdtree:lazy=4097", "from 0 to 4096"),
            ("kdtree:packet=5", "choose one of 4, 8, 16"),
            ("kdtree:test-cost=0", "a number above 0"),
            ("kdtree:empty-cost=1.5", "a number from 0 to 1"),
            ("kdtree:empty-cost=NaN", "a number from 0 to 1"),
            ("kdtree:charge-twice=no", "`true` or `false`"),
        ] {
            let refused = structures().parse(text).unwrap_err().to_string();
            assert!(refused.contains(why), "{text}: {refused}");
        }
    }

    #[test]
    fn larger_tiles_leave_room_for_fewer() {
        let mut listed = structures().named("listed").unwrap();
        listed.set_option("sorting-tile", "64").unwrap();
        assert_eq!(listed.option("tracing-tiles").as_deref(), Some("1"));
        let before = listed.clone();
        listed.set_option("tracing-tiles", "2").unwrap_err();
        assert!(listed == before);
    }

    #[test]
    fn gpus_have_some_structures_and_options() {
        let refused = |text: &str| {
            let structure: Structure = structures().parse(text).unwrap();
            structure.check_on_gpu().map_err(|error| error.to_string())
        };
        for text in ["perspective", "listed", "listed:sorting-tile=8,slices=3,light-map=spherical", "kdtree:packet=8"] {
            assert_eq!(refused(text), Ok(()), "{text}");
        }
        for (text, why) in [
            ("bvh", "but not `bvh`"),
            ("grid", "but not `grid`"),
            ("listed:light-rays=16", "no option `light-rays`"),
            ("listed:sorting-tile=32", "8 or 16"),
            ("listed:tracing-tiles=2", "16 pixels a side"),
            ("kdtree:lazy=9", "no option `lazy`"),
            ("kdtree:rebuild=fuzzy", "no option `rebuild`"),
        ] {
            assert!(refused(text).unwrap_err().contains(why), "{text}");
        }
    }
}
