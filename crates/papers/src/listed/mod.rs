//! Grids as their paper describes them, with triangles listed by cell (Guntury and Narayanan, *Ray Tracing Dynamic Scenes
//! with Shadows on the GPU*, 2010), for comparison with the [direct grids](umbrage_rays::DirectGrids).

mod camera;
mod light;
mod sorted;

use umbrage_rays::{
    Bytes, Counts, ImageTooLarge, LightCells, LightMask, LightSource, Omitted, PixelWork, Seconds, SeenPixels, Shot,
    SimdLevel, Specialised, Structure, Triangles, Work,
};
use web_time::Instant;

use camera::ListedGrid;
pub use camera::{Cells, ImpossibleCells, ListedOptions};
use light::ListedLightGrid;
pub use light::{ImpossibleLightCells, LightMapping, ListedLightOptions};

/// A grid for the camera and one for each light in turn, as their paper describes them.
#[derive(Debug, Default)]
pub struct ListedGrids {
    camera: ListedGrid,
    light: ListedLightGrid,
    of_lights: Vec<Work>,
}

impl ListedGrids {
    /// Empty grids that use the instructions of `level` and are cut into cells as the options say.
    #[must_use]
    pub fn with_options(level: SimdLevel, camera: ListedOptions, light: ListedLightOptions) -> Self {
        let (camera, light) = (ListedGrid::new(level, camera), ListedLightGrid::new(level, light));
        Self { camera, light, of_lights: Vec::new() }
    }

    fn see_with(
        &mut self,
        shot: &Shot<'_>,
        trace: impl FnOnce(&mut ListedGrid) -> Counts,
    ) -> Result<Work, ImageTooLarge> {
        let built = self.camera.build(shot)?;
        let start = Instant::now();
        let counts = trace(&mut self.camera);
        Ok(Work { counts, seconds: Seconds { trace: start.elapsed().as_secs_f64(), ..built } })
    }
}

impl Structure for ListedGrids {
    fn build(&mut self, _: Triangles<'_>) {}

    fn see(&mut self, shot: &Shot<'_>, seen: &mut SeenPixels) -> Result<Work, ImageTooLarge> {
        self.see_with(shot, |camera| {
            let slots = camera.order().slots();
            camera.trace_tiles(shot, seen, &mut vec![[]; slots])
        })
    }

    fn shadow(&mut self, shot: &Shot<'_>, seen: &SeenPixels, lights: &[LightSource], masks: &mut [LightMask]) -> Work {
        shot.expect_masks(seen, lights, masks);
        let Self { light: grid, of_lights, .. } = self;
        of_lights.clear();
        grid.survey(shot, seen);
        of_lights.extend(lights.iter().zip(masks).map(|(light, mask)| grid.shadow(shot, seen, light, mask)));
        Work::of_lights(of_lights)
    }

    fn work_of_lights(&self) -> &[Work] {
        &self.of_lights
    }

    fn omitted(&self) -> &Omitted {
        self.camera.omitted()
    }

    /// Points and triangles of lights share lists, so all bytes are counted as the triangles'.
    fn bytes(&self) -> Bytes {
        Bytes { triangles: self.camera.bytes() + self.light.bytes(), points: 0 }
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

impl Specialised for ListedGrids {
    fn see_counting(
        &mut self,
        shot: &Shot<'_>,
        seen: &mut SeenPixels,
        work: &mut PixelWork,
    ) -> Result<Work, ImageTooLarge> {
        self.see_with(shot, |camera| {
            let work = work.start(camera.order());
            camera.trace_tiles(shot, seen, work)
        })
    }

    fn locate(&mut self, shot: &Shot<'_>, seen: &SeenPixels, light: &LightSource, cells: &mut LightCells) {
        self.light.survey(shot, seen);
        self.light.locate(shot, seen, light, cells);
    }
}
