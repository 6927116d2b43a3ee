use glam::Vec3;
use umbrage_rays::Opacity as _;
use umbrage_scene::Frame;

use crate::Error;
use crate::packet::WIDTH;

/// One frame's triangles in buffers that Embree reads in place.
///
/// Triangles that aren't opaque are a geometry of their own, so that the others have no filter.
#[derive(Debug)]
pub struct Posed {
    /// Has one more than the frame: Embree may read 16 bytes for each.
    positions: Vec<Vec3>,
    opaque: Vec<[u32; 3]>,
    /// Ids of the opaque triangles; empty if all triangles are opaque.
    opaque_ids: Vec<u32>,
    asked: Option<Asked>,
}

/// Triangles whose hits count only if the frame's opacity stops the ray.
#[derive(Debug)]
pub(crate) struct Asked {
    /// Frame with the opacities.
    pub(crate) frame: Frame,
    /// Three vertex indices for each triangle, all in range.
    pub(crate) indices: Vec<[u32; 3]>,
    /// Their ids in the frame.
    pub(crate) ids: Vec<u32>,
}

impl Posed {
    /// Bit of a triangle's name for the geometry: 1 if it isn't opaque.
    const ASKED: u32 = 31;

    /// Copies a frame's triangles; with `masks`, triangles that aren't wholly opaque get filters.
    ///
    /// # Errors
    /// If a triangle has a vertex that is out of range.
    pub fn new(frame: &Frame, masks: bool) -> Result<Self, Error> {
        let indices = &frame.mesh.triangles;
        let count = frame.positions.len();
        if let Some(triangle) = indices.iter().position(|corners| corners.iter().any(|&at| at as usize >= count)) {
            return Err(Error::IndexOutOfRange { triangle });
        }
        let mut positions = Vec::with_capacity(count + 1);
        positions.extend_from_slice(&frame.positions);
        positions.push(Vec3::ZERO);
        let (ids, opacity) = (0..indices.len() as u32, frame.shadow_opacity());
        let (opaque_ids, ids): (Vec<u32>, Vec<u32>) = ids.partition(|&id| !masks || opacity.is_opaque(id));
        let of = |ids: &[u32]| ids.iter().map(|&id| indices[id as usize]).collect();
        if ids.is_empty() {
            return Ok(Self { positions, opaque: indices.clone(), opaque_ids: Vec::new(), asked: None });
        }
        let asked = Asked { frame: frame.clone(), indices: of(&ids), ids };
        Ok(Self { positions, opaque: of(&opaque_ids), opaque_ids, asked: Some(asked) })
    }

    /// Id in the frame of the triangle with a name from [`Image::seen`](crate::Image::seen).
    ///
    /// # Panics
    /// If the name isn't one of this frame's.
    #[must_use]
    pub fn triangle(&self, name: u32) -> u32 {
        let primitive = (name & !(1 << Self::ASKED)) as usize;
        match &self.asked {
            None => name,
            Some(asked) if name >> Self::ASKED == 1 => asked.ids[primitive],
            Some(_) => self.opaque_ids[primitive],
        }
    }

    /// Names of a packet's hit triangles, from Embree's ids of triangles and geometries; all ones for a miss.
    #[inline(always)]
    #[must_use]
    pub fn names(primitives: &[u32; WIDTH], geometries: &[u32; WIDTH]) -> [u32; WIDTH] {
        std::array::from_fn(|lane| Self::name(primitives[lane], geometries[lane]))
    }

    /// Name of one hit triangle.
    #[inline(always)]
    pub(crate) fn name(primitive: u32, geometry: u32) -> u32 {
        primitive | geometry << Self::ASKED
    }

    /// World position of each vertex.
    pub(crate) fn positions(&self) -> &[Vec3] {
        &self.positions[..self.positions.len() - 1]
    }

    /// Three vertex indices for each opaque triangle, all in range.
    pub(crate) fn opaque(&self) -> &[[u32; 3]] {
        &self.opaque
    }

    /// The triangles that aren't wholly opaque, if there are any.
    pub(crate) fn asked(&self) -> Option<&Asked> {
        self.asked.as_ref()
    }
}
