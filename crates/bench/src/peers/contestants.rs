//! Whom the grids are compared with: each takes the same triangles, camera and lights, and times its stages.

use std::hint::black_box;
use std::sync::Arc;

use anyhow::Result;
use rayon::prelude::*;
use umbrage::rays::predicate::{self, HitPoint, ShadowRay};
use umbrage::rays::{Bvh, Hit, SeenImage, SeenPixels, TileOrder, UniformGrid, UniformOptions, Unmasked};
use umbrage::scene::{ShadowingPoints, SolidPoints};
use umbrage_peers::{BuildMethod, Embree, Image, PixelRays, Posed, Scene};

use crate::grids::{Grids, Pixel, Times, pixel, time};
use crate::shot::Shot;

/// Our grids: those of the camera and the lights, or one for all rays.
#[derive(Debug)]
pub(super) enum OurSide {
    Specialised(Grids),
    Uniform(Box<UniformSide>),
}

impl OurSide {
    pub(super) fn trace(&mut self, shot: &Shot<'_>) -> Result<Times> {
        match self {
            Self::Specialised(grids) => grids.trace(shot),
            Self::Uniform(side) => Ok(side.trace(shot)),
        }
    }

    pub(super) fn pixel(&self, x: u32, y: u32) -> Option<Pixel> {
        match self {
            Self::Specialised(grids) => grids.pixel(x, y),
            Self::Uniform(side) => pixel(&side.seen, &side.lit, x, y),
        }
    }
}

/// The uniform grid, its rays in packets.
#[derive(Debug, Default)]
pub(super) struct UniformSide {
    grid: UniformGrid,
    seen: SeenPixels,
    lit: Vec<u16>,
}

impl UniformSide {
    pub(super) fn new(options: UniformOptions) -> Result<Self> {
        let mut side = Self::default();
        side.grid.set_options(options)?;
        Ok(side)
    }

    fn trace(&mut self, shot: &Shot<'_>) -> Times {
        let Self { grid, seen, lit } = self;
        let Shot { frame, view, offsets_pixels, lights, masks, .. } = shot;
        let triangles = frame.triangles();
        let is_opaque = |id| !*masks || frame.is_opaque(id);
        let is_solid = |id| !*masks || !frame.is_masked(id);
        let mut times = Times::default();
        time(&mut times.build, || grid.build(triangles));
        for &offset_pixels in offsets_pixels {
            time(&mut times.see, || match masks {
                true => grid.see(triangles, view, offset_pixels, is_solid, SolidPoints(frame), seen),
                false => grid.see(triangles, view, offset_pixels, is_solid, Unmasked, seen),
            });
            lit.resize(seen.order().places() / TileOrder::BLOCK_PLACES, 0);
            let image = SeenImage { triangles, view: *view, offset_pixels, seen };
            for light in lights {
                time(&mut times.shadow, || match masks {
                    true => grid.shadow(&image, light, is_opaque, &ShadowingPoints(frame), lit),
                    false => grid.shadow(&image, light, is_opaque, &Unmasked, lit),
                });
            }
        }
        times
    }
}

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
