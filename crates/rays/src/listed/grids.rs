use super::{ListedGrid, ListedLightGrid, ListedLightOptions, ListedOptions};
use crate::shot::{Bytes, LightMask, PixelWork, SeenPixels, Shot, Work};
use crate::{ImageTooLarge, LightCells, LightSource, Omitted, SimdLevel, Specialised, Structure, Triangles};

/// Grids as their paper describes them: a [`ListedGrid`] for the camera, and a [`ListedLightGrid`] for each light in turn.
#[derive(Debug, Default)]
pub struct ListedGrids {
    camera: ListedGrid,
    options: ListedOptions,
    light: ListedLightGrid,
    of_lights: Vec<Work>,
}

impl ListedGrids {
    /// Empty grids that use the instructions of `level`, cut into cells as the options say.
    #[must_use]
    pub fn new(level: SimdLevel, camera: ListedOptions, light: ListedLightOptions) -> Self {
        let mut light_grid = ListedLightGrid::with_level(level);
        light_grid.set_options(light);
        Self { camera: ListedGrid::with_level(level), options: camera, light: light_grid, of_lights: Vec::new() }
    }
}

impl Structure for ListedGrids {
    fn build(&mut self, _: Triangles<'_>) {}

    fn see(&mut self, shot: &Shot<'_>, seen: &mut SeenPixels) -> Result<Work, ImageTooLarge> {
        self.camera.build(shot, self.options)?;
        Ok(Work { counts: self.camera.trace(shot, seen), seconds: self.camera.seconds() })
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
        self.camera.validate(shot.triangles)?;
        self.light.survey(shot, seen);
        let mut mask = LightMask::default();
        lights.iter().try_for_each(|light| {
            self.light.shadow(shot, seen, light, &mut mask);
            self.light.validate(shot, seen, light)
        })
    }

    fn specialised(&mut self) -> Option<&mut dyn Specialised> {
        Some(self)
    }
}

impl Specialised for ListedGrids {
    fn see_counting(
        &mut self,
        shot: &Shot<'_>,
        seen: &mut SeenPixels,
        work: &mut PixelWork,
    ) -> Result<Work, ImageTooLarge> {
        self.camera.build(shot, self.options)?;
        Ok(Work { counts: self.camera.trace_counting(shot, seen, work), seconds: self.camera.seconds() })
    }

    fn locate(&mut self, shot: &Shot<'_>, seen: &SeenPixels, light: &LightSource, cells: &mut LightCells) {
        self.light.survey(shot, seen);
        self.light.locate(shot, seen, light, cells);
    }
}
