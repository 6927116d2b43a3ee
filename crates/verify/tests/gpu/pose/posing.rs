//! The stage `pose` alone.

use std::sync::Arc;

use glam::{Vec3, Vec4};
use umbrage::gpu::{Gpu, GpuError, rig_tables};
use umbrage::scene::rig::{Pose, Rig};
use umbrage_gpu::pose::{Pose as PoseStage, PosedAttributes};
use umbrage_gpu::{Buffer, Recorder};

/// Poses rigs on a GPU, as the engine does, and fetches the vertices. No renderer does that, since its
/// [`frame`](umbrage::Renderer::frame) is posed on the CPU.
pub(crate) struct Posing {
    gpu: Gpu,
    stage: PoseStage,
    on_gpu: Option<Arc<Rig>>,
    positions: Buffer,
    attributes: Buffer,
}

/// A rig's vertices, fetched.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct PosedVertices {
    pub(crate) positions: Vec<Vec3>,
    /// One for each vertex; empty if the rig has none.
    pub(crate) normals: Vec<Vec3>,
    /// One for each vertex; empty if the rig has none.
    pub(crate) tangents: Vec<Vec4>,
    /// GPU time in milliseconds; zero if it can't tell.
    pub(crate) milliseconds: f64,
}

impl Posing {
    pub(crate) fn new(gpu: Gpu) -> Self {
        Self {
            stage: PoseStage::new(&gpu),
            on_gpu: None,
            positions: Buffer::storage(&gpu, "positions"),
            attributes: Buffer::storage(&gpu, "vertex attributes"),
            gpu,
        }
    }

    /// The vertices of a rig in a pose. If the rig is that of the last call, only moving vertices are posed.
    pub(crate) fn pose(&mut self, rig: &Arc<Rig>, pose: &Pose) -> Result<PosedVertices, GpuError> {
        let Self { gpu, stage, positions, attributes, .. } = self;
        if !self.on_gpu.as_ref().is_some_and(|old| Arc::ptr_eq(old, rig)) {
            self.on_gpu = None;
            positions.reserve(gpu, 12 * rig.vertices as u64)?;
            attributes.reserve(gpu, 28 * rig.vertices as u64)?;
            stage.set_rig(gpu, &rig_tables(rig))?;
            self.on_gpu = Some(Arc::clone(rig));
        }
        let places = PosedAttributes {
            normal_word: rig.has_normals.then_some(0),
            tangent_word: rig.has_tangents.then_some(3 * rig.vertices as u32),
        };
        stage.prepare(gpu, &pose.matrices, rig.moving_matrices, &pose.weights, places)?;
        let mut recorder = Recorder::new(gpu);
        recorder.stage("pose", |pass| stage.record(gpu, pass, positions, attributes));
        let times = recorder.submit_and_wait()?.times;
        let vertices = rig.vertices;
        let words: Vec<f32> = attributes.read(gpu, 7 * vertices)?;
        let (normals, tangents) = words.split_at(3 * vertices);
        let normals = normals.as_chunks().0.iter().filter(|_| rig.has_normals).map(|&of| Vec3::from_array(of));
        let tangents = tangents.as_chunks().0.iter().filter(|_| rig.has_tangents).map(|&of| Vec4::from_array(of));
        Ok(PosedVertices {
            positions: positions.read::<[f32; 3]>(gpu, vertices)?.into_iter().map(Vec3::from).collect(),
            normals: normals.collect(),
            tangents: tangents.collect(),
            milliseconds: times.iter().map(|stage| stage.milliseconds).sum(),
        })
    }
}
