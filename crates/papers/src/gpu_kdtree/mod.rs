//! The frames of Horn et al., *Interactive k-D Tree GPU Raytracing* (2007), through the finder's stages
//! ([`KdSight`](crate::KdSight)): with mirrors, and in the paper's hybrid form.
//!
//! `frame` makes its rays on the GPU: `eye` the camera's, `bounce` the mirrored rays and the shadow questions, whose
//! answers `lighten` adds to the film. In the paper's hybrid frames `raster` finds primary hits instead, and `surface`
//! their positions.

mod frame;
mod raster;

use umbrage_gpu::internals::link_with;

pub use frame::{KdFrame, KdMaterial, KdPrimary, KdScenery};

/// Every module's path and text; they import those of `umbrage-gpu` as well.
const MODULES: &[(&str, &str)] = &[
    ("kdtree::bounce", include_str!("bounce.wgsl")),
    ("kdtree::eye", include_str!("eye.wgsl")),
    ("kdtree::lighten", include_str!("lighten.wgsl")),
    ("kdtree::raster", include_str!("raster.wgsl")),
    ("kdtree::surface", include_str!("surface.wgsl")),
];

/// A shader's whole text.
fn link(path: &str) -> String {
    link_with(MODULES, path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_module_links_and_is_valid_wgsl() {
        for (path, _) in MODULES {
            crate::kdtree::gpu::validate(path, &link(path));
        }
    }
}
