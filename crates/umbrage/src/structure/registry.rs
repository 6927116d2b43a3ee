use super::Structure;
use super::built_in::{Direct, Hierarchy};
use super::kind::StructureKind;
use super::options::{ImpossibleOption, unknown};

/// Structures to choose from by name, each with its default options: those built in, and any that are added.
#[derive(Clone, Debug)]
pub struct Structures(Vec<Structure>);

/// The structures that are built in: the default first, and the hierarchy.
impl Default for Structures {
    fn default() -> Self {
        Self(vec![Structure::of::<Direct>(), Structure::of::<Hierarchy>()])
    }
}

impl Structures {
    /// Adds a kind of structure, in place of one with the same name.
    #[must_use]
    pub fn with<K: StructureKind>(mut self) -> Self {
        self.0.retain(|known| known.name() != K::NAME);
        self.0.push(Structure::of::<K>());
        self
    }

    /// Those for which `is_wanted` holds.
    #[must_use]
    pub fn only(mut self, is_wanted: impl Fn(&Structure) -> bool) -> Self {
        self.0.retain(is_wanted);
        self
    }

    /// All of them, in the order in which they were added.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &Structure> {
        self.0.iter()
    }

    /// The structure of this name, with its default options.
    ///
    /// # Errors
    /// If there is none.
    pub fn named(&self, name: &str) -> Result<Structure, UnknownStructure> {
        let found = self.0.iter().find(|known| known.name() == name);
        found.cloned().ok_or_else(|| {
            let known: Vec<_> = self.0.iter().map(Structure::name).collect();
            UnknownStructure::Name { name: name.to_owned(), why: unknown(name, &known) }
        })
    }

    /// Reads a structure with options: `name:option=value,option=value`, as [`Structure`]'s `Display` writes it. A switch
    /// needs no value: `whole-tiles` is `whole-tiles=true`.
    ///
    /// # Errors
    /// If there is none of this name, or it can't have the options.
    pub fn parse(&self, text: &str) -> Result<Structure, UnknownStructure> {
        let (name, options) = text.split_once(':').map_or((text, None), |(name, options)| (name, Some(options)));
        let mut structure = self.named(name)?;
        for option in options.into_iter().flat_map(|options| options.split(',')) {
            let (option, value) = option.split_once('=').unwrap_or((option, "true"));
            structure.set_option(option, value)?;
        }
        Ok(structure)
    }
}

/// The reason why a text is no structure.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum UnknownStructure {
    /// There is none of that name.
    #[error("there is no structure `{name}`: {why}")]
    Name {
        /// The unknown name.
        name: String,
        /// The known names.
        why: String,
    },
    /// An option is impossible.
    #[error(transparent)]
    Option(#[from] ImpossibleOption),
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Error, KindOption, OptionValues, StructureOption};
    use umbrage_rays::{Bvh, SimdLevel};

    /// A hierarchy with two options.
    #[derive(Clone, Debug, Default, PartialEq)]
    struct Tuned {
        depth: u32,
        is_wide: bool,
    }

    impl StructureKind for Tuned {
        const NAME: &'static str = "tuned";
        const ABOUT: &'static str = "a hierarchy with options";
        const OPTIONS: &'static [KindOption<Self>] = &[
            KindOption {
                option: StructureOption {
                    name: "depth",
                    about: "Levels",
                    values: OptionValues::Whole(0..=9),
                    is_on_gpu: false,
                },
                get: |tuned| tuned.depth.to_string(),
                set: |tuned, value| {
                    tuned.depth = value.parse().map_err(|_| "no number".to_owned())?;
                    if tuned.depth == 7 { Err("7 levels are too many".to_owned()) } else { Ok(()) }
                },
            },
            KindOption {
                option: StructureOption {
                    name: "wide",
                    about: "Wide nodes",
                    values: OptionValues::Switch,
                    is_on_gpu: false,
                },
                get: |tuned| tuned.is_wide.to_string(),
                set: |tuned, value| {
                    tuned.is_wide = value == "true";
                    Ok(())
                },
            },
        ];

        fn make(&self, level: SimdLevel, _: bool) -> Result<Box<dyn umbrage_rays::Structure>, Error> {
            Ok(Box::new(Bvh::with_level(level)))
        }
    }

    #[test]
    fn registered_structures_are_found_by_name_and_written_with_their_options() {
        let structures = Structures::default().with::<Tuned>().with::<Tuned>();
        let names: Vec<_> = structures.iter().map(Structure::name).collect();
        assert_eq!(names, ["perspective", "bvh", "tuned"]);
        for text in ["perspective", "bvh", "tuned", "tuned:depth=3", "tuned:depth=3,wide=true"] {
            assert_eq!(structures.parse(text).unwrap().to_string(), text);
        }
        let tuned = Structure::new(Tuned { depth: 3, is_wide: true });
        assert_eq!(structures.parse("tuned:wide,depth=3").unwrap(), tuned);
        assert_eq!(tuned.kind(), Some(&Tuned { depth: 3, is_wide: true }));
        assert_ne!(tuned, Structure::of::<Tuned>());
        assert_ne!(Structure::default(), Structure::bvh());
        assert_eq!(structures.only(Structure::is_specialised).iter().len(), 1);
        assert!(tuned.check_on_gpu().is_err());
    }

    #[test]
    fn refused_texts_name_the_nearest_right_ones() {
        let structures = Structures::default().with::<Tuned>();
        for (text, why) in [
            ("tuend", "there is no structure `tuend`: did you mean `tuned`? choose one of perspective, bvh, tuned"),
            ("xyz", "there is no structure `xyz`: choose one of perspective, bvh, tuned"),
            ("bvh:depth=4", "bvh:depth=4: it has no options"),
            ("tuned:deph=4", "tuned:deph=4: did you mean `depth`? choose one of depth, wide"),
            ("tuned:depth=10", "tuned:depth=10: give a whole number from 0 to 9"),
            ("tuned:depth=7", "tuned:depth=7: 7 levels are too many"),
            ("tuned:wide=no", "tuned:wide=no: give `true` or `false`"),
        ] {
            assert_eq!(structures.parse(text).unwrap_err().to_string(), why);
        }
        let mut tuned = Structure::of::<Tuned>();
        tuned.set_option("depth", "7").unwrap_err();
        assert_eq!(tuned, Structure::of::<Tuned>(), "nothing is changed");
    }
}
