use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

/// The compiled entry points of a device. Kernels share them, since a driver may take seconds for each.
#[derive(Debug, Default)]
pub(crate) struct Pipelines {
    compiled: Mutex<HashMap<EntryPoint, Arc<OnceLock<Pipeline>>>>,
}

/// The source of a pipeline.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct EntryPoint {
    /// Path of one of the crate's modules, or the text of another shader.
    root: String,
    name: &'static str,
    /// Names of `override` constants, and the bits of their values.
    constants: Vec<(String, u64)>,
}

/// A compiled entry point.
#[derive(Clone, Debug)]
pub(crate) struct Pipeline {
    pub(crate) pipeline: wgpu::ComputePipeline,
    /// The bindings of each group.
    pub(crate) layouts: Vec<wgpu::BindGroupLayout>,
}

impl EntryPoint {
    pub(crate) fn new(root: &str, name: &'static str, constants: &[(&str, f64)]) -> Self {
        let constants = constants.iter().map(|&(name, value)| (name.to_owned(), value.to_bits()));
        Self { root: root.to_owned(), name, constants: constants.collect() }
    }
}

impl Pipelines {
    /// The pipeline of an entry point. `compile` makes it the first time; other threads wait meanwhile.
    pub(crate) fn get(&self, entry: EntryPoint, compile: impl FnOnce() -> Pipeline) -> Pipeline {
        let pipeline = Arc::clone(self.lock().entry(entry).or_default());
        pipeline.get_or_init(compile).clone()
    }

    /// Number of pipelines.
    pub(crate) fn count(&self) -> usize {
        self.lock().values().filter(|pipeline| pipeline.get().is_some()).count()
    }

    fn lock(&self) -> MutexGuard<'_, HashMap<EntryPoint, Arc<OnceLock<Pipeline>>>> {
        // No code panics while it holds the lock.
        self.compiled.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
