use bytemuck::{Pod, Zeroable};
use glam::Affine3A;

use super::{PoseShape, RigTables};
use crate::{Buffer, Gpu, GpuError, Groups, Kernel};

/// The stage `pose`: computes each vertex of a rig in a pose.
///
/// Positions have the same bits as on the CPU, at the price of integer arithmetic.
#[derive(Debug)]
pub struct Pose {
    kernel: Kernel,
    size: Buffer,
    parts: Buffer,
    shapes: Buffer,
    vertices: Buffer,
    deltas: Buffer,
    /// Weights, then matrices.
    motion: Buffer,
    part_count: u32,
    all_posed: u32,
    moving_posed: u32,
    vertex_count: u32,
    /// Vertices that the next dispatch poses.
    posed: u32,
    /// Whether parts that don't move have been posed.
    is_still_posed: bool,
}

/// Words of a buffer for a pose's normals and tangents: those of the first vertex.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PosedAttributes {
    /// Of normals, three words each; `None` if the scene has none.
    pub normal_word: Option<u32>,
    /// Of tangents, four words each; `None` if the scene has none. A scene without normals has no tangents.
    pub tangent_word: Option<u32>,
}

/// Sizes of a dispatch, as in `pose.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct PoseSize {
    /// Number of vertices to pose.
    pub(crate) vertices: u32,
    /// Number of parts.
    pub(crate) parts: u32,
    /// First word of the matrices.
    pub(crate) matrix_word: u32,
    /// First word of the normals, or [`PoseShape::NO_ATTRIBUTE`].
    pub(crate) normal_word: u32,
    /// First word of the tangents, or [`PoseShape::NO_ATTRIBUTE`].
    pub(crate) tangent_word: u32,
}

impl Pose {
    /// Vertices of a workgroup.
    const WIDTH: u32 = 64;

    /// Makes a stage without a rig.
    #[must_use]
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            kernel: Kernel::new(gpu, "pose::pose", "pose", &[]),
            size: Buffer::uniform(gpu, "pose size"),
            parts: Buffer::storage(gpu, "parts"),
            shapes: Buffer::storage(gpu, "shapes"),
            vertices: Buffer::storage(gpu, "vertices of shapes"),
            deltas: Buffer::storage(gpu, "morph targets"),
            motion: Buffer::storage(gpu, "matrices and weights"),
            part_count: 0,
            all_posed: 0,
            moving_posed: 0,
            vertex_count: 0,
            posed: 0,
            is_still_posed: false,
        }
    }

    /// Uploads a rig. The next pose computes all vertices, later ones only those of moving parts.
    ///
    /// # Errors
    /// If one of its tables exceeds the largest buffer of the device; there is no rig then.
    pub fn set_rig(&mut self, gpu: &Gpu, rig: &RigTables) -> Result<(), GpuError> {
        (self.part_count, self.all_posed, self.moving_posed, self.vertex_count) = (0, 0, 0, 0);
        self.is_still_posed = false;
        self.parts.write(gpu, &rig.parts)?;
        self.shapes.write(gpu, &rig.shapes)?;
        self.vertices.write(gpu, &rig.vertices)?;
        self.deltas.write(gpu, &rig.deltas)?;
        self.part_count = rig.parts.len() as u32;
        (self.all_posed, self.moving_posed) = (rig.posed, rig.moving_posed);
        self.vertex_count = rig.end;
        Ok(())
    }

    /// Number of vertices of the rig.
    #[must_use]
    pub fn vertex_count(&self) -> u32 {
        self.vertex_count
    }

    /// Uploads a pose: the weights of all morph targets, and matrices. Only the first `moving` matrices may differ from
    /// the rig's last pose.
    ///
    /// # Errors
    /// If they exceed the largest buffer of the device.
    ///
    /// # Panics
    /// If there are fewer than `moving` matrices.
    pub fn prepare(
        &mut self,
        gpu: &Gpu,
        matrices: &[Affine3A],
        moving: usize,
        weights: &[f32],
        attributes: PosedAttributes,
    ) -> Result<(), GpuError> {
        self.posed = if self.is_still_posed { self.moving_posed } else { self.all_posed };
        if self.posed == 0 {
            return Ok(());
        }
        let matrices = if self.is_still_posed { &matrices[..moving] } else { matrices };
        let mut motion = weights.to_vec();
        motion.extend(matrices.iter().flat_map(Affine3A::to_cols_array));
        self.motion.write(gpu, &motion)?;
        let size = PoseSize {
            vertices: self.posed,
            parts: self.part_count,
            matrix_word: weights.len() as u32,
            normal_word: attributes.normal_word.unwrap_or(PoseShape::NO_ATTRIBUTE),
            tangent_word: attributes.tangent_word.unwrap_or(PoseShape::NO_ATTRIBUTE),
        };
        self.size.write(gpu, &[size])?;
        self.is_still_posed = true;
        Ok(())
    }

    /// Records the stage: three f32 of each vertex go to `positions`, normals and tangents to `attributes`.
    pub fn record(&self, gpu: &Gpu, pass: &mut wgpu::ComputePass<'_>, positions: &Buffer, attributes: &Buffer) {
        let Self { size, parts, shapes, vertices, deltas, motion, .. } = self;
        let buffers = [size, parts, shapes, vertices, deltas, motion, positions, attributes];
        self.kernel.dispatch(gpu, pass, &buffers, Groups::Flat(self.posed.div_ceil(Self::WIDTH)));
    }

    /// Bytes on the GPU.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        let buffers = [&self.parts, &self.shapes, &self.vertices, &self.deltas, &self.motion];
        buffers.into_iter().map(Buffer::bytes).sum()
    }
}
