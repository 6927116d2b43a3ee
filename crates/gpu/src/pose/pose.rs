use bytemuck::{Pod, Zeroable};
use glam::Affine3A;

use super::{PoseShape, RigTables};
use crate::{Buffer, Gpu, GpuError, Groups, Kernel};

/// The stage `pose`: each vertex of a rig, where a pose has it.
///
/// Positions have the bits that the CPU gives them, at the price of arithmetic in integers.
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

/// Where in a buffer a pose's normals and tangents belong: the words of the first vertex.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PosedAttributes {
    /// Of normals, three words each; `None` where the scene has none.
    pub normal_word: Option<u32>,
    /// Of tangents, four words each; `None` where the scene has none. There are none without normals.
    pub tangent_word: Option<u32>,
}

/// What a dispatch poses, as in `pose.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct PoseSize {
    /// How many vertices.
    pub(crate) vertices: u32,
    /// How many parts there are.
    pub(crate) parts: u32,
    /// Where the matrices start.
    pub(crate) matrix_word: u32,
    /// Where normals go, or [`PoseShape::NO_ATTRIBUTE`].
    pub(crate) normal_word: u32,
    /// Where tangents go, or [`PoseShape::NO_ATTRIBUTE`].
    pub(crate) tangent_word: u32,
}

impl Pose {
    /// Vertices that a workgroup takes.
    const WIDTH: u32 = 64;

    /// Without a rig.
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

    /// Takes over a rig. The next pose is one of all vertices, later ones are of those that move.
    ///
    /// # Errors
    /// Where one of its tables is larger than a buffer of the device may be; there is no rig then.
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

    /// How many vertices the rig has.
    #[must_use]
    pub fn vertex_count(&self) -> u32 {
        self.vertex_count
    }

    /// Takes over a pose: the weights of all morph targets, and matrices, of which only the first `moving` may be others
    /// than in the rig's last pose.
    ///
    /// # Errors
    /// Where they are more than a buffer of the device may hold.
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

    /// Poses vertices: three f32 of each into `positions`, normals and tangents into `attributes`.
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
