use std::sync::Arc;

use glam::{Vec3, Vec4};

use crate::{Frame, Materials, Mesh};

/// What a reader of a motionless file gives: the parts of a [`Frame`] that it fills.
#[derive(Clone, Debug, Default)]
pub(crate) struct Still {
    pub(crate) positions: Vec<Vec3>,
    pub(crate) normals: Vec<Vec3>,
    pub(crate) tangents: Vec<Vec4>,
    pub(crate) mesh: Arc<Mesh>,
    pub(crate) materials: Arc<Materials>,
    /// What the reader left out or guessed, for a person.
    pub(crate) warnings: Vec<String>,
}

impl Still {
    pub(crate) fn pose(&self, frame: &mut Frame) {
        frame.positions.clone_from(&self.positions);
        frame.normals.clone_from(&self.normals);
        frame.tangents.clone_from(&self.tangents);
        frame.mesh = Arc::clone(&self.mesh);
        frame.materials = Arc::clone(&self.materials);
    }
}
