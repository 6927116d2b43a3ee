use glam::Vec3;
use umbrage_rays::Triangles;

use crate::{Buffer, Gpu, GpuError, Masks};

/// A scene's triangles on the GPU, where they stay from frame to frame.
#[derive(Debug)]
pub struct Geometry {
    positions: Buffer,
    triangles: Buffer,
    masks: Masks,
    vertex_count: u32,
    triangle_count: u32,
}

impl Geometry {
    /// Makes empty geometry.
    #[must_use]
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            positions: Buffer::storage(gpu, "positions"),
            triangles: Buffer::storage(gpu, "triangles"),
            masks: Masks::new(gpu),
            vertex_count: 0,
            triangle_count: 0,
        }
    }

    /// Uploads a scene: vertices, triangles and a number for each triangle (see [`TriangleFlags`](crate::TriangleFlags)).
    ///
    /// # Errors
    /// If they exceed the largest buffer of the device.
    pub fn write(&mut self, gpu: &Gpu, triangles: Triangles<'_>, number: impl Fn(u32) -> u32) -> Result<(), GpuError> {
        self.write_triangles(gpu, triangles.indices, number)?;
        self.write_positions(gpu, triangles.positions)
    }

    /// Uploads triangles, with a number for each, but no positions.
    ///
    /// # Errors
    /// If they exceed the largest buffer of the device.
    pub fn write_triangles(
        &mut self,
        gpu: &Gpu,
        triangles: &[[u32; 3]],
        number: impl Fn(u32) -> u32,
    ) -> Result<(), GpuError> {
        let records = triangles.iter().zip(0..).map(|(&[a, b, c], id)| [a, b, c, number(id)]);
        let records: Vec<[u32; 4]> = records.collect();
        self.triangle_count = records.len() as u32;
        self.triangles.write(gpu, &records)
    }

    /// Makes room for the positions of `count` vertices, which a stage writes. If the buffer is large enough already,
    /// its positions stay.
    ///
    /// # Errors
    /// If they exceed the largest buffer of the device.
    pub fn reserve_positions(&mut self, gpu: &Gpu, count: u32) -> Result<(), GpuError> {
        self.vertex_count = count;
        self.positions.reserve(gpu, u64::from(count) * size_of::<Vec3>() as u64)
    }

    /// Uploads the vertices' current positions.
    ///
    /// # Errors
    /// If they exceed the largest buffer of the device.
    pub fn write_positions(&mut self, gpu: &Gpu, positions: &[Vec3]) -> Result<(), GpuError> {
        self.vertex_count = positions.len() as u32;
        self.positions.write(gpu, positions)
    }

    /// Number of vertices.
    #[must_use]
    pub fn vertex_count(&self) -> u32 {
        self.vertex_count
    }

    /// Number of triangles.
    #[must_use]
    pub fn triangle_count(&self) -> u32 {
        self.triangle_count
    }

    /// Positions: three f32 for each vertex.
    #[must_use]
    pub fn positions(&self) -> &Buffer {
        &self.positions
    }

    /// Triangles: four u32 for each, its vertices and its number.
    #[must_use]
    pub fn triangles(&self) -> &Buffer {
        &self.triangles
    }

    /// Opacity masks of masked triangles.
    #[must_use]
    pub fn masks(&self) -> &Masks {
        &self.masks
    }

    /// Opacity masks, to write them.
    pub fn masks_mut(&mut self) -> &mut Masks {
        &mut self.masks
    }

    /// Bytes on the GPU.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.positions.bytes() + self.triangles.bytes()
    }
}
