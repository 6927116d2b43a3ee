use crate::{Buffer, Gpu, GpuError, Groups, Kernel};

/// The stage `project`: maps each vertex to pixel space.
#[derive(Debug)]
pub(crate) struct Project {
    kernel: Kernel,
    size: Buffer,
    vertices: Buffer,
    count: u32,
}

impl Project {
    /// Bytes of a vertex in pixel space.
    pub(crate) const VERTEX_BYTES: u64 = 16;
    /// Path of the shader's module.
    pub(crate) const MODULE: &str = "grid::project";

    pub(crate) fn new(gpu: &Gpu) -> Self {
        Self {
            kernel: Kernel::new(gpu, Self::MODULE, "project", &[]),
            size: Buffer::uniform(gpu, "project size"),
            vertices: Buffer::storage(gpu, "vertices in pixel space"),
            count: 0,
        }
    }

    pub(crate) fn prepare(&mut self, gpu: &Gpu, vertices: u32, faces: u32) -> Result<(), GpuError> {
        self.count = vertices;
        self.size.write(gpu, &[vertices, 0, 0, 0])?;
        self.vertices.reserve(gpu, u64::from(vertices) * u64::from(faces) * Self::VERTEX_BYTES)
    }

    /// Workgroups for all vertices of one face.
    pub(crate) fn groups_of_one_face(&self) -> Groups<'static> {
        Groups::Flat(self.count.div_ceil(256))
    }

    /// Number of faces that there is room for.
    pub(crate) fn face_room(&self) -> u32 {
        let bytes_of_one = u64::from(self.count) * Self::VERTEX_BYTES;
        self.vertices.bytes().checked_div(bytes_of_one).map_or(u32::MAX, |faces| faces as u32)
    }

    /// Makes room for this many faces.
    pub(crate) fn grow(&mut self, gpu: &Gpu, faces: u32) -> Result<(), GpuError> {
        self.vertices.reserve(gpu, u64::from(self.count) * u64::from(faces) * Self::VERTEX_BYTES)
    }

    /// Records the stage, with its own kernel or with another that has the same buffers.
    pub(crate) fn record(
        &self,
        gpu: &Gpu,
        pass: &mut wgpu::ComputePass<'_>,
        kernel: Option<&Kernel>,
        [spaces, positions, header]: [&Buffer; 3],
        groups: Groups<'_>,
    ) {
        let buffers = [&self.size, spaces, positions, &self.vertices, header];
        kernel.unwrap_or(&self.kernel).dispatch(gpu, pass, &buffers, groups);
    }

    pub(crate) fn vertices(&self) -> &Buffer {
        &self.vertices
    }
}
