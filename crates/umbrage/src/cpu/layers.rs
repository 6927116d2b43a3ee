//! A film's layers beside its colours, from the samples' hits and from light masks.

#[cfg(test)]
mod tests;

use glam::{Vec2, Vec3};
use rayon::prelude::*;
use umbrage_rays::parallel::Parallel;
use umbrage_rays::{Hit, LightMask, LightSource, Ray, SeenPixels, predicate};

use super::hit_of;
use crate::Film;
use crate::engine::Staged;
use crate::film::FilmLayers;
use crate::motion::Next;
use crate::sampling::{Sample, Samples};

/// The samples' hits, and the lights that reach them.
#[derive(Clone, Copy)]
pub(crate) struct SeenAndLit<'a> {
    pub(crate) seen: &'a SeenPixels,
    pub(crate) masks: &'a [LightMask],
}

impl SeenAndLit<'_> {
    /// Adds their values to the film's layers. Layers of a single sample take the first one.
    pub(crate) fn add_layers(&self, staged: &Staged<'_>, next: Option<&Next<'_>>, film: &mut Film) {
        let (frame, width) = (staged.frame, film.width as usize);
        let seen = SeenRows { seen: self.seen, samples: &staged.samples, width: film.width };
        self.add_lit(staged, &seen, &mut film.layers);
        let layers = &mut film.layers;
        if !layers.object.is_empty() || !layers.coverage.pixels().is_empty() {
            let objects = &frame.mesh.objects;
            let (numbers, unnamed) = layers.numbers(objects);
            let object = |triangle| objects.of_triangle(triangle).map_or(unnamed, |object| numbers[object as usize]);
            layers.coverage.rows_mut(width).enumerate().each(|(y, mut row)| {
                seen.for_each(y, |[x, _], _, triangle| row.add(x, object(triangle)));
            });
            layers.object.par_chunks_mut(width).enumerate().each(|(y, row)| {
                seen.for_each_first(y, |x, _, triangle| row[x] = object(triangle));
            });
        }
        let hit = |x: usize, y: usize, sample: &Sample, triangle| {
            hit_of(frame, &sample.ray(&staged.view, x as u32, y as u32), triangle)
        };
        let fill = |values: &mut Vec<Vec2>, value: &(dyn Fn(&Hit) -> Vec2 + Sync)| {
            values.par_chunks_mut(width).enumerate().each(|(y, row)| {
                seen.for_each_first(y, |x, sample, triangle| {
                    row[x] = hit(x, y, sample, triangle).map_or(Vec2::ZERO, |hit| value(&hit));
                });
            });
        };
        fill(&mut layers.barycentric, &|hit| Vec2::from(hit.barycentric));
        if let Some(next) = next {
            fill(&mut layers.motion, &|hit| next.motion(frame, hit));
        }
    }

    /// Counts for each light the samples that it reaches on the visible side.
    fn add_lit(&self, staged: &Staged<'_>, seen: &SeenRows<'_>, layers: &mut FilmLayers) {
        let Staged { frame, lights, ref view, .. } = *staged;
        let triangles = frame.triangles();
        for ((layer, light), mask) in layers.shadow.iter_mut().zip(lights).zip(self.masks) {
            // Lights of nodes that are hidden at another moment aren't in the list of all moments.
            if layer.name != light.name {
                continue;
            }
            layer.lit.par_chunks_mut(view.width as usize).enumerate().each(|(y, row)| {
                seen.for_each(y, |[x, which], sample, triangle| {
                    let [column, row_of_samples] = seen.samples_at(x, y, which);
                    if mask.is_lit(column, row_of_samples) {
                        let ray = sample.ray(view, x as u32, y as u32);
                        let is_lit = is_seen_on_lit_side(&light.source, &ray, triangles.corners(triangle));
                        row[x] += if is_lit { 1.0 } else { 0.0 };
                    }
                });
            });
        }
    }
}

/// The hits of the samples that were traced last, row by row of the film.
struct SeenRows<'a> {
    seen: &'a SeenPixels,
    samples: &'a Samples,
    width: u32,
}

impl SeenRows<'_> {
    /// The column and row, in the image of all samples, of sample number `which` of a pixel.
    fn samples_at(&self, x: usize, y: usize, which: usize) -> [u32; 2] {
        let (side, [column, row]) = (self.samples.side(), self.samples.quarter(which));
        [side * x as u32 + column, side * y as u32 + row]
    }

    /// Calls `visit` for each sample in a row that sees a triangle, with its column and number, the sample and the triangle.
    fn for_each(&self, y: usize, mut visit: impl FnMut([usize; 2], &Sample, u32)) {
        for x in 0..self.width as usize {
            for (which, sample) in self.samples.as_slice().iter().enumerate() {
                let [column, row] = self.samples_at(x, y, which);
                let triangle = self.seen.triangle[self.seen.order().index(column, row)];
                if triangle != SeenPixels::NONE {
                    visit([x, which], sample, triangle);
                }
            }
        }
    }

    /// As [`for_each`](Self::for_each), for each pixel's first sample alone.
    fn for_each_first(&self, y: usize, mut visit: impl FnMut(usize, &Sample, u32)) {
        if self.samples.as_slice()[0].index == 0 {
            self.for_each(y, |[x, which], sample, triangle| {
                if which == 0 {
                    visit(x, sample, triangle);
                }
            });
        }
    }
}

/// Whether a light and the start of a ray are on the same side of a triangle.
fn is_seen_on_lit_side(light: &LightSource, ray: &Ray, corners: [Vec3; 3]) -> bool {
    let faces_light = match light {
        LightSource::Directional { direction } => predicate::is_front_along(direction.as_dvec3(), corners),
        LightSource::Point { position } | LightSource::Spot { position, .. } => {
            predicate::is_front_from(position.as_dvec3(), corners)
        }
    };
    faces_light == predicate::is_front_along(ray.direction, corners)
}
