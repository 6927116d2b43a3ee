//! Our grids, stage by stage, as the engine calls them.

use std::time::Instant;

use anyhow::Result;
use umbrage::rays::{
    GridCounts, LightGrid, LightGridCounts, LightGridSeconds, PerspectiveGrid, SeenImage, SeenPixels, SimdLevel,
    TileOrder, Unmasked,
};
use umbrage::scene::SolidPoints;

use crate::shot::Shot;

/// What a frame took, in milliseconds, over all samples and lights.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Times {
    /// What is built before any ray is traced.
    pub(crate) build: f64,
    pub(crate) see: f64,
    /// What lights need to know about the points, once for all of them.
    pub(crate) survey: f64,
    pub(crate) shadow: f64,
}

impl Times {
    pub(crate) fn frame(&self) -> f64 {
        self.build + self.see + self.survey + self.shadow
    }
}

/// Calls `stage` and adds what it took to `milliseconds`.
pub(crate) fn time<T>(milliseconds: &mut f64, stage: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let result = stage();
    *milliseconds += start.elapsed().as_secs_f64() * 1e3;
    result
}

/// What a pixel shows and whether the last light reaches it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pixel {
    pub(crate) triangle: u32,
    pub(crate) is_lit: bool,
}

/// The camera's grid and the lights'.
#[derive(Debug, Default)]
pub(crate) struct Grids {
    camera_grid: PerspectiveGrid,
    light_grid: LightGrid,
    seen: SeenPixels,
    /// One for each block of pixels, the first pixel in the lowest bit.
    lit: Vec<u16>,
    camera_counts: GridCounts,
}

impl Grids {
    pub(crate) fn with_level(level: SimdLevel) -> Self {
        Self {
            camera_grid: PerspectiveGrid::with_level(level),
            light_grid: LightGrid::with_level(level),
            ..Self::default()
        }
    }

    pub(crate) fn trace(&mut self, shot: &Shot<'_>) -> Result<Times> {
        let Self { camera_grid, light_grid, seen, lit, camera_counts } = self;
        let Shot { frame, view, offsets_pixels, lights, masks, .. } = shot;
        let triangles = frame.triangles();
        let mut times = Times::default();
        for &offset_pixels in offsets_pixels {
            time(&mut times.build, || {
                camera_grid.build(triangles, view, offset_pixels, |id| *masks && frame.is_masked(id))
            })?;
            *camera_counts = time(&mut times.see, || {
                if *masks {
                    camera_grid.trace(triangles, SolidPoints(frame), seen)
                } else {
                    camera_grid.trace(triangles, Unmasked, seen)
                }
            });
            let image = SeenImage { triangles, view: *view, offset_pixels, seen };
            lit.resize(seen.order().places() / TileOrder::BLOCK_PLACES, 0);
            time(&mut times.survey, || light_grid.survey(&image));
            for light in lights {
                let is_opaque = |id| !*masks || frame.is_opaque(id);
                let casts = |id, weights| !*masks || frame.casts_shadow(id, weights);
                time(&mut times.shadow, || light_grid.shadow(&image, light, is_opaque, casts, lit));
            }
        }
        Ok(times)
    }

    /// What a pixel showed at the last sample; `None` for nothing.
    pub(crate) fn pixel(&self, x: u32, y: u32) -> Option<Pixel> {
        let place = self.seen.order().place(x, y);
        let triangle = self.seen.triangle[place];
        let is_lit = self.lit[place / TileOrder::BLOCK_PLACES] >> (place % TileOrder::BLOCK_PLACES) & 1 == 1;
        (triangle != SeenPixels::NONE).then_some(Pixel { triangle, is_lit })
    }

    /// What the last camera and the last light were as work.
    pub(crate) fn counts(&self) -> Vec<(String, u64)> {
        counts(&self.camera_counts, &self.light_grid.counts())
    }

    /// Milliseconds of the light grid's own stages, for the last light.
    pub(crate) fn light_stages(&self) -> [(&'static str, f64); 6] {
        light_stages(&self.light_grid.seconds())
    }

    /// Bytes that each grid holds: the camera's and the lights'.
    pub(crate) fn bytes(&self) -> [usize; 2] {
        [self.camera_grid.bytes(), self.light_grid.bytes()]
    }
}

/// What a camera and a light were as work, each number with its name.
pub(crate) fn counts(camera: &GridCounts, light: &LightGridCounts) -> Vec<(String, u64)> {
    let camera = camera.named().map(|(name, count)| (format!("see_{name}"), count));
    let light = light.named().map(|(name, count)| (format!("shadow_{name}"), count));
    camera.into_iter().chain(light).collect()
}

/// Milliseconds of the light grid's stages, each with its name.
pub(crate) fn light_stages(seconds: &LightGridSeconds) -> [(&'static str, f64); 6] {
    seconds.named().map(|(name, seconds)| (name, 1e3 * seconds))
}
