use glam::Vec3;
use umbrage_rays::Opacity as _;
use umbrage_scene::Frame;

use crate::Error;
use crate::packet::WIDTH;

/// One frame's triangles in buffers that Embree reads in place.
///
/// Triangles that rays must be asked about are a geometry of their own, so that the others go without a filter.
#[derive(Debug)]
pub struct Posed {
    /// One more than the frame has: Embree may read 16 bytes for each.
    positions: Vec<Vec3>,
    opaque: Vec<[u32; 3]>,
    /// Ids of the opaque triangles; empty where all triangles are opaque.
    opaque_ids: Vec<u32>,
    asked: Option<Asked>,
}

/// Triangles whose hits count only where the frame says so.
#[derive(Debug)]
pub(crate) struct Asked {
    /// Whom to ask.
    pub(crate) frame: Frame,
    /// Three vertex indices for each triangle, all in range.
    pub(crate) indices: Vec<[u32; 3]>,
    /// Their ids in the frame.
    pub(crate) ids: Vec<u32>,
}

impl Posed {
    /// The bit of a name that says whether the triangle is asked about.
    const ASKED: u32 = 31;

    /// Copies a frame's triangles; with `masks` rays ask it about those that aren't wholly opaque.
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

    /// The id in the frame of a triangle that [`Image::seen`](crate::Image::seen) has named.
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

    /// One number for each hit of a packet, from Embree's numbers for the triangle and the geometry; all ones for none.
    #[inline(always)]
    #[must_use]
    pub fn names(primitives: &[u32; WIDTH], geometries: &[u32; WIDTH]) -> [u32; WIDTH] {
        std::array::from_fn(|lane| Self::name(primitives[lane], geometries[lane]))
    }

    /// The same for one hit.
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

    /// The others.
    pub(crate) fn asked(&self) -> Option<&Asked> {
        self.asked.as_ref()
    }
}
