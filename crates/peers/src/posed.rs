use glam::Vec3;
use umbrage_scene::Frame;

use crate::Error;

/// One frame's triangles in buffers that Embree reads in place.
#[derive(Debug)]
pub struct Posed {
    /// One more than the frame has: Embree may read 16 bytes for each.
    positions: Vec<Vec3>,
    indices: Vec<[u32; 3]>,
    /// Whom to ask about alpha masks; `None` where every triangle counts as opaque.
    pub(crate) masks: Option<Frame>,
}

impl Posed {
    /// Copies a frame's triangles; with `masks` rays ask it about its alpha masks.
    ///
    /// # Errors
    /// If a triangle has a vertex that is out of range.
    pub fn new(frame: &Frame, masks: bool) -> Result<Self, Error> {
        let indices = frame.mesh.triangles.clone();
        let count = frame.positions.len();
        if let Some(triangle) = indices.iter().position(|corners| corners.iter().any(|&at| at as usize >= count)) {
            return Err(Error::IndexOutOfRange { triangle });
        }
        let mut positions = Vec::with_capacity(count + 1);
        positions.extend_from_slice(&frame.positions);
        positions.push(Vec3::ZERO);
        // Asking costs Embree time: only where there is something to ask about.
        let asks = masks && (0..indices.len() as u32).any(|triangle| !frame.is_opaque(triangle));
        Ok(Self { positions, indices, masks: asks.then(|| frame.clone()) })
    }

    /// World position of each vertex.
    pub(crate) fn positions(&self) -> &[Vec3] {
        &self.positions[..self.positions.len() - 1]
    }

    /// Three places in the positions for each triangle, all in range.
    pub(crate) fn indices(&self) -> &[[u32; 3]] {
        &self.indices
    }
}
