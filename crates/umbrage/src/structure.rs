//! Acceleration structures as values: a kind, with a value for each of its options.

mod gpu;
mod kind;
mod options;
mod registry;

use std::fmt;
use std::sync::Arc;

use umbrage_rays::{Bvh, DirectGrids, SimdLevel};

use crate::Error;

pub use gpu::{GpuGrids, GpuStructure};
pub use kind::{KindOption, StructureKind};
pub(crate) use options::edits;
pub use options::{ImpossibleOption, LightClamp, NoLightClamp, OptionValues, StructureOption};
pub use registry::{Structures, UnknownStructure};

use kind::AnyKind;

/// A structure that finds the triangles hit by camera rays and shadow rays: a [kind](StructureKind) with its options.
///
/// The default and [`bvh`](Self::bvh) are built in. [`new`](Self::new) makes one of any other kind, and
/// [`Structures`] finds one by its name.
///
/// As text it is the name, and the options that aren't the defaults: `kdtree:builder=presorted,lazy=64`.
#[derive(Clone)]
pub struct Structure(Arc<dyn AnyKind>);

impl Structure {
    /// A structure of this kind.
    #[must_use]
    pub fn new<K: StructureKind>(kind: K) -> Self {
        Self(Arc::new(kind))
    }

    /// A structure of this kind with its default options.
    #[must_use]
    pub fn of<K: StructureKind>() -> Self {
        Self::new(K::default())
    }

    /// One bounding volume hierarchy for all rays.
    #[must_use]
    pub fn bvh() -> Self {
        Self::of::<Hierarchy>()
    }

    /// Its kind, with its options, if it is of type `K`.
    #[must_use]
    pub fn kind<K: StructureKind>(&self) -> Option<&K> {
        self.0.as_any().downcast_ref()
    }

    /// Its name in command lines, windows and files.
    #[must_use]
    pub fn name(&self) -> &'static str {
        self.0.name()
    }

    /// Its description, in a line without a full stop.
    #[must_use]
    pub fn about(&self) -> &'static str {
        self.0.about()
    }

    /// The paper that describes it: authors, title and year.
    #[must_use]
    pub fn paper(&self) -> Option<&'static str> {
        self.0.paper()
    }

    /// Whether it is made for the rays of one camera and each light, whose cells and work can be shown.
    #[must_use]
    pub fn is_specialised(&self) -> bool {
        self.0.is_specialised()
    }

    /// Checks that the options go together.
    pub(crate) fn check(&self) -> Result<(), Error> {
        self.0.check()
    }

    /// Checks that a GPU has this structure, with all its options.
    ///
    /// # Errors
    /// If it hasn't, or would ignore an option.
    pub fn check_on_gpu(&self) -> Result<(), Error> {
        self.on_gpu()?.map(drop).ok_or(Error::StructureOnGpu(self.name()))
    }

    /// Its counterpart on a GPU, if it has one.
    pub(crate) fn on_gpu(&self) -> Result<Option<GpuStructure>, Error> {
        let Some(counterpart) = self.0.on_gpu()? else { return Ok(None) };
        match self.changed_options().find(|(option, _)| !option.is_on_gpu) {
            Some((option, _)) => Err(Error::OptionOnGpu(self.name(), option.name)),
            None => Ok(Some(counterpart)),
        }
    }

    /// An empty structure that uses the instructions of `level`; with `sends_rays_onward` for single rays as well as the
    /// camera's and the lights'.
    pub(crate) fn make(
        &self,
        level: SimdLevel,
        sends_rays_onward: bool,
    ) -> Result<Box<dyn umbrage_rays::Structure>, Error> {
        self.0.make(level, sends_rays_onward)
    }

    /// The same kind with its default options.
    #[must_use]
    pub fn with_defaults(&self) -> Self {
        Self(self.0.with_defaults())
    }

    /// Its options. Later ones may depend on earlier ones.
    pub fn options(&self) -> impl Iterator<Item = &'static StructureOption> + use<> {
        self.0.options().into_iter()
    }

    /// Its options that aren't the defaults, with their values.
    pub fn changed_options(&self) -> impl Iterator<Item = (&'static StructureOption, String)> {
        let default = self.with_defaults();
        self.options().enumerate().filter_map(move |(index, option)| {
            let value = self.0.value(index);
            (value != default.0.value(index)).then_some((option, value))
        })
    }

    /// The value of an option, as [`set_option`](Self::set_option) takes it; `None` where the structure has no such option.
    #[must_use]
    pub fn option(&self, name: &str) -> Option<String> {
        let index = self.options().position(|option| option.name == name)?;
        Some(self.0.value(index))
    }

    /// Sets an option. Its value may change others that depend on it.
    ///
    /// # Errors
    /// If the structure has no such option, or that can't have the value. Then nothing is changed.
    pub fn set_option(&mut self, name: &str, value: &str) -> Result<(), ImpossibleOption> {
        let impossible = |why: String| ImpossibleOption {
            structure: self.name(),
            option: name.to_owned(),
            value: value.to_owned(),
            why,
        };
        let Some(index) = self.options().position(|option| option.name == name) else {
            return Err(impossible(options::unknown(
                name,
                &self.options().map(|option| option.name).collect::<Vec<_>>(),
            )));
        };
        if let Some(option) = self.options().nth(index) {
            option.values.check(value).map_err(impossible)?;
        }
        self.0 = self.0.with_option(index, value).map_err(impossible)?;
        Ok(())
    }
}

/// Grids made for the rays: a perspective grid for the camera, and one for each light.
impl Default for Structure {
    fn default() -> Self {
        Self::of::<Direct>()
    }
}

impl PartialEq for Structure {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0) || self.0.is_same(other.0.as_any())
    }
}

impl fmt::Debug for Structure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Structure({self})")
    }
}

impl fmt::Display for Structure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())?;
        for (index, (option, value)) in self.changed_options().enumerate() {
            let separator = if index == 0 { ':' } else { ',' };
            write!(f, "{separator}{}={value}", option.name)?;
        }
        Ok(())
    }
}

/// Grids made for the rays of a camera and of each light.
#[derive(Clone, Debug, Default, PartialEq)]
struct Direct;

impl StructureKind for Direct {
    const NAME: &'static str = "perspective";
    const ABOUT: &'static str = "grids made for the camera's and the lights' rays";
    const IS_SPECIALISED: bool = true;

    fn make(&self, level: SimdLevel, _sends_rays_onward: bool) -> Result<Box<dyn umbrage_rays::Structure>, Error> {
        Ok(Box::new(DirectGrids::with_level(level)))
    }

    fn on_gpu(&self) -> Result<Option<GpuStructure>, Error> {
        Ok(Some(GpuStructure::grids()))
    }
}

/// A bounding volume hierarchy.
#[derive(Clone, Debug, Default, PartialEq)]
struct Hierarchy;

impl StructureKind for Hierarchy {
    const NAME: &'static str = "bvh";
    const ABOUT: &'static str = "a bounding volume hierarchy for all rays";

    fn make(&self, level: SimdLevel, _sends_rays_onward: bool) -> Result<Box<dyn umbrage_rays::Structure>, Error> {
        Ok(Box::new(Bvh::with_level(level)))
    }
}
