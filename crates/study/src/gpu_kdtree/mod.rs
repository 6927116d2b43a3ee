//! The frames of Horn et al., *Interactive k-D Tree GPU Raytracing* (2007), through [`umbrage_gpu::kdtree`]: with
//! mirrors, and in the paper's hybrid form.
//!
//! `frame` makes its rays on the GPU: `eye` the camera's, `bounce` the mirrored rays and the shadow questions, whose
//! answers `lighten` adds to the film. In the paper's hybrid frames `raster` finds primary hits instead, and `surface`
//! their positions.

mod frame;
mod raster;

use umbrage_gpu::internals::link_with;
use umbrage_gpu::{Gpu, Kernel};

pub use frame::{KdFrame, KdMaterial, KdPrimary, KdScenery};
pub use umbrage_gpu::kdtree::{KdNodes, KdTracerOptions};
pub use umbrage_gpu::rays::{RayRecords as KdRecords, RayTracer as KdTracer, RayTracerWork as KdTracerWork};

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

/// The entry point `entry` of a module, with values for its `override` constants.
fn kernel(gpu: &Gpu, path: &str, entry: &'static str, constants: &[(&str, f64)]) -> Kernel {
    Kernel::of_text(gpu, &link(path), entry, constants)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_module_links_and_is_valid_wgsl() {
        for (path, _) in MODULES {
            let text = link(path);
            let module = naga::front::wgsl::parse_str(&text).unwrap_or_else(|error| {
                panic!("{path}: {}", error.emit_to_string(&text));
            });
            let mut validator =
                naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::empty());
            validator.validate(&module).unwrap_or_else(|error| panic!("{path}: {}", error.emit_to_string(&text)));
        }
    }
}
