//! Which engine renders, and which adapters there are.

use umbrage::gpu::{Adapter, DeviceLimits, Gpu};
use umbrage::{EngineKind, Renderer};

use crate::failure::{Failure, say};
use crate::job::Job;

/// A renderer on the engine that the job asks for, and its name.
pub(crate) fn renderer(job: &Job) -> Result<(Renderer, String), Failure> {
    match job.flags.engine {
        EngineKind::Cpu => Ok(on_cpu(job)),
        EngineKind::Gpu => on_gpu(job.flags.device.as_deref().unwrap_or_default()),
        EngineKind::Auto => match found(job) {
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

/// On the first GPU, or why there is none. Software adapters don't count: the CPU engine is faster.
fn found(job: &Job) -> Result<(Renderer, String), String> {
    if job.settings.smooth_terminator {
        return Err("it alone has smooth terminators".to_owned());
    }
    job.settings.structure.check_on_gpu().map_err(|error| error.to_string())?;
    let wanted = job.flags.device.as_deref().unwrap_or_default();
    let all = Adapter::all();
    let is_wanted = |adapter: &&Adapter| adapter.name.to_lowercase().contains(&wanted.to_lowercase());
    match all.iter().find(is_wanted) {
        Some(adapter) if !adapter.is_software => {
            on_gpu(wanted).map_err(|failure| format!("{}: {}", adapter.name, failure.message()))
        }
        Some(adapter) => Err(format!("{} is no GPU but a program on the CPU", adapter.name)),
        None if wanted.is_empty() => Err("no GPU was found".to_owned()),
        None => Err(format!("no adapter has \"{wanted}\" in its name")),
    }
}

fn on_cpu(job: &Job) -> (Renderer, String) {
    let simd = job.flags.simd.unwrap_or_default();
    (Renderer::with_simd_level(simd), format!("CPU with {simd}"))
}

fn on_gpu(name: &str) -> Result<(Renderer, String), Failure> {
    let gpu = Gpu::open(name, DeviceLimits::Adapter).map_err(|error| {
        Failure::input(error.to_string(), "`umbrage info --devices` lists adapters; `--engine cpu` needs none")
    })?;
    let Adapter { name, driver, backend, .. } = gpu.adapter();
    let about = format!("{name} ({backend}, {driver})");
    Ok((Renderer::with_gpu(gpu)?, about))
}
