//! Grids made for the rays of one shot, as a structure: one for the camera, and one for each light in turn.

use std::fmt::Debug;

use web_time::Instant;

use crate::camera_grid::PerspectiveGrid;
use crate::light_grid::LightGrid;
use crate::listed::{ListedGrid, ListedLightGrid, ListedLightOptions, ListedOptions};
use crate::patches::Patches;
use crate::shot::{Bytes, Counts, LightMask, PixelWork, Seconds, SeenPixels, Shot, Work};
use crate::{ImageTooLarge, LightCells, LightSource, Omitted, SimdLevel, Specialised, Structure, Triangles};

/// A grid for a camera's rays.
pub trait CameraGrid: Debug + Send + Sync {
    /// The SIMD level with which to find patches; `None` for a grid that uses no patches.
    fn level_for_patches(&self) -> Option<SimdLevel> {
        None
    }

    /// Rebuilds the grid for the shot's triangles, whose `patches` it may use. Returns the time of each stage.
    ///
    /// # Errors
    /// If a side of the image is longer than [`ImageTooLarge::LARGEST_SIDE`].
    fn build(&mut self, shot: &Shot<'_>, patches: &Patches) -> Result<Seconds, ImageTooLarge>;

    /// Finds the triangle that each pixel sees.
    fn trace(&mut self, shot: &Shot<'_>, patches: &Patches, seen: &mut SeenPixels) -> Counts;

    /// As [`trace`](Self::trace), and counts each pixel's work.
    fn trace_counting(
        &mut self,
        shot: &Shot<'_>,
        patches: &Patches,
        seen: &mut SeenPixels,
        work: &mut PixelWork,
    ) -> Counts;

    /// The triangles that were left out because no ray can hit them; `None` for a grid that leaves finding them to the
    /// patches.
    fn omitted(&self) -> Option<&Omitted>;

    /// Bytes held for the last frame, without the pixels.
    fn bytes(&self) -> usize;

    /// As [`Structure::validate`].
    ///
    /// # Errors
    /// Describes the first fault.
    fn validate(&self, shot: &Shot<'_>, patches: &Patches) -> Result<(), String>;
}

/// A grid for the rays of lights, one light after the other.
pub trait LightsGrid: Debug + Send + Sync {
    /// The SIMD level with which to find patches; `None` for a grid that uses no patches.
    fn level_for_patches(&self) -> Option<SimdLevel> {
        None
    }

    /// Measures the distances of the points, once for all lights.
    fn survey(&mut self, shot: &Shot<'_>, seen: &SeenPixels);

    /// Finds which points `light` reaches; after a survey.
    ///
    /// # Panics
    /// If it was built for another number of triangles.
    fn shadow(
        &mut self,
        shot: &Shot<'_>,
        patches: &Patches,
        seen: &SeenPixels,
        light: &LightSource,
        mask: &mut LightMask,
    ) -> Work;

    /// As [`Specialised::locate`]; after a survey.
    fn locate(
        &mut self,
        shot: &Shot<'_>,
        patches: &Patches,
        seen: &SeenPixels,
        light: &LightSource,
        cells: &mut LightCells,
    );

    /// Bytes held.
    fn bytes(&self) -> Bytes;

    /// As [`Structure::validate`], for one light; after a survey.
    ///
    /// # Errors
    /// Describes the first fault.
    fn validate(
        &mut self,
        shot: &Shot<'_>,
        patches: &Patches,
        seen: &SeenPixels,
        light: &LightSource,
    ) -> Result<(), String>;
}

/// A grid for the camera and one for each light in turn.
#[derive(Debug, Default)]
pub struct Grids<C, L> {
    camera: C,
    light: L,
    /// The patches that both grids share; empty where neither uses any.
    patches: Patches,
    of_lights: Vec<Work>,
}

/// The fastest grids.
pub type DirectGrids = Grids<PerspectiveGrid, LightGrid>;

/// The grids as their paper describes them.
pub type ListedGrids = Grids<ListedGrid, ListedLightGrid>;

impl DirectGrids {
    /// Empty grids that use the instructions of `level`.
    #[must_use]
    pub fn with_level(level: SimdLevel) -> Self {
        Self::new(PerspectiveGrid::with_level(level), LightGrid::with_level(level))
    }
}

impl ListedGrids {
    /// Empty grids that use the instructions of `level` and are cut into cells as the options say.
    #[must_use]
    pub fn with_options(level: SimdLevel, camera: ListedOptions, light: ListedLightOptions) -> Self {
        Self::new(ListedGrid::new(level, camera), ListedLightGrid::new(level, light))
    }
}

impl<C: CameraGrid, L: LightsGrid> Grids<C, L> {
    /// Pairs two grids.
    #[must_use]
    pub fn new(camera: C, light: L) -> Self {
        Self { camera, light, patches: Patches::default(), of_lights: Vec::new() }
    }

    fn level_for_patches(&self) -> Option<SimdLevel> {
        self.camera.level_for_patches().or(self.light.level_for_patches())
    }

    fn see_with(
        &mut self,
        shot: &Shot<'_>,
        trace: impl FnOnce(&mut C, &Patches) -> Counts,
    ) -> Result<Work, ImageTooLarge> {
        let built = self.camera.build(shot, &self.patches)?;
        let start = Instant::now();
        let counts = trace(&mut self.camera, &self.patches);
        Ok(Work { counts, seconds: Seconds { trace: start.elapsed().as_secs_f64(), ..built } })
    }
}

impl<C: CameraGrid, L: LightsGrid> Structure for Grids<C, L> {
    fn build(&mut self, triangles: Triangles<'_>) {
        if let Some(level) = self.level_for_patches() {
            self.patches.update(triangles, level);
        }
    }

    fn see(&mut self, shot: &Shot<'_>, seen: &mut SeenPixels) -> Result<Work, ImageTooLarge> {
        self.see_with(shot, |camera, patches| camera.trace(shot, patches, seen))
    }

    fn shadow(&mut self, shot: &Shot<'_>, seen: &SeenPixels, lights: &[LightSource], masks: &mut [LightMask]) -> Work {
        shot.expect_masks(seen, lights, masks);
        let Self { light: grid, patches, of_lights, .. } = self;
        of_lights.clear();
        grid.survey(shot, seen);
        of_lights.extend(lights.iter().zip(masks).map(|(light, mask)| grid.shadow(shot, patches, seen, light, mask)));
        Work::of_lights(of_lights)
    }

    fn work_of_lights(&self) -> &[Work] {
        &self.of_lights
    }

    fn omitted(&self) -> &Omitted {
        self.camera.omitted().unwrap_or_else(|| self.patches.omitted())
    }

    fn bytes(&self) -> Bytes {
        let of_lights = self.light.bytes();
        Bytes { triangles: self.patches.bytes() + self.camera.bytes() + of_lights.triangles, ..of_lights }
    }

    fn validate(&mut self, shot: &Shot<'_>, seen: &SeenPixels, lights: &[LightSource]) -> Result<(), String> {
        self.camera.validate(shot, &self.patches)?;
        self.light.survey(shot, seen);
        lights.iter().try_for_each(|light| self.light.validate(shot, &self.patches, seen, light))
    }

    fn patches(&self) -> Option<&Patches> {
        self.level_for_patches().map(|_| &self.patches)
    }

    fn specialised(&mut self) -> Option<&mut dyn Specialised> {
        Some(self)
    }
}

impl<C: CameraGrid, L: LightsGrid> Specialised for Grids<C, L> {
    fn see_counting(
        &mut self,
        shot: &Shot<'_>,
        seen: &mut SeenPixels,
        work: &mut PixelWork,
    ) -> Result<Work, ImageTooLarge> {
        self.see_with(shot, |camera, patches| camera.trace_counting(shot, patches, seen, work))
    }

    fn locate(&mut self, shot: &Shot<'_>, seen: &SeenPixels, light: &LightSource, cells: &mut LightCells) {
        self.light.survey(shot, seen);
        self.light.locate(shot, &self.patches, seen, light, cells);
    }
}
