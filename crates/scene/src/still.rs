use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::Arc;

use glam::{Vec2, Vec3, Vec4};

use crate::{Animated, Error, Frame, Materials, Mesh};

/// What a reader of a motionless file gives.
#[derive(Clone, Debug, Default)]
pub(crate) struct Still {
    /// Without lights and cameras.
    pub(crate) frame: Frame,
    /// What the reader left out or guessed, for a person.
    pub(crate) warnings: Vec<String>,
    /// What was read for it.
    pub(crate) files: BTreeSet<PathBuf>,
}

/// What a frame's vertices are; lists that the file doesn't fill are empty.
#[derive(Debug, Default)]
pub(crate) struct Vertices {
    pub(crate) positions: Vec<Vec3>,
    pub(crate) normals: Vec<Vec3>,
    pub(crate) tex_coords: Vec<Vec2>,
    /// Linear.
    pub(crate) colors: Vec<Vec4>,
}

impl Vertices {
    /// The frame of triangles between these, without lights and cameras.
    pub(crate) fn into_frame(
        self,
        triangles: Vec<[u32; 3]>,
        material_of_triangle: Vec<u32>,
        materials: Arc<Materials>,
    ) -> Frame {
        let Self { positions, normals, tex_coords, colors } = self;
        let mesh =
            Mesh { triangles, material_of_triangle, tex_coords: [tex_coords, Vec::new()], colors, ..Mesh::default() };
        Frame { positions, normals, mesh: Arc::new(mesh), materials, ..Frame::default() }
    }
}

impl Animated for Still {
    fn duration_seconds(&self) -> f64 {
        0.0
    }

    fn pose(&self, _seconds: f64, frame: &mut Frame) -> Result<(), Error> {
        frame.copy_surfaces(&self.frame);
        Ok(())
    }

    fn warnings(&self) -> &[String] {
        &self.warnings
    }
}
