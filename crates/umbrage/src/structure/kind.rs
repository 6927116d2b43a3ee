//! Kinds of structures: the trait to implement for a structure of one's own, and its form without types.

use std::any::Any;
use std::fmt::Debug;
use std::sync::Arc;

use umbrage_rays::SimdLevel;

use super::options::StructureOption;
use crate::{Error, GpuStructure};

/// A kind of structure: the value is a choice of its options.
///
/// [`Structure::new`](crate::Structure::new) makes a structure for [`Settings`](crate::Settings) of it, and
/// [`Structures::with`](crate::Structures::with) adds it to those that are found by name. The structure itself implements
/// [`umbrage_rays::Structure`].
pub trait StructureKind: Clone + Debug + Default + PartialEq + Send + Sync + 'static {
    /// The name in command lines, windows and files: a word without spaces, `:`, `,` and `=`.
    const NAME: &'static str;
    /// The description, in a line without a full stop.
    const ABOUT: &'static str;
    /// The paper that describes it: authors, title and year.
    const PAPER: Option<&'static str> = None;
    /// The table of its options. Later ones may depend on earlier ones.
    const OPTIONS: &'static [KindOption<Self>] = &[];
    /// Whether it is made for the rays of one camera and each light, and so has
    /// [`specialised`](umbrage_rays::Structure::specialised).
    const IS_SPECIALISED: bool = false;

    /// Makes an empty structure that uses the instructions of `level`.
    ///
    /// With `sends_rays_onward`, rays from mirrors, through glass and behind panes follow the camera's rays in this frame.
    /// They go through the structure if it answers [single rays](umbrage_rays::Structure::single_rays), else through a
    /// hierarchy.
    ///
    /// # Errors
    /// If the structure can't be made with these options.
    fn make(&self, level: SimdLevel, sends_rays_onward: bool) -> Result<Box<dyn umbrage_rays::Structure>, Error>;

    /// Checks that the options go together.
    ///
    /// # Errors
    /// [`Error::StructureOptions`] with the reason, if they don't.
    fn check(&self) -> Result<(), Error> {
        Ok(())
    }

    /// The counterpart of this structure on a GPU; `None`, where a GPU has none and its own grids take its place.
    ///
    /// # Errors
    /// If the GPU has a counterpart, but not with these options. Options without
    /// [`is_on_gpu`](StructureOption::is_on_gpu) needn't be checked.
    fn on_gpu(&self) -> Result<Option<GpuStructure>, Error> {
        Ok(None)
    }
}

/// An option of a kind of structure, with access to its value.
#[derive(Debug)]
pub struct KindOption<K> {
    /// Name, description and possible values.
    pub option: StructureOption,
    /// Writes the value.
    pub get: fn(&K) -> String,
    /// Reads the value. The error is the reason why it is impossible, and then nothing is changed.
    pub set: fn(&mut K, &str) -> Result<(), String>,
}

/// Any [`StructureKind`].
pub(super) trait AnyKind: Send + Sync {
    fn as_any(&self) -> &dyn Any;
    fn is_same(&self, other: &dyn Any) -> bool;
    fn name(&self) -> &'static str;
    fn about(&self) -> &'static str;
    fn paper(&self) -> Option<&'static str>;
    fn is_specialised(&self) -> bool;
    fn options(&self) -> Vec<&'static StructureOption>;
    fn with_defaults(&self) -> Arc<dyn AnyKind>;
    fn with_option(&self, index: usize, value: &str) -> Result<Arc<dyn AnyKind>, String>;
    fn value(&self, index: usize) -> String;
    fn make(&self, level: SimdLevel, sends_rays_onward: bool) -> Result<Box<dyn umbrage_rays::Structure>, Error>;
    fn check(&self) -> Result<(), Error>;
    fn on_gpu(&self) -> Result<Option<GpuStructure>, Error>;
}

impl<K: StructureKind> AnyKind for K {
    fn as_any(&self) -> &dyn Any {
        self
    }

    fn is_same(&self, other: &dyn Any) -> bool {
        other.downcast_ref::<K>() == Some(self)
    }

    fn name(&self) -> &'static str {
        K::NAME
    }

    fn about(&self) -> &'static str {
        K::ABOUT
    }

    fn paper(&self) -> Option<&'static str> {
        K::PAPER
    }

    fn is_specialised(&self) -> bool {
        K::IS_SPECIALISED
    }

    fn options(&self) -> Vec<&'static StructureOption> {
        K::OPTIONS.iter().map(|option| &option.option).collect()
    }

    fn with_defaults(&self) -> Arc<dyn AnyKind> {
        Arc::new(K::default())
    }

    fn with_option(&self, index: usize, value: &str) -> Result<Arc<dyn AnyKind>, String> {
        let mut changed = self.clone();
        (K::OPTIONS[index].set)(&mut changed, value)?;
        Ok(Arc::new(changed))
    }

    fn value(&self, index: usize) -> String {
        (K::OPTIONS[index].get)(self)
    }

    fn make(&self, level: SimdLevel, sends_rays_onward: bool) -> Result<Box<dyn umbrage_rays::Structure>, Error> {
        StructureKind::make(self, level, sends_rays_onward)
    }

    fn check(&self) -> Result<(), Error> {
        StructureKind::check(self)
    }

    fn on_gpu(&self) -> Result<Option<GpuStructure>, Error> {
        StructureKind::on_gpu(self)
    }
}
