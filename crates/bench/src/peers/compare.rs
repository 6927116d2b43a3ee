use umbrage::rays::predicate;
use umbrage_peers::{Image, Posed};

use crate::grids::Ours;
use crate::shot::Shot;

/// Numbers of pixels in which two pictures of the same frame differ, at the last sample and light.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Differences {
    /// Pixels of ours that show a triangle.
    pub(super) points: u64,
    /// Only one of the two shows a triangle.
    pub(super) hit_or_miss: u64,
    /// Both show a triangle, but not the same, at different distances.
    pub(super) triangle: u64,
    /// Both show a triangle, but not the same, at the same distance to about f32's last bits.
    pub(super) triangle_at_same_distance: u64,
    /// Both show the same triangle, lit in one only.
    pub(super) shadow: u64,
}

impl Differences {
    pub(super) fn add(&mut self, shot: &Shot<'_>, ours: &Ours, (theirs, posed): (&Image, &Posed)) {
        /// Maximum relative difference of equal distances: eight roundings of f32.
        const SAME: f64 = 8.0 * f32::EPSILON as f64;
        let view = &shot.view;
        for y in 0..view.height {
            for x in 0..view.width {
                let (ray, [column, row]) = shot.last_ray(x, y);
                let (our, their) = (ours.pixel(column, row), theirs.seen(column, row));
                self.points += u64::from(our.is_some());
                match (our, their) {
                    (None, None) => {}
                    (Some(our), Some((name, t))) => {
                        if our.triangle == posed.triangle(name) {
                            self.shadow += u64::from(our.is_lit != theirs.is_lit(column, row));
                            continue;
                        }
                        let hit = predicate::hit(&ray, shot.frame.triangles(), our.triangle);
                        let is_tie = hit.is_some_and(|hit| (hit.t - f64::from(t)).abs() <= SAME * hit.t);
                        *(if is_tie { &mut self.triangle_at_same_distance } else { &mut self.triangle }) += 1;
                    }
                    _ => self.hit_or_miss += 1,
                }
            }
        }
    }
}
