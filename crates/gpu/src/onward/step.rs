use bytemuck::{Pod, Zeroable};

use super::Onward;
use crate::rays::RayRecords;
use crate::{Buffer, Gpu, GpuError, Groups};

/// A generation of rays: the camera's, or secondary ones.
#[derive(Debug)]
pub(super) struct Step {
    pub(super) parameters: Buffer,
    pub(super) records: RayRecords,
    pub(super) paths: Buffer,
    /// Their hit points.
    pub(super) points: Buffer,
    pub(super) count: u32,
    pub(super) is_first: bool,
}

/// Parameters as in `step.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct OnwardStep {
    pub(super) count: u32,
    pub(super) is_first: u32,
    pub(super) size: [u32; 2],
    pub(super) ways_plane: u32,
    pub(super) ways: u32,
    pub(super) is_asked_first: u32,
    pub(super) flat_plane: u32,
    pub(super) flat_plane_of_film: u32,
    pub(super) unused: u32,
}

impl Step {
    const POINT_BYTES: u64 = 48;
    const PATH_BYTES: u64 = 64;

    pub(super) fn new(gpu: &Gpu) -> Self {
        Self {
            parameters: Buffer::uniform(gpu, "generation"),
            records: RayRecords::new(gpu),
            paths: Buffer::storage(gpu, "paths"),
            points: Buffer::storage(gpu, "points of rays"),
            count: 0,
            is_first: false,
        }
    }

    /// Writes the parameters and reserves memory.
    pub(super) fn write(&mut self, gpu: &Gpu, parameters: OnwardStep) -> Result<(), GpuError> {
        (self.count, self.is_first) = (parameters.count, parameters.is_first != 0);
        self.parameters.write(gpu, &[parameters])?;
        self.points.reserve(gpu, Self::POINT_BYTES * u64::from(self.count))?;
        // The camera's rays have no paths, and are stored only if some may go straight on.
        let [records, paths] = match self.is_first {
            true if parameters.ways < Onward::ALL_WAYS => [0, 1],
            true => [self.count, 1],
            false => [self.count; 2],
        };
        self.records.reserve(gpu, records)?;
        self.paths.reserve(gpu, Self::PATH_BYTES * u64::from(paths))
    }

    pub(super) fn groups(&self) -> Groups<'_> {
        Groups::Flat(self.count.div_ceil(64))
    }

    pub(super) fn bytes(&self) -> u64 {
        [self.records.buffer(), &self.paths, &self.points].into_iter().map(Buffer::bytes).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::{differences, layout, module};
    use crate::link::link;

    #[test]
    fn parameters_are_those_of_the_shaders() {
        let layout = layout!(OnwardStep {
            count,
            is_first,
            size,
            ways_plane,
            ways,
            is_asked_first,
            flat_plane,
            flat_plane_of_film
        });
        for path in ["onward::count", "onward::locate", "onward::send", "onward::add"] {
            assert_eq!(differences(&module(&link(path)), &layout), [""; 0], "{path}");
        }
    }
}
