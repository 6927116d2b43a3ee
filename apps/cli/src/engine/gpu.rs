//! Renderers on GPUs, and the list of adapters.

use serde_json::{Value, json};
use umbrage::Renderer;
use umbrage::gpu::{Adapter, DeviceLimits, Gpu};

use crate::failure::Failure;
use crate::info::json_text;

/// Opens the first adapter with `name` in its name, and returns its description.
pub(super) fn open(name: &str) -> Result<(Renderer, String), Failure> {
    let gpu = Gpu::open(name, DeviceLimits::Adapter).map_err(|error| {
        Failure::input(error.to_string(), "`umbrage info --devices` lists adapters; `--engine cpu` needs none")
    })?;
    let Adapter { name, driver, backend, .. } = gpu.adapter();
    let about = format!("{name} ({backend}, {driver})");
    Ok((Renderer::with_gpu(gpu)?, about))
}

/// As [`open`], or the reason why there is no such GPU. Software adapters are refused, since the CPU engine is faster.
pub(super) fn first(wanted: &str) -> Result<(Renderer, String), String> {
    let all = Adapter::all();
    let is_wanted = |adapter: &&Adapter| adapter.name.to_lowercase().contains(&wanted.to_lowercase());
    match all.iter().find(is_wanted) {
        Some(adapter) if !adapter.is_software => {
            open(wanted).map_err(|failure| format!("{}: {}", adapter.name, failure.message()))
        }
        Some(adapter) => Err(format!("{} is no GPU but a program on the CPU", adapter.name)),
        None if wanted.is_empty() => Err("no GPU was found".to_owned()),
        None => Err(format!("no adapter has \"{wanted}\" in its name")),
    }
}

/// Lists the adapters.
pub(crate) fn devices(as_json: bool) -> Result<String, Failure> {
    let all = Adapter::all();
    if as_json {
        let listed = all.iter().map(|Adapter { name, driver, backend, is_software }| {
            json!({ "name": name, "driver": driver, "backend": backend, "is_software": is_software })
        });
        return json_text(&listed.collect::<Value>());
    }
    if all.is_empty() {
        return Ok(
            "No GPU, and no program that stands in for one. A Vulkan driver may be missing; on Debian, the package\n\
                   mesa-vulkan-drivers has one in software.\n"
                .to_owned(),
        );
    }
    let lines = all.iter().map(|Adapter { name, driver, backend, is_software }| {
        let kind = if *is_software { "a program on the CPU" } else { "a GPU" };
        format!("{name}\n    {kind}, {backend}, {driver}\n")
    });
    Ok(lines.collect())
}
