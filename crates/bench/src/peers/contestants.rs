//! Whom our structures are compared with: each takes the same triangles, camera and lights, and times its stages.

use std::hint::black_box;
use std::sync::Arc;

use anyhow::Result;
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
