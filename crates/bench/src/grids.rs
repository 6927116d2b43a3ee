//! Our grids, stage by stage, as the engine calls them.

use std::time::Instant;

use anyhow::Result;
use umbrage::rays::{
    LightGrid, LightSource, ListedCounts, ListedGrid, ListedLightGrid, ListedLightOptions, ListedOptions,
    PerspectiveGrid, SeenImage, SeenPixels, SimdLevel, TileOrder, Unmasked,
};
use umbrage::scene::{Frame, ShadowingPoints, SolidPoints};

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

/// What a pixel of an image shows, with a bit for each place that is lit; `None` for nothing.
pub(crate) fn pixel(seen: &SeenPixels, lit: &[u16], x: u32, y: u32) -> Option<Pixel> {
    let place = seen.order().place(x, y);
    let triangle = seen.triangle[place];
    let is_lit = lit[place / TileOrder::BLOCK_PLACES] >> (place % TileOrder::BLOCK_PLACES) & 1 == 1;
    (triangle != SeenPixels::NONE).then_some(Pixel { triangle, is_lit })
}

/// The camera's grid and the lights'.
#[derive(Debug, Default)]
pub(crate) struct Grids {
    camera_grid: CameraGrid,
    light_grid: LightsGrid,
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

/// A form of the lights' grid.
#[derive(Debug)]
enum LightsGrid {
    Direct(Box<LightGrid>),
    Listed(Box<ListedLightGrid>),
}

impl Default for LightsGrid {
    fn default() -> Self {
        Self::Direct(Box::default())
    }
}

/// Which forms the grids have: the paper's own where they have options for it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Forms {
    pub(crate) camera: Option<ListedOptions>,
    pub(crate) lights: Option<ListedLightOptions>,
}

impl From<ListedOptions> for Forms {
    /// The paper's form of the camera's grid, and the direct one of the lights'.
    fn from(options: ListedOptions) -> Self {
        Self { camera: Some(options), lights: None }
    }
}

impl Grids {
    /// Grids that use the instructions of `level`.
    pub(crate) fn new(level: SimdLevel, forms: Forms) -> Self {
        let camera_grid = match forms.camera {
            None => CameraGrid::Direct(Box::new(PerspectiveGrid::with_level(level))),
            Some(options) => {
                CameraGrid::Listed(Box::new(ListedGrid::with_level(level)), options, ListedCounts::default())
            }
        };
        let light_grid = match forms.lights {
            None => LightsGrid::Direct(Box::new(LightGrid::with_level(level))),
            Some(options) => {
                let mut grid = ListedLightGrid::with_level(level);
                grid.set_options(options);
                LightsGrid::Listed(Box::new(grid))
            }
        };
        Self { camera_grid, light_grid, ..Self::default() }
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
                time(&mut times.shadow, || light_grid.shadow(&image, light, masks.then_some(*frame), lit));
            }
        }
        Ok(times)
    }

    /// What a pixel showed at the last sample; `None` for nothing.
    pub(crate) fn pixel(&self, x: u32, y: u32) -> Option<Pixel> {
        pixel(&self.seen, &self.lit, x, y)
    }

    /// Milliseconds of the light grid's own stages, for the last light: other ones for each form.
    pub(crate) fn light_milliseconds(&self) -> Vec<(&'static str, f64)> {
        let milliseconds = |(name, seconds)| (name, 1e3 * seconds);
        match &self.light_grid {
            LightsGrid::Direct(grid) => grid.seconds().named().map(milliseconds).into(),
            LightsGrid::Listed(grid) => grid.seconds().named().map(milliseconds).into(),
        }
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
        let lights = match &self.light_grid {
            LightsGrid::Direct(grid) => grid.bytes(),
            LightsGrid::Listed(grid) => grid.bytes(),
        };
        [camera, lights]
    }
}

impl LightsGrid {
    fn survey(&mut self, image: &SeenImage<'_>) {
        match self {
            Self::Direct(grid) => grid.survey(image),
            Self::Listed(grid) => grid.survey(image),
        }
    }

    /// Finds what `light` reaches; with a `masked` frame, whose opacity is asked about hits.
    fn shadow(&mut self, image: &SeenImage<'_>, light: &LightSource, masked: Option<&Frame>, lit: &mut [u16]) {
        match (self, masked) {
            (Self::Direct(grid), None) => grid.shadow(image, light, |_| true, &Unmasked, lit),
            (Self::Listed(grid), None) => grid.shadow(image, light, |_| true, &Unmasked, lit),
            (Self::Direct(grid), Some(frame)) => {
                grid.shadow(image, light, |id| frame.is_opaque(id), &ShadowingPoints(frame), lit);
            }
            (Self::Listed(grid), Some(frame)) => {
                grid.shadow(image, light, |id| frame.is_opaque(id), &ShadowingPoints(frame), lit);
            }
        }
    }
}
