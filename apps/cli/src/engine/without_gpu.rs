//! Replaces `gpu.rs` in builds without the feature: every call fails with the command that adds it.

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
