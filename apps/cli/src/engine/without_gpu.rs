//! What is said where the command is compiled without the feature `gpu`.

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
