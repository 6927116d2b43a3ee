//! Who traces a frame: each takes the same triangles, camera and lights, and times its stages.

use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

use anyhow::Result;
use glam::DVec2;
use rayon::prelude::*;
use umbrage::rays::predicate::{self, HitPoint, ShadowRay};
use umbrage::rays::{
    Bounds, Bvh, Hit, LightGrid, LightSource, PerspectiveGrid, SeenImage, SeenPixels, TileOrder, View,
};
use umbrage::scene::Frame;
use umbrage_peers::{BuildMethod, Embree, Image, PixelRays, Posed, Scene};

/// One frame as everyone is given it.
#[derive(Debug)]
pub(super) struct Task<'a> {
    pub(super) frame: &'a Frame,
    pub(super) view: View,
    /// Where in each pixel the rays of each sample go through.
    pub(super) offsets_pixels: Vec<DVec2>,
    pub(super) lights: &'a [LightSource],
    /// Of all triangles.
    pub(super) bounds: Bounds,
    /// Whether alpha masks and opacity are asked about hits.
    pub(super) masks: bool,
}

/// What a frame took, in milliseconds, over all samples and lights.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Times {
    /// What is built before any ray is traced.
    pub(super) build: f64,
    pub(super) see: f64,
    /// Finding the points for the lights, once for all of them.
    pub(super) locate: f64,
    pub(super) shadow: f64,
}

impl Times {
    pub(super) fn frame(&self) -> f64 {
        self.build + self.see + self.locate + self.shadow
    }
}

/// Calls `stage` and adds what it took to `milliseconds`.
fn time<T>(milliseconds: &mut f64, stage: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let result = stage();
    *milliseconds += start.elapsed().as_secs_f64() * 1e3;
    result
}

/// What a pixel shows and whether the last light reaches it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pixel {
    pub(super) triangle: u32,
    pub(super) is_lit: bool,
}

/// Our grids, as the engine calls them.
#[derive(Debug, Default)]
pub(super) struct Grids {
    camera_grid: PerspectiveGrid,
    light_grid: LightGrid,
    seen: SeenPixels,
    /// One for each block of pixels, the first pixel in the lowest bit.
    lit: Vec<u16>,
}

impl Grids {
    pub(super) fn trace(&mut self, task: &Task<'_>) -> Result<Times> {
        let Self { camera_grid, light_grid, seen, lit } = self;
        let Task { frame, view, offsets_pixels, lights, masks, .. } = task;
        let triangles = frame.triangles();
        let mut times = Times::default();
        for &offset_pixels in offsets_pixels {
            time(&mut times.build, || {
                camera_grid.build(triangles, view, offset_pixels, |id| *masks && frame.is_masked(id))
            })?;
            let is_solid = |hit: &Hit| !*masks || frame.is_solid(hit.triangle, hit.barycentric);
            time(&mut times.see, || camera_grid.trace(triangles, is_solid, seen));
            let image = SeenImage { triangles, view: *view, offset_pixels, seen };
            lit.resize(seen.order().places() / TileOrder::BLOCK_PLACES, 0);
            time(&mut times.locate, || light_grid.locate(&image));
            for light in *lights {
                let is_opaque = |id| !*masks || frame.is_opaque(id);
                let casts = |id, weights| !*masks || frame.casts_shadow(id, weights);
                time(&mut times.shadow, || light_grid.shadow(&image, light, is_opaque, casts, lit));
            }
        }
        Ok(times)
    }

    /// What a pixel showed at the last sample; `None` for nothing.
    pub(super) fn pixel(&self, x: u32, y: u32) -> Option<Pixel> {
        let place = self.seen.order().place(x, y);
        let triangle = self.seen.triangle[place];
        let is_lit = self.lit[place / TileOrder::BLOCK_PLACES] >> (place % TileOrder::BLOCK_PLACES) & 1 == 1;
        (triangle != SeenPixels::NONE).then_some(Pixel { triangle, is_lit })
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

    pub(super) fn trace(&mut self, task: &Task<'_>, posed: &Arc<Posed>) -> Result<Times> {
        let Self { scene, image, .. } = self;
        let mut times = Times::default();
        scene.clear();
        time(&mut times.build, || scene.build(posed))?;
        for &offset_pixels in &task.offsets_pixels {
            let rays = PixelRays::new(&task.view, offset_pixels);
            time(&mut times.see, || image.see(&rays, |valid, packet| scene.nearest(valid, packet)));
            for light in task.lights {
                let occluded = |valid: &_, packet: &mut _| scene.occluded(valid, packet);
                time(&mut times.shadow, || image.shadow(&rays, (light, task.bounds), occluded));
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
    pub(super) fn trace(&mut self, task: &Task<'_>, seen: &Image) -> Times {
        let mut times = Times::default();
        for &offset_pixels in &task.offsets_pixels {
            let rays = PixelRays::new(&task.view, offset_pixels);
            time(&mut times.see, || {
                self.image.see(&rays, |_, packet| {
                    black_box(packet);
                });
            });
            self.image.clone_hits_from(seen);
            for light in task.lights {
                time(&mut times.shadow, || {
                    self.image.shadow(&rays, (light, task.bounds), |_, packet| {
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
    pub(super) fn trace(&mut self, task: &Task<'_>) -> Times {
        let Self { bvh } = self;
        let Task { frame, view, offsets_pixels, lights, masks, .. } = task;
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
            for light in *lights {
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
