//! `umbrage view`: the window, where the command was built with it.

use crate::failure::Failure;
use crate::flags::ViewFlags;

#[cfg(not(feature = "view"))]
pub(crate) fn run(_: ViewFlags) -> Result<(), Failure> {
    Err(Failure::input(
        "this `umbrage` was built without its window",
        "build it with `cargo build --release --features view`, or use `umbrage render`",
    ))
}

#[cfg(feature = "view")]
pub(crate) fn run(flags: ViewFlags) -> Result<(), Failure> {
    use umbrage::EngineKind;
    use umbrage::gpu::Adapter;
    use umbrage_viewer::{EngineChoice, Start, view};

    let device = flags.device.unwrap_or_default();
    let wanted = device.to_lowercase();
    let has_gpu =
        || Adapter::all().iter().any(|found| !found.is_software && found.name.to_lowercase().contains(&wanted));
    let engine = match flags.engine {
        Some(EngineKind::Cpu) if !device.is_empty() => return Err(Failure::gpu_named_for_cpu()),
        None if device.is_empty() => None,
        Some(EngineKind::Cpu) => Some(EngineChoice::Cpu),
        Some(EngineKind::Auto) if !has_gpu() => Some(EngineChoice::Cpu),
        None | Some(EngineKind::Auto | EngineKind::Gpu) => Some(EngineChoice::Gpu(device)),
    };
    crate::job::use_threads(flags.threads)?;
    let start = Start {
        scene: flags.scene,
        options: flags.opening.into(),
        watches: flags.watch,
        engine,
        size: flags.size.map(|size| [size.width, size.height]),
        lights: None,
        forgets: flags.forget,
    };
    view(start).map_err(|error| Failure::Work(format!("{error}; `umbrage render` needs no window")))
}
