//! Finds the shadows of a light that sees by angles (Guntury and Narayanan 2010, §4.1): one grid for a light anywhere.
//! Stages have the names, and the buffers, of those of a light with faces.

use crate::grid::{ListKernels, Project};
use crate::{Gpu, Kernel};

/// The stages that differ from those of a light with faces.
#[derive(Debug)]
pub(super) struct Sphere {
    pub(super) choose: Kernel,
    pub(super) map: Kernel,
    pub(super) bin: Kernel,
    pub(super) sort: Kernel,
    pub(super) project: Kernel,
    pub(super) list: ListKernels,
    pub(super) trace: Kernel,
}

impl Sphere {
    /// Records of a vertex.
    pub(super) const VERTEX_RECORDS: u32 = 2;

    pub(super) fn new(gpu: &Gpu) -> Self {
        let has_angles = ("HAS_ANGLES", 1.0);
        let [map, bin] = Kernel::all(gpu, "light::sphere::map", ["map", "bin"], &[]);
        Self {
            choose: Kernel::new(gpu, "light::sphere::choose", "choose", &[]),
            map,
            bin,
            sort: Kernel::new(gpu, "light::sort", "sort", &[has_angles]),
            project: Kernel::new(gpu, Project::MODULE, "project", &[has_angles]),
            list: ListKernels::new(gpu, &[("HAS_POINTS", 1.0), has_angles]),
            trace: Kernel::new(gpu, "light::sphere::trace", "trace", &[]),
        }
    }
}
