//! In place of `gpu.rs` in a command without that feature: every question fails, with the command that brings it.

use umbrage::Renderer;

use crate::failure::Failure;
use crate::feature::Feature;

pub(super) fn open(_name: &str) -> Result<(Renderer, String), Failure> {
    Err(Failure::without(Feature::Gpu))
}

pub(super) fn first(_wanted: &str) -> Result<(Renderer, String), String> {
    Err(format!("{}; {}", Feature::Gpu.lack(), Feature::Gpu.remedy()))
}

pub(crate) fn devices(_as_json: bool) -> Result<String, Failure> {
    Err(Failure::without(Feature::Gpu))
}
