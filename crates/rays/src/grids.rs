//! Grids made for the rays of one shot, as a structure.

use web_time::Instant;

use crate::camera_grid::PerspectiveGrid;
use crate::light_grid::LightGrid;
use crate::patches::Patches;
use crate::shot::{Bytes, Counts, LightMask, PixelWork, Seconds, SeenImage, SeenPixels, Shot, Work};
use crate::{ImageTooLarge, LightCells, LightSource, Omitted, SimdLevel, Specialised, Structure, Triangles};

/// The fastest grids: one for the camera and one for each light in turn.
#[derive(Debug, Default)]
pub struct DirectGrids {
    level: SimdLevel,
    camera: PerspectiveGrid,
    light: LightGrid,
    /// The patches that both grids share.
    patches: Patches,
    of_lights: Vec<Work>,
}

impl DirectGrids {
    /// Empty grids that use the instructions of `level`.
    #[must_use]
    pub fn with_level(level: SimdLevel) -> Self {
        let (camera, light) = (PerspectiveGrid::with_level(level), LightGrid::with_level(level));
        Self { level, camera, light, ..Self::default() }
    }

    fn see_with(
        &mut self,
        shot: &Shot<'_>,
        trace: impl FnOnce(&mut PerspectiveGrid, &Patches) -> Counts,
    ) -> Result<Work, ImageTooLarge> {
        let start = Instant::now();
        self.camera.build(shot, &self.patches)?;
        let built = Instant::now();
        let counts = trace(&mut self.camera, &self.patches);
        let (list, trace) = ((built - start).as_secs_f64(), built.elapsed().as_secs_f64());
        Ok(Work { counts, seconds: Seconds { list, trace, ..Seconds::default() } })
    }
}

impl Structure for DirectGrids {
    fn build(&mut self, triangles: Triangles<'_>) {
        self.patches.update(triangles, self.level);
    }

    fn see(&mut self, shot: &Shot<'_>, seen: &mut SeenPixels) -> Result<Work, ImageTooLarge> {
        self.see_with(shot, |camera, patches| {
            let slots = camera.order().slots();
            camera.trace_tiles(shot, patches, seen, &mut vec![[]; slots])
        })
    }

    fn shadow(&mut self, shot: &Shot<'_>, seen: &SeenPixels, lights: &[LightSource], masks: &mut [LightMask]) -> Work {
        shot.expect_masks(seen, lights, masks);
        let Self { light: grid, patches, of_lights, .. } = self;
        of_lights.clear();
        let image = SeenImage { shot, seen };
        grid.survey(image);
        of_lights.extend(lights.iter().zip(masks).map(|(light, mask)| grid.shadow(image, patches, light, mask)));
        Work::of_lights(of_lights)
    }

    fn work_of_lights(&self) -> &[Work] {
        &self.of_lights
    }

    fn omitted(&self) -> &Omitted {
        self.patches.omitted()
    }

    fn bytes(&self) -> Bytes {
        let of_lights = self.light.bytes();
        Bytes { triangles: self.patches.bytes() + self.camera.bytes() + of_lights.triangles, ..of_lights }
    }

    fn validate(&mut self, shot: &Shot<'_>, seen: &SeenPixels, lights: &[LightSource]) -> Result<(), String> {
        self.camera.validate(shot, &self.patches)?;
        let image = SeenImage { shot, seen };
        self.light.survey(image);
        lights.iter().try_for_each(|light| self.light.validate(image, &self.patches, light))
    }

    fn patches(&self) -> Option<&Patches> {
        Some(&self.patches)
    }

    fn specialised(&mut self) -> Option<&mut dyn Specialised> {
        Some(self)
    }
}

impl Specialised for DirectGrids {
    fn see_counting(
        &mut self,
        shot: &Shot<'_>,
        seen: &mut SeenPixels,
        work: &mut PixelWork,
    ) -> Result<Work, ImageTooLarge> {
        self.see_with(shot, |camera, patches| {
            let work = work.start(camera.order());
            camera.trace_tiles(shot, patches, seen, work)
        })
    }

    fn locate(&mut self, shot: &Shot<'_>, seen: &SeenPixels, light: &LightSource, cells: &mut LightCells) {
        let image = SeenImage { shot, seen };
        self.light.survey(image);
        self.light.locate(image, &self.patches, light, cells);
    }
}
