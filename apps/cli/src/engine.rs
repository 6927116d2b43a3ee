//! Choice of the engine.

use umbrage::{EngineKind, Renderer, Scene};

use crate::failure::{Failure, say};
use crate::job::Job;

#[cfg(feature = "gpu")]
mod gpu;
#[cfg(not(feature = "gpu"))]
#[path = "engine/without_gpu.rs"]
mod gpu;

pub(crate) use gpu::devices;

/// A renderer of a scene on the engine that the job asks for, and its name.
pub(crate) fn renderer(job: &Job, scene: &Scene) -> Result<(Renderer, String), Failure> {
    match job.flags.engine {
        EngineKind::Cpu => Ok(on_cpu(job)),
        EngineKind::Gpu => gpu::open(job.flags.device.as_deref().unwrap_or_default()),
        EngineKind::Auto => match found(job, scene) {
            Ok(renderer) => Ok(renderer),
            Err(why) => {
                if !job.flags.quiet {
                    say(format_args!("note: rendering on the CPU: {why}"));
                }
                Ok(on_cpu(job))
            }
        },
    }
}

/// A renderer on the first GPU, or the reason why there is none.
fn found(job: &Job, scene: &Scene) -> Result<(Renderer, String), String> {
    if job.settings.smooth_terminator {
        return Err("it alone has smooth terminators".to_owned());
    }
    if scene.has_marks() {
        return Err("it alone draws points and lines".to_owned());
    }
    job.settings.structure.check_on_gpu().map_err(|error| error.to_string())?;
    gpu::first(job.flags.device.as_deref().unwrap_or_default())
}

fn on_cpu(job: &Job) -> (Renderer, String) {
    let simd = job.flags.simd.unwrap_or_default();
    (Renderer::with_simd_level(simd), format!("CPU with {simd}"))
}
