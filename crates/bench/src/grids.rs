//! Our grids, stage by stage, as the engine calls them.

use std::time::Instant;

use anyhow::Result;
use umbrage::rays::{
    LightGrid, ListedCounts, ListedGrid, ListedOptions, PerspectiveGrid, SeenImage, SeenPixels, SimdLevel, TileOrder,
    Unmasked,
};
use umbrage::scene::{ShadowingPoints, SolidPoints};

use crate::shot::Shot;

/// How many stages the light grid has.
pub(crate) const LIGHT_STAGES: usize = 6;

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
    camera_grid: CameraGrid,
    light_grid: LightGrid,
    seen: SeenPixels,
    /// One for each block of pixels, the first pixel in the lowest bit.
    lit: Vec<u16>,
}

/// A form of the camera's grid; the listed one with its options and what it last did.
#[derive(Debug)]
enum CameraGrid {
    Direct(Box<PerspectiveGrid>),
    Listed(Box<ListedGrid>, ListedOptions, ListedCounts),
}

impl Default for CameraGrid {
    fn default() -> Self {
        Self::Direct(Box::default())
    }
}

impl Grids {
    /// Grids that use the instructions of `level`; the camera's is the paper's own form if it has `listed` options.
    pub(crate) fn new(level: SimdLevel, listed: Option<ListedOptions>) -> Self {
        let camera_grid = match listed {
            None => CameraGrid::Direct(Box::new(PerspectiveGrid::with_level(level))),
            Some(options) => {
                CameraGrid::Listed(Box::new(ListedGrid::with_level(level)), options, ListedCounts::default())
            }
        };
        Self { camera_grid, light_grid: LightGrid::with_level(level), ..Self::default() }
    }

    pub(crate) fn trace(&mut self, shot: &Shot<'_>) -> Result<Times> {
        let Self { camera_grid, light_grid, seen, lit } = self;
        let Shot { frame, view, offsets_pixels, lights, masks, .. } = shot;
        let triangles = frame.triangles();
        let mut times = Times::default();
        for &offset_pixels in offsets_pixels {
            let is_masked = |id| *masks && frame.is_masked(id);
            match camera_grid {
                CameraGrid::Direct(grid) => {
                    time(&mut times.build, || grid.build(triangles, view, offset_pixels, is_masked))?;
                    time(&mut times.see, || match masks {
                        true => grid.trace(triangles, SolidPoints(frame), seen),
                        false => grid.trace(triangles, Unmasked, seen),
                    });
                }
                CameraGrid::Listed(grid, options, counts) => {
                    time(&mut times.build, || grid.build(triangles, view, offset_pixels, *options, is_masked))?;
                    *counts = time(&mut times.see, || match masks {
                        true => grid.trace(triangles, SolidPoints(frame), seen),
                        false => grid.trace(triangles, Unmasked, seen),
                    });
                }
            }
            let image = SeenImage { triangles, view: *view, offset_pixels, seen };
            lit.resize(seen.order().places() / TileOrder::BLOCK_PLACES, 0);
            time(&mut times.survey, || light_grid.survey(&image));
            for light in lights {
                time(&mut times.shadow, || {
                    if *masks {
                        light_grid.shadow(&image, light, |id| frame.is_opaque(id), &ShadowingPoints(frame), lit);
                    } else {
                        light_grid.shadow(&image, light, |_| true, &Unmasked, lit);
                    }
                });
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

    /// Milliseconds of the light grid's own stages, for the last light.
    pub(crate) fn light_milliseconds(&self) -> [(&'static str, f64); LIGHT_STAGES] {
        self.light_grid.seconds().named().map(|(name, seconds)| (name, 1e3 * seconds))
    }

    /// What the listed form of the camera's grid did; `None` for the direct one.
    pub(crate) fn listed_counts(&self) -> Option<ListedCounts> {
        match &self.camera_grid {
            CameraGrid::Direct(_) => None,
            CameraGrid::Listed(_, _, counts) => Some(*counts),
        }
    }

    /// Bytes that each grid holds: the camera's and the lights'.
    pub(crate) fn bytes(&self) -> [usize; 2] {
        let camera = match &self.camera_grid {
            CameraGrid::Direct(grid) => grid.bytes(),
            CameraGrid::Listed(grid, ..) => grid.bytes(),
        };
        [camera, self.light_grid.bytes()]
    }
}
