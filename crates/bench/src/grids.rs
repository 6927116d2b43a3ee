//! Our structures, stage by stage, as the engine calls them.

use std::time::Instant;

use umbrage::rays::{
    Bytes, DirectGrids, ImageTooLarge, LightMask, LightSource, Omitted, Seconds, SeenPixels, Shot as Question,
    SimdLevel, Structure, Triangles, Work,
};
use umbrage_papers::{ListedGrids, ListedLightOptions, ListedOptions};

use crate::shot::Shot;

/// Times of a frame, in milliseconds, over all samples and lights.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Times {
    /// Building before any ray is traced.
    pub(crate) build: f64,
    pub(crate) see: f64,
    /// Survey of the points, once for all lights.
    pub(crate) survey: f64,
    pub(crate) shadow: f64,
}

impl Times {
    pub(crate) fn frame(&self) -> f64 {
        self.build + self.see + self.survey + self.shadow
    }
}

/// Calls `stage` and adds its time to `milliseconds`.
pub(crate) fn time<T>(milliseconds: &mut f64, stage: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let result = stage();
    *milliseconds += start.elapsed().as_secs_f64() * 1e3;
    result
}

/// A pixel's triangle, and whether the last light reaches it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pixel {
    pub(crate) triangle: u32,
    pub(crate) is_lit: bool,
}

/// Forms of the camera's and the lights' grids: the paper's own if they have options for it.
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

impl Forms {
    /// Grids of these forms that use the instructions of `level`.
    pub(crate) fn make(self, level: SimdLevel) -> Box<dyn Structure> {
        let direct = || DirectGrids::with_level(level);
        let listed = ListedGrids::with_options(level, self.camera.unwrap_or_default(), self.lights.unwrap_or_default());
        match (self.camera, self.lights) {
            (None, None) => Box::new(direct()),
            (None, Some(_)) => Box::new(TwoForms { camera: direct(), lights: listed }),
            (Some(_), None) => Box::new(TwoForms { camera: listed, lights: direct() }),
            (Some(_), Some(_)) => Box::new(listed),
        }
    }
}

/// The camera's grid of one form, and the lights' grids of another.
#[derive(Debug)]
struct TwoForms<C, L> {
    camera: C,
    lights: L,
}

impl<C: Structure, L: Structure> Structure for TwoForms<C, L> {
    fn build(&mut self, triangles: Triangles<'_>) {
        self.camera.build(triangles);
        self.lights.build(triangles);
    }

    fn see(&mut self, shot: &Question<'_>, seen: &mut SeenPixels) -> Result<Work, ImageTooLarge> {
        self.camera.see(shot, seen)
    }

    fn shadow(
        &mut self,
        shot: &Question<'_>,
        seen: &SeenPixels,
        lights: &[LightSource],
        masks: &mut [LightMask],
    ) -> Work {
        self.lights.shadow(shot, seen, lights, masks)
    }

    fn work_of_lights(&self) -> &[Work] {
        self.lights.work_of_lights()
    }

    fn omitted(&self) -> &Omitted {
        self.camera.omitted()
    }

    fn bytes(&self) -> Bytes {
        let (camera, lights) = (self.camera.bytes(), self.lights.bytes());
        Bytes { triangles: camera.triangles + lights.triangles, points: camera.points + lights.points }
    }

    fn validate(&mut self, shot: &Question<'_>, seen: &SeenPixels, lights: &[LightSource]) -> Result<(), String> {
        self.camera.validate(shot, seen, &[])?;
        self.lights.validate(shot, seen, lights)
    }
}

/// One of our structures, with its last answers.
#[derive(Debug)]
pub(crate) struct Ours {
    structure: Box<dyn Structure>,
    seen: SeenPixels,
    /// One for each light.
    masks: Vec<LightMask>,
    /// Work of the camera and of the lights for the last traced samples.
    pub(crate) work: [Work; 2],
}

impl Ours {
    pub(crate) fn new(structure: Box<dyn Structure>) -> Self {
        Self { structure, seen: SeenPixels::default(), masks: Vec::new(), work: <[Work; 2]>::default() }
    }

    pub(crate) fn trace(&mut self, shot: &Shot<'_>) -> anyhow::Result<Times> {
        let Self { structure, seen, masks, work: [of_camera, of_lights] } = self;
        let mut times = Times::default();
        time(&mut times.build, || structure.build_parts(shot.frame.triangles(), shot.frame.parts()));
        masks.resize(shot.lights.len(), LightMask::default());
        let opacities = shot.opacities();
        for samples in &shot.samples {
            let question = shot.question(&opacities, samples);
            *of_camera = time(&mut times.see, || structure.see(&question, seen))?;
            // Building a grid for one sample's rays is a part of seeing.
            let Seconds { project, list, sort, .. } = of_camera.seconds;
            let built = 1e3 * (project + list + sort);
            (times.build, times.see) = (times.build + built, times.see - built);
            *of_lights = time(&mut times.shadow, || structure.shadow(&question, seen, &shot.lights, masks));
            let survey = 1e3 * of_lights.seconds.survey;
            (times.survey, times.shadow) = (times.survey + survey, times.shadow - survey);
        }
        Ok(times)
    }

    /// A pixel in the image of the last traced samples; `None` for no triangle.
    pub(crate) fn pixel(&self, x: u32, y: u32) -> Option<Pixel> {
        let triangle = self.seen.triangle_at(x, y);
        let is_lit = self.masks.last().is_some_and(|mask| mask.is_lit(x, y));
        (triangle != SeenPixels::NONE).then_some(Pixel { triangle, is_lit })
    }

    pub(crate) fn bytes(&self) -> Bytes {
        self.structure.bytes()
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use umbrage::rays::{Camera, View};

    use super::*;

    #[test]
    fn camera_and_lights_may_have_grids_of_different_forms() {
        let positions = [[-2, 0, -2], [2, 0, -2], [0, 0, 3], [-1, 1, 0], [1, 1, 0], [0, 1, 1]];
        let positions = positions.map(|position| Vec3::from(position.map(|axis| axis as f32)));
        let triangles = Triangles { positions: &positions, indices: &[[0, 2, 1], [3, 5, 4]] };
        let camera = Camera::look_at(Vec3::new(1.0, 4.0, 3.0), Vec3::ZERO, Vec3::Y, 0.9);
        let shot = Question::new(triangles, View { camera, width: 70, height: 50 });
        let lights = [LightSource::Point { position: Vec3::new(0.3, 3.0, 0.2) }];
        let answers = |forms: Forms| {
            let (mut structure, mut seen) = (forms.make(SimdLevel::default()), SeenPixels::default());
            let mut masks = [LightMask::default()];
            structure.build(triangles);
            structure.see(&shot, &mut seen).expect("a small image");
            structure.shadow(&shot, &seen, &lights, &mut masks);
            assert_eq!(structure.validate(&shot, &seen, &lights), Ok(()), "{forms:?}");
            assert!(structure.bytes().triangles > 0, "{forms:?}");
            (seen.triangle, masks)
        };
        let (camera, lights) = (Some(ListedOptions::DEFAULT), Some(ListedLightOptions::DEFAULT));
        let direct = answers(Forms::default());
        assert!((100..2000).contains(&direct.1[0].count()), "{}", direct.1[0].count());
        for (camera, lights) in [(camera, None), (None, lights), (camera, lights)] {
            assert!(answers(Forms { camera, lights }) == direct, "{camera:?}, {lights:?}");
        }
    }
}
