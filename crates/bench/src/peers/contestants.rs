//! Whom the grids are compared with: each takes the same triangles, camera and lights, and times its stages.

use std::hint::black_box;
use std::sync::Arc;

use anyhow::Result;
use rayon::prelude::*;
use umbrage::rays::predicate::{self, HitPoint, ShadowRay};
use umbrage::rays::{Bvh, Hit};
use umbrage_peers::{BuildMethod, Embree, Image, PixelRays, Posed, Scene};

use crate::grids::{Times, time};
use crate::shot::Shot;

/// Embree, with one way to build its hierarchy.
#[derive(Debug)]
pub(super) struct EmbreeSide {
    scene: Scene,
    pub(super) image: Image,
}

impl EmbreeSide {
    pub(super) fn new(embree: &Arc<Embree>, method: BuildMethod) -> Self {
        Self { scene: Scene::new(embree, method), image: Image::default() }
    }

    pub(super) fn trace(&mut self, shot: &Shot<'_>, posed: &Arc<Posed>) -> Result<Times> {
        let Self { scene, image, .. } = self;
        let mut times = Times::default();
        scene.clear();
        time(&mut times.build, || scene.build(posed))?;
        for &offset_pixels in &shot.offsets_pixels {
            let rays = PixelRays::new(&shot.view, offset_pixels);
            time(&mut times.see, || image.see(&rays, |valid, packet| scene.nearest(valid, packet)));
            for light in &shot.lights {
                let occluded = |valid: &_, packet: &mut _| scene.occluded(valid, packet);
                time(&mut times.shadow, || image.shadow(&rays, (light, shot.bounds), occluded));
            }
        }
        Ok(times)
    }
}

/// What making Embree's rays takes, without tracing them.
#[derive(Debug, Default)]
pub(super) struct RaysOnly {
    image: Image,
}

impl RaysOnly {
    /// `seen` is what a tracer saw at the last sample, which stands for all.
    pub(super) fn trace(&mut self, shot: &Shot<'_>, seen: &Image) -> Times {
        let mut times = Times::default();
        for &offset_pixels in &shot.offsets_pixels {
            let rays = PixelRays::new(&shot.view, offset_pixels);
            time(&mut times.see, || {
                self.image.see(&rays, |_, packet| {
                    black_box(packet);
                });
            });
            self.image.clone_hits_from(seen);
            for light in &shot.lights {
                time(&mut times.shadow, || {
                    self.image.shadow(&rays, (light, shot.bounds), |_, packet| {
                        black_box(packet);
                    });
                });
            }
        }
        times
    }
}

/// Our own hierarchy, one ray at a time.
#[derive(Debug, Default)]
pub(super) struct Hierarchy {
    bvh: Bvh,
}

impl Hierarchy {
    pub(super) fn trace(&mut self, shot: &Shot<'_>) -> Times {
        let Self { bvh } = self;
        let Shot { frame, view, offsets_pixels, lights, masks, .. } = shot;
        let triangles = frame.triangles();
        let mut times = Times::default();
        time(&mut times.build, || bvh.build(triangles));
        let pixels = view.width * view.height;
        let mut seen = Vec::new();
        for offset in offsets_pixels {
            let ray = |pixel: u32| {
                let (x, y) = (pixel % view.width, pixel / view.width);
                view.ray(f64::from(x) + offset.x, f64::from(y) + offset.y)
            };
            let is_solid = |hit: &Hit| !*masks || frame.is_solid(hit.triangle, hit.barycentric);
            time(&mut times.see, || {
                (0..pixels)
                    .into_par_iter()
                    .map(|pixel| bvh.nearest(triangles, &ray(pixel), is_solid).map(|hit| hit.triangle))
                    .collect_into_vec(&mut seen);
            });
            for light in lights {
                let is_lit = |(pixel, triangle): (usize, &Option<u32>)| {
                    let (ray, triangle) = (ray(pixel as u32), (*triangle)?);
                    let hit = predicate::hit(&ray, triangles, triangle)?;
                    let shadow_ray = ShadowRay::new(light, HitPoint::new(&ray, hit.t));
                    let casts = |id, weights| !*masks || frame.casts_shadow(id, weights);
                    Some(!bvh.blocked(triangles, &shadow_ray, triangle, casts))
                };
                time(&mut times.shadow, || black_box(seen.par_iter().enumerate().filter_map(is_lit).count()));
            }
        }
        times
    }
}
