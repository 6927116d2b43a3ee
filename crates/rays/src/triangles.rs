use glam::Vec3;
use rayon::prelude::*;

use crate::Bounds;

/// A triangle soup with shared vertices; every structure is built over one.
#[derive(Clone, Copy, Debug, Default)]
pub struct Triangles<'a> {
    /// World positions. Coordinates are zero or have magnitudes from 10⁻³⁷ to 3.4 · 10³⁸, mixed in one scene as well.
    /// Triangles with coordinates that aren't finite are left out and counted.
    pub positions: &'a [Vec3],
    /// Three indices of `positions` for each triangle; a triangle's id is its index here.
    pub indices: &'a [[u32; 3]],
}

impl Triangles<'_> {
    /// The number of triangles, including those that can't be hit.
    #[must_use]
    pub fn len(&self) -> usize {
        self.indices.len()
    }

    /// Whether there are no triangles.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.indices.is_empty()
    }

    /// The world positions of triangle `id`.
    ///
    /// # Panics
    /// If `id` or one of its vertices is out of range.
    #[inline]
    #[must_use]
    pub fn corners(&self, id: u32) -> [Vec3; 3] {
        let [a, b, c] = self.indices[id as usize];
        [self.positions[a as usize], self.positions[b as usize], self.positions[c as usize]]
    }

    /// Whether all vertices of triangle `id` are in range.
    pub(crate) fn has_all_corners(&self, id: u32) -> bool {
        self.indices[id as usize].iter().all(|&vertex| (vertex as usize) < self.positions.len())
    }

    /// The world positions of triangle `id`, or why no structure lists it.
    #[doc(hidden)]
    #[inline]
    pub fn usable_corners(&self, id: u32) -> Result<[Vec3; 3], Unusable> {
        self.posed_corners(id, |position| position)
    }

    /// As [`usable_corners`](Self::usable_corners), with each position moved.
    #[inline]
    pub(crate) fn posed_corners(&self, id: u32, pose: impl Fn(Vec3) -> Vec3) -> Result<[Vec3; 3], Unusable> {
        let mut corners = [Vec3::ZERO; 3];
        for (corner, &vertex) in corners.iter_mut().zip(&self.indices[id as usize]) {
            *corner = pose(*self.positions.get(vertex as usize).ok_or(Unusable::IndexOutOfRange)?);
        }
        if !corners.iter().all(|corner| corner.is_finite()) {
            return Err(Unusable::NotFinite);
        }
        let [a, b, c] = corners;
        // Only triangles certainly without area: a sliver whose area merely rounds to zero may still be hit.
        if a == b || b == c || c == a { Err(Unusable::ZeroArea) } else { Ok(corners) }
    }

    /// The triangles that no ray can hit.
    #[must_use]
    pub fn omitted(&self) -> Omitted {
        const CHUNK: u32 = 1 << 14;
        let count = self.len() as u32;
        let chunks = (0..count.div_ceil(CHUNK)).into_par_iter().map(|chunk| {
            let mut omitted = Omitted::default();
            for id in chunk * CHUNK..count.min((chunk + 1).saturating_mul(CHUNK)) {
                if let Err(why) = self.usable_corners(id) {
                    omitted.note(id, why);
                }
            }
            omitted
        });
        // In order, so that the first ids are the lowest.
        chunks.reduce(Omitted::default, |mut earlier, later| {
            earlier.append(&later);
            earlier
        })
    }

    /// The bounds of all triangles that can be hit.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        let usable = (0..self.len() as u32).into_par_iter().filter_map(|id| self.usable_corners(id).ok());
        usable.map(Bounds::of_points).reduce(|| Bounds::EMPTY, Bounds::union)
    }
}

/// The reason why no ray can hit a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unusable {
    /// A coordinate is NaN or infinite.
    NotFinite,
    /// Two corners are the same point.
    ZeroArea,
    /// A vertex index points past the last vertex.
    IndexOutOfRange,
}

/// The triangles of a frame that no ray can hit, by reason.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Omitted {
    /// A coordinate is NaN or infinite.
    pub not_finite: OmittedKind,
    /// Two corners are the same point.
    pub zero_area: OmittedKind,
    /// A vertex index points past the last vertex.
    pub index_out_of_range: OmittedKind,
}

impl Omitted {
    /// The number of triangles that were left out for any reason.
    #[must_use]
    pub fn total(&self) -> u32 {
        self.not_finite.count + self.zero_area.count + self.index_out_of_range.count
    }

    pub fn note(&mut self, id: u32, why: Unusable) {
        let kind = match why {
            Unusable::NotFinite => &mut self.not_finite,
            Unusable::ZeroArea => &mut self.zero_area,
            Unusable::IndexOutOfRange => &mut self.index_out_of_range,
        };
        kind.count += 1;
        if kind.first_ids.len() < OmittedKind::IDS {
            kind.first_ids.push(id);
        }
    }

    /// Forgets all triangles and keeps the memory.
    pub fn clear(&mut self) {
        for kind in [&mut self.not_finite, &mut self.zero_area, &mut self.index_out_of_range] {
            kind.count = 0;
            kind.first_ids.clear();
        }
    }

    /// Adds the omitted triangles of `later`, whose ids are all higher.
    pub fn append(&mut self, later: &Self) {
        let kinds = [
            (&mut self.not_finite, &later.not_finite),
            (&mut self.zero_area, &later.zero_area),
            (&mut self.index_out_of_range, &later.index_out_of_range),
        ];
        for (kind, later) in kinds {
            kind.count += later.count;
            let room = OmittedKind::IDS - kind.first_ids.len();
            kind.first_ids.extend(later.first_ids.iter().take(room));
        }
    }
}

/// The triangles left out for one reason: their number, and the first ids.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct OmittedKind {
    /// The number of triangles.
    pub count: u32,
    /// The lowest ids, at most [`OmittedKind::IDS`] of them.
    pub first_ids: Vec<u32>,
}

impl OmittedKind {
    /// The largest number of ids that are kept.
    pub const IDS: usize = 8;
}
