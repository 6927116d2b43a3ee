//! The side of triangles that faces lights, and the angles at which light arrives.

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use umbrage::rays::{LightSource, Triangles, predicate};

use super::answers::{INVALID_ID, unit_normal};

/// Points on triangles, or the centroids of all triangles.
#[derive(Clone, Copy)]
pub(super) enum Spots<'a> {
    Faces,
    /// Positions, and the triangle of each by its id among all, or [`INVALID_ID`].
    Points(&'a [Vec3], &'a [u32]),
}

impl Spots<'_> {
    fn count(self, triangles: Triangles<'_>) -> usize {
        match self {
            Self::Faces => triangles.len(),
            Self::Points(positions, _) => positions.len(),
        }
    }

    /// The triangle's id; `None` for a point on none.
    fn triangle(self, index: usize) -> Option<u32> {
        match self {
            Self::Faces => Some(index as u32),
            Self::Points(_, own) => own.get(index).copied().filter(|&id| id != INVALID_ID),
        }
    }
}

/// Clears, in each light's row of `lit`, the points on the back of their triangle.
pub(super) fn keep_facing(triangles: Triangles<'_>, spots: Spots<'_>, lights: &[LightSource], lit: &mut [bool]) {
    let rows = lit.par_chunks_mut(spots.count(triangles).max(1)).zip(lights);
    rows.for_each(|(row, light)| {
        let row = row.par_iter_mut().enumerate().with_min_len(1 << 10);
        row.filter(|(_, is_lit)| **is_lit).for_each(|(index, is_lit)| {
            *is_lit = spots.triangle(index).is_none_or(|id| is_in_front(light, triangles, id));
        });
    });
}

/// Whether a light is where a triangle's corners are seen counterclockwise. The predicate decides, so it is exact.
fn is_in_front(light: &LightSource, triangles: Triangles<'_>, id: u32) -> bool {
    let Ok(corners) = triangles.usable_corners(id) else { return false };
    match light {
        LightSource::Directional { direction } => predicate::is_front_along(direction.as_dvec3(), corners),
        LightSource::Point { position } | LightSource::Spot { position, .. } => {
            predicate::is_front_from(position.as_dvec3(), corners)
        }
    }
}

/// For each light the cosine between each point's normal and the direction to the light; NaN for points on no triangle.
pub(super) fn cosines(triangles: Triangles<'_>, spots: Spots<'_>, lights: &[LightSource], cosines: &mut Vec<f32>) {
    let count = spots.count(triangles);
    for light in lights {
        let cosine = |index: usize| {
            let corners = spots.triangle(index).and_then(|id| triangles.usable_corners(id).ok());
            corners.map_or(f32::NAN, |corners| {
                let point = match spots {
                    Spots::Faces => corners.iter().map(|corner| corner.as_dvec3()).sum::<DVec3>() / 3.0,
                    Spots::Points(positions, _) => positions[index].as_dvec3(),
                };
                let to_light = match light {
                    LightSource::Directional { direction } => -direction.as_dvec3(),
                    LightSource::Point { position } | LightSource::Spot { position, .. } => position.as_dvec3() - point,
                };
                unit_normal(corners).dot(to_light.normalize_or_zero()) as f32
            })
        };
        cosines.par_extend((0..count).into_par_iter().with_min_len(1 << 10).map(cosine));
    }
}
