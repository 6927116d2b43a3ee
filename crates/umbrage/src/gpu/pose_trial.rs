//! A rig's vertices as a GPU poses them, for the tests that compare them with the CPU's.

use std::sync::Arc;

use glam::{Vec3, Vec4};
use umbrage_gpu::pose::{Pose, PosedAttributes};
use umbrage_gpu::{Buffer, Gpu, GpuError, Recorder};
use umbrage_scene::rig::{self, Rig};

use super::rig::tables;

/// Poses rigs on a GPU.
#[derive(Debug)]
pub struct PoseTrial {
    gpu: Gpu,
    stage: Pose,
    on_gpu: Option<Arc<Rig>>,
    positions: Buffer,
    attributes: Buffer,
}

/// A rig's vertices, fetched.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PosedVertices {
    /// Of each vertex.
    pub positions: Vec<Vec3>,
    /// Of each vertex; empty where the rig has none.
    pub normals: Vec<Vec3>,
    /// Of each vertex; empty where the rig has none.
    pub tangents: Vec<Vec4>,
    /// How long that took on the GPU; zero where it can't tell.
    pub milliseconds: f64,
}

impl PoseTrial {
    /// Ready to pose.
    #[must_use]
    pub fn new(gpu: Gpu) -> Self {
        Self {
            stage: Pose::new(&gpu),
            on_gpu: None,
            positions: Buffer::storage(&gpu, "positions"),
            attributes: Buffer::storage(&gpu, "vertex attributes"),
            gpu,
        }
    }

    /// The vertices of a rig in a pose. Where the rig is that of the last call, only those that move are posed.
    ///
    /// # Errors
    /// Where the rig is larger than the device allows.
    pub fn pose(&mut self, rig: &Arc<Rig>, pose: &rig::Pose) -> Result<PosedVertices, GpuError> {
        let Self { gpu, stage, positions, attributes, .. } = self;
        if !self.on_gpu.as_ref().is_some_and(|old| Arc::ptr_eq(old, rig)) {
            self.on_gpu = None;
            positions.reserve(gpu, 12 * rig.vertices as u64)?;
            attributes.reserve(gpu, 28 * rig.vertices as u64)?;
            stage.set_rig(gpu, &tables(rig))?;
            self.on_gpu = Some(Arc::clone(rig));
        }
        let places = PosedAttributes {
            normal_word: rig.has_normals.then_some(0),
            tangent_word: rig.has_tangents.then_some(3 * rig.vertices as u32),
        };
        stage.prepare(gpu, &pose.matrices, rig.moving_matrices, &pose.weights, places)?;
        let mut recorder = Recorder::new(gpu);
        recorder.stage("pose", |pass| stage.record(gpu, pass, positions, attributes));
        let times = recorder.submit()()?;
        let vertices = rig.vertices;
        let words: Vec<f32> = attributes.read(gpu, 7 * vertices)?;
        let (normals, tangents) = words.split_at(3 * vertices);
        Ok(PosedVertices {
            positions: positions.read::<[f32; 3]>(gpu, vertices)?.into_iter().map(Vec3::from).collect(),
            normals: normals.as_chunks().0.iter().filter(|_| rig.has_normals).map(|&of| Vec3::from_array(of)).collect(),
            tangents: tangents
                .as_chunks()
                .0
                .iter()
                .filter(|_| rig.has_tangents)
                .map(|&of| Vec4::from_array(of))
                .collect(),
            milliseconds: times.iter().map(|stage| stage.milliseconds).sum(),
        })
    }
}
