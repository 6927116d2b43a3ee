use super::kind::StructureKind;
use super::options::{ImpossibleOption, unknown};
use super::{Direct, Hierarchy, Structure};

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
