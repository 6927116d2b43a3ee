use glam::Vec3;
use umbrage::rays::LightSource;
use umbrage::scene::Frame;
use umbrage::{CameraChoice, Renderer, Scene, Settings, Stage};
use web_time::Instant;

use crate::{Engine, Look};

/// Both engines, and the moment that they were shown last.
#[derive(Debug, Default)]
pub(crate) struct Tracers {
    cpu: Renderer,
    gpu: Option<Renderer>,
    /// Which one rendered the last picture.
    last: Engine,
    /// The moment, if its light was moved.
    moved: Option<Frame>,
}

impl Tracers {
    /// Without what the processor's engine holds of the last scene.
    pub(crate) fn forget_scene(&mut self) {
        *self = Self { gpu: self.gpu.take(), ..Self::default() };
    }

    pub(crate) fn use_gpu(&mut self, renderer: Renderer) {
        self.gpu = Some(renderer);
    }

    /// Renders a moment of a scene by the engine that is asked for. The times of all stages.
    pub(crate) async fn render(&mut self, scene: &Scene, look: &Look) -> Result<Vec<Stage>, String> {
        let Self { cpu, gpu, last, moved } = self;
        let renderer = match look.engine {
            Engine::Cpu => cpu,
            Engine::Gpu => gpu.as_mut().ok_or("there is no GPU")?,
        };
        let mut stages = Vec::new();
        let settings = settings(look);
        if let Some(position) = look.light {
            let frame = moved.get_or_insert_default();
            let start = Instant::now();
            scene.pose(look.seconds, frame).map_err(|error| error.to_string())?;
            stages.push(Stage { name: "animate", milliseconds: start.elapsed().as_secs_f64() * 1e3 });
            move_first_light(frame, Vec3::from(position));
            renderer.render_frame_async(frame, &settings).await
        } else {
            *moved = None;
            renderer.render_async(scene, look.seconds, &settings).await
        }
        .map_err(|error| error.to_string())?;
        *last = look.engine;
        stages.extend(renderer.stats().stages.iter().cloned());
        Ok(stages)
    }

    /// What rendered the last picture.
    pub(crate) fn last(&self) -> &Renderer {
        match (self.last, &self.gpu) {
            (Engine::Gpu, Some(gpu)) => gpu,
            _ => &self.cpu,
        }
    }

    /// The moment that the last picture shows.
    pub(crate) fn frame(&self) -> &Frame {
        self.moved.as_ref().unwrap_or_else(|| self.last().frame())
    }

    /// In how many pixels of a moment the GPU finds another triangle than the processor, or another light's shadow. The last
    /// picture must be the GPU's, of the same look.
    pub(crate) async fn differing(&mut self, scene: &Scene, look: &Look) -> Result<u32, String> {
        self.render(scene, &Look { engine: Engine::Cpu, ..look.clone() }).await?;
        self.last = look.engine;
        let (cpu, gpu) = (&self.cpu, self.gpu.as_ref().ok_or("there is no GPU")?);
        let masks = || cpu.light_masks().iter().zip(gpu.light_masks());
        let is_same = |(index, (x, y)): (usize, (u32, u32))| {
            cpu.film().triangle[index] == gpu.film().triangle[index]
                && masks().all(|(a, b)| a.is_lit(x, y) == b.is_lit(x, y))
        };
        let pixels = (0..look.height).flat_map(|y| (0..look.width).map(move |x| (x, y)));
        Ok(pixels.enumerate().filter(|&pixel| !is_same(pixel)).count() as u32)
    }
}

/// How a look is rendered.
pub(crate) fn settings(look: &Look) -> Settings {
    Settings {
        width: look.width,
        height: look.height,
        samples: look.samples,
        bounces: look.bounces,
        camera: look
            .camera
            .map_or(CameraChoice::Default, |camera| CameraChoice::Own(umbrage::spec::LookAt::from(camera).camera())),
        ..Settings::default()
    }
}

/// Moves the first light; one that looks somewhere looks to the middle of the scene then.
fn move_first_light(frame: &mut Frame, to: Vec3) {
    let towards = (frame.animation_bounds.center() - to).try_normalize();
    let Some(light) = frame.lights.first_mut() else { return };
    match &mut light.source {
        LightSource::Point { position } => *position = to,
        LightSource::Spot { position, direction, .. } => {
            *position = to;
            *direction = towards.unwrap_or(*direction);
        }
        LightSource::Directional { direction } => *direction = towards.unwrap_or(*direction),
    }
}
