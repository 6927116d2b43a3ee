//! The compared sides: each takes the same triangles, camera and lights, and times its stages.

use std::hint::black_box;
use std::sync::Arc;

use anyhow::Result;
use umbrage_peers::{
    BuildMethod, Embree, Image, Layout, PixelRays, Posed, RayHitPacket, Scene, TinyBvh, TinyScene, Valid,
};

use crate::grids::{Times, time};
use crate::shot::Shot;
use umbrage::Samples;

/// Embree, with one way to build its hierarchy.
#[derive(Debug)]
pub(crate) struct EmbreeSide {
    scene: Scene,
    /// Whether packets have rays of one sample, even if our structures trace several together.
    by_sample: bool,
    pub(crate) image: Image,
}

impl EmbreeSide {
    pub(crate) fn new(embree: &Arc<Embree>, method: BuildMethod, by_sample: bool) -> Self {
        Self { scene: Scene::new(embree, method), by_sample, image: Image::default() }
    }

    pub(crate) fn trace(&mut self, shot: &Shot<'_>, posed: &Arc<Posed>) -> Result<Times> {
        let Self { scene, by_sample, image } = self;
        let mut times = Times::default();
        scene.clear();
        time(&mut times.build, || scene.build(posed))?;
        let nearest = |valid: &_, packet: &mut _| scene.nearest(valid, packet);
        let occluded = |valid: &_, packet: &mut _| scene.occluded(valid, packet);
        let alone = if *by_sample { shot.each_alone() } else { Vec::new() };
        let samples = if *by_sample { &alone } else { &shot.samples };
        trace_all(shot, samples, image, None, &mut times, nearest, occluded);
        Ok(times)
    }
}

/// tinybvh, with one layout of its hierarchy.
#[derive(Debug)]
pub(super) struct TinySide {
    scene: TinyScene,
    pub(super) image: Image,
}

impl TinySide {
    pub(super) fn new(library: &Arc<TinyBvh>, layout: Layout) -> Self {
        Self { scene: TinyScene::new(library, layout), image: Image::default() }
    }

    /// Copying vertices to tinybvh's buffer isn't timed: its users have them there.
    pub(super) fn trace(&mut self, shot: &Shot<'_>, posed: &Arc<Posed>) -> Result<Times> {
        let Self { scene, image } = self;
        let mut times = Times::default();
        scene.pose(posed)?;
        time(&mut times.build, || scene.build());
        let nearest = |valid: &_, packet: &mut _| scene.nearest(valid, packet);
        let occluded = |valid: &_, packet: &mut _| scene.occluded(valid, packet);
        trace_all(shot, &shot.samples, image, None, &mut times, nearest, occluded);
        Ok(times)
    }
}

/// Time to make Embree's rays, without tracing them. `seen` has the last sample's hits, which stand for all samples.
pub(super) fn make_rays(image: &mut Image, shot: &Shot<'_>, seen: &Image) -> Times {
    let mut times = Times::default();
    let nearest = |_: &_, packet: &mut _| {
        black_box(packet);
    };
    let occluded = |_: &_, packet: &mut _| {
        black_box(packet);
    };
    trace_all(shot, &shot.samples, image, Some(seen), &mut times, nearest, occluded);
    times
}

/// Traces the rays of `all` samples and lights by `nearest` and `occluded`. Shadow rays are those of the hits of
/// `image`, or else of `seen`.
fn trace_all(
    shot: &Shot<'_>,
    all: &[Samples],
    image: &mut Image,
    seen: Option<&Image>,
    times: &mut Times,
    nearest: impl Fn(&Valid, &mut RayHitPacket) + Sync,
    occluded: impl Fn(&Valid, &mut RayHitPacket) + Sync,
) {
    let opacities = shot.opacities();
    for samples in all {
        let rays = PixelRays::new(&shot.question(&opacities, samples));
        time(&mut times.see, || image.see(&rays, &nearest));
        seen.into_iter().for_each(|seen| image.clone_hits_from(seen));
        for light in &shot.lights {
            time(&mut times.shadow, || image.shadow(&rays, (light, shot.bounds), &occluded));
        }
    }
}
