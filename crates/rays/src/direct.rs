use crate::camera_grid::PerspectiveGrid;
use crate::light_grid::LightGrid;
use crate::shot::{Bytes, LightMask, PixelWork, Seconds, SeenPixels, Shot, Work};
use crate::{ImageTooLarge, LightCells, LightSource, Omitted, SimdLevel, Specialised, Structure, Triangles};

/// Grids made for the rays: a [`PerspectiveGrid`] for the camera, and a [`LightGrid`] for each light in turn.
#[derive(Debug, Default)]
pub struct DirectGrids {
    camera: PerspectiveGrid,
    light: LightGrid,
    of_lights: Vec<Work>,
}

impl DirectGrids {
    /// Empty grids that use the instructions of `level`.
    #[must_use]
    pub fn with_level(level: SimdLevel) -> Self {
        let (camera, light) = (PerspectiveGrid::with_level(level), LightGrid::with_level(level));
        Self { camera, light, of_lights: Vec::new() }
    }
}

impl Structure for DirectGrids {
    fn build(&mut self, _: Triangles<'_>) {}

    fn see(&mut self, shot: &Shot<'_>, seen: &mut SeenPixels) -> Result<Work, ImageTooLarge> {
        self.camera.build(shot)?;
        Ok(Work { counts: self.camera.trace(shot, seen), seconds: Seconds::default() })
    }

    fn shadow(&mut self, shot: &Shot<'_>, seen: &SeenPixels, lights: &[LightSource], masks: &mut [&mut LightMask]) -> Work {
        shot.expect_masks(seen, lights, masks);
        let Self { light: grid, of_lights, .. } = self;
        of_lights.clear();
        grid.survey(shot, seen);
        for (light, mask) in lights.iter().zip(masks) {
            grid.shadow(shot, seen, light, mask);
            of_lights.push(grid.work());
        }
        Work::of_lights(of_lights)
    }

    fn work_of_lights(&self) -> &[Work] {
        &self.of_lights
    }

    fn omitted(&self) -> &Omitted {
        self.camera.omitted()
    }

    fn bytes(&self) -> Bytes {
        let of_lights = self.light.bytes();
        Bytes { triangles: self.camera.bytes() + of_lights.triangles, ..of_lights }
    }

    fn validate(&mut self, shot: &Shot<'_>, seen: &SeenPixels, lights: &[LightSource]) -> Result<(), String> {
        self.camera.validate(shot)?;
        self.light.survey(shot, seen);
        lights.iter().try_for_each(|light| self.light.validate(shot, seen, light))
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
        self.camera.build(shot)?;
        Ok(Work { counts: self.camera.trace_counting(shot, seen, work), seconds: Seconds::default() })
    }

    fn locate(&mut self, shot: &Shot<'_>, seen: &SeenPixels, light: &LightSource, cells: &mut LightCells) {
        self.light.survey(shot, seen);
        self.light.locate(shot, seen, light, cells);
    }
}
