//! Uploads a scene's rig, whose vertices the GPU poses.

use std::mem;
use std::sync::{Arc, OnceLock};

use umbrage_gpu::pose::{self, Influences, RigPart, RigShape, RigTables, RigTarget};
use umbrage_gpu::shade::Shade;
use umbrage_gpu::{Done, Geometry, Gpu, GpuError, Omit, Recorder};
use umbrage_rays::Omitted;
use umbrage_scene::rig::{Deltas, Placement, Pose, Rig, Shape};
use umbrage_scene::{Frame, Scene};

/// The rig of the last frame's scene, if there is one, and the stages that pose it.
#[derive(Debug)]
pub(super) struct FrameRig {
    stage: pose::Pose,
    omit: Omit,
    /// The posed triangles that no ray can hit.
    omitted: Omitted,
    pose: Pose,
    /// The rig that moves the last frame's vertices.
    rig: Option<Arc<Rig>>,
    /// The rig whose tables and posed vertices are on the GPU.
    on_gpu: Option<Arc<Rig>>,
    /// Whether the last frame's vertices must still be posed.
    is_due: bool,
    /// The last frame with its vertices, made on request.
    whole: OnceLock<Frame>,
}

impl FrameRig {
    pub(super) fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        Ok(Self {
            stage: pose::Pose::new(gpu),
            omit: Omit::new(gpu)?,
            omitted: Omitted::default(),
            pose: Pose::default(),
            rig: None,
            on_gpu: None,
            is_due: false,
            whole: OnceLock::new(),
        })
    }

    /// Poses a frame at a moment, without vertices where a rig moves them.
    ///
    /// # Errors
    /// Where the scene can't be posed.
    pub(super) fn animate(
        &mut self,
        scene: &Scene,
        seconds: f64,
        frame: &mut Frame,
    ) -> Result<(), umbrage_scene::Error> {
        self.whole.take();
        self.rig = scene.pose_rig(seconds, frame, &mut self.pose)?;
        if self.rig.is_none() { scene.pose(seconds, frame) } else { Ok(()) }
    }

    /// Forgets the rig: the next frame has vertices of its own.
    pub(super) fn leave(&mut self) {
        self.whole.take();
        self.rig = None;
    }

    /// Fills in the vertices of a frame without any, posed on the CPU.
    pub(super) fn pose_on_cpu(&self, frame: &mut Frame) {
        if let Some(rig) = &self.rig {
            rig.pose(&self.pose, frame);
        }
    }

    /// The rig that moves the last frame's vertices; `None` where they are the frame's own.
    pub(super) fn rig(&self) -> Option<&Arc<Rig>> {
        self.rig.as_ref()
    }

    /// The last frame with its vertices.
    pub(super) fn whole<'a>(&'a self, frame: &'a Frame) -> &'a Frame {
        if self.rig.is_none() || !frame.positions.is_empty() {
            return frame;
        }
        self.whole.get_or_init(|| {
            let mut frame = frame.clone();
            self.pose_on_cpu(&mut frame);
            frame
        })
    }

    /// Forgets the state of the GPU, so that everything is uploaded again.
    pub(super) fn forget(&mut self) {
        self.on_gpu = None;
    }

    /// Uploads the pose, and the rig itself where it is new. There is room for the vertices already.
    ///
    /// # Errors
    /// Where the rig's tables are larger than the device allows.
    pub(super) fn prepare(&mut self, gpu: &Gpu, geometry: &Geometry, shade: &Shade) -> Result<(), GpuError> {
        self.is_due = false;
        let Some(rig) = &self.rig else {
            // Other vertices take the memory of the posed ones now.
            self.on_gpu = None;
            return Ok(());
        };
        let is_new = !self.on_gpu.as_ref().is_some_and(|old| Arc::ptr_eq(old, rig));
        if is_new {
            self.on_gpu = None;
            self.stage.set_rig(gpu, &tables(rig))?;
        } else if rig.parts.iter().all(|part| !part.moves) {
            return Ok(());
        }
        let Pose { matrices, weights } = &self.pose;
        self.stage.prepare(gpu, matrices, rig.moving_matrices, weights, shade.posed_attributes().1)?;
        self.omit.prepare(gpu, geometry)?;
        self.is_due = true;
        Ok(())
    }

    /// Poses the vertices if they are due, and finds the triangles that no ray can hit then.
    pub(super) fn record(&mut self, gpu: &Gpu, recorder: &mut Recorder<'_>, geometry: &Geometry, shade: &Shade) {
        if self.is_due {
            let (attributes, _) = shade.posed_attributes();
            recorder.stage("pose", |pass| self.stage.record(gpu, pass, geometry.positions(), attributes));
            self.omit.record(gpu, recorder, geometry);
        }
    }

    /// Takes the results once the commands are done.
    ///
    /// # Errors
    /// Where the device is lost.
    pub(super) fn finish(&mut self, done: &Done) -> Result<(), GpuError> {
        if mem::take(&mut self.is_due) {
            self.omitted = self.omit.omitted(done)?;
        }
        // The rig is held, so that no other one takes its address.
        self.on_gpu.clone_from(&self.rig);
        Ok(())
    }

    /// The last frame's triangles that no ray can hit.
    pub(super) fn omitted(&self, frame: &Frame) -> Omitted {
        if self.rig.is_some() { self.omitted.clone() } else { frame.triangles().omitted() }
    }

    /// Bytes of the rig's tables on the GPU.
    pub(super) fn bytes(&self) -> u64 {
        if self.rig.is_some() { self.stage.bytes() } else { 0 }
    }
}

/// A rig's tables for the stage `pose`.
#[must_use]
pub fn tables(rig: &Rig) -> RigTables {
    let parts = rig.parts.iter().map(|part| {
        let (matrix, is_skinned) = match part.placement {
            Placement::Rigid { matrix } => (matrix, false),
            Placement::Skinned { first_matrix } => (first_matrix, true),
        };
        RigPart {
            shape: part.shape,
            first_vertex: part.first_vertex,
            first_weight: part.first_weight,
            matrix,
            is_skinned,
            moves: part.moves,
        }
    });
    RigTables::new(rig.shapes.iter().map(|of| shape(of)), &parts.collect::<Vec<_>>())
}

fn shape(shape: &Shape) -> RigShape<'_> {
    let sets = shape.influences.iter().map(|set| {
        let influences = set.iter().map(|of| Influences { joints: of.joints, weights: of.weights });
        influences.collect()
    });
    let targets = shape.morph_targets.iter().map(|target| RigTarget {
        positions: deltas(&target.positions),
        normals: deltas(&target.normals),
        tangents: deltas(&target.tangents),
    });
    RigShape {
        positions: &shape.positions,
        normals: &shape.normals,
        tangents: &shape.tangents,
        influences: sets.collect(),
        targets: targets.collect(),
    }
}

fn deltas(deltas: &Deltas) -> pose::Deltas<'_> {
    match deltas {
        Deltas::Dense(deltas) => pose::Deltas::Dense(deltas),
        Deltas::Sparse { vertices, deltas } => pose::Deltas::Sparse(vertices, deltas),
    }
}
