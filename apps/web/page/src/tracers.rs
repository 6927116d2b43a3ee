use glam::Vec3;
use umbrage::rays::{LightSource, Projection};
use umbrage::scene::Frame;
use umbrage::spec::BackgroundSpec;
use umbrage::{Background, CameraChoice, Renderer, Scene, Settings, Stage};
use web_time::Instant;

use crate::{Engine, Look};

/// Minimum ratio of width to height that a scene's own camera shows: in narrower pictures it is widened.
const LEAST_ASPECT: f32 = 1.25;

/// Minimum height of the picture that measures exposure, in pixels.
const LEAST_METERED: u32 = 180;

/// Both engines, and the last moment rendered.
#[derive(Debug, Default)]
pub(crate) struct Tracers {
    cpu: Renderer,
    gpu: Option<Renderer>,
    /// The engine of the last picture.
    last: Engine,
    /// The moment, if its lights or its camera were changed.
    changed: Option<Frame>,
    is_widened: bool,
}

impl Tracers {
    /// Drops the CPU engine's data of the last scene.
    pub(crate) fn forget_scene(&mut self) {
        *self = Self { gpu: self.gpu.take(), ..Self::default() };
    }

    pub(crate) fn use_gpu(&mut self, renderer: Renderer) {
        self.gpu = Some(renderer);
    }

    /// Renders a moment of a scene by the look's engine, and returns the times of all stages.
    pub(crate) async fn render(&mut self, scene: &Scene, look: &Look) -> Result<Vec<Stage>, String> {
        let Self { cpu, gpu, last, changed, is_widened } = self;
        let renderer = match look.engine {
            Engine::Cpu => cpu,
            Engine::Gpu => gpu.as_mut().ok_or("there is no GPU")?,
        };
        let mut stages = Vec::new();
        let settings = settings(look)?;
        let aspect = look.width as f32 / look.height as f32;
        let may_widen = look.camera.is_none() && aspect < LEAST_ASPECT;
        *is_widened = false;
        if may_widen || look.lights.iter().any(Option::is_some) {
            let frame = changed.get_or_insert_default();
            let start = Instant::now();
            scene.pose(look.seconds, frame).map_err(|error| error.to_string())?;
            stages.push(Stage { name: "animate", milliseconds: start.elapsed().as_secs_f64() * 1e3 });
            for (number, position) in look.lights.iter().enumerate() {
                if let Some(position) = position {
                    move_light(frame, number, Vec3::from(*position));
                }
            }
            *is_widened = may_widen && widen_camera(frame, LEAST_ASPECT / aspect);
            renderer.render_frame_async(frame, &settings).await
        } else {
            *changed = None;
            renderer.render_async(scene, look.seconds, &settings).await
        }
        .map_err(|error| error.to_string())?;
        *last = look.engine;
        stages.extend(renderer.stats().stages.iter().cloned());
        Ok(stages)
    }

    /// The renderer of the last picture.
    pub(crate) fn last(&self) -> &Renderer {
        match (self.last, &self.gpu) {
            (Engine::Gpu, Some(gpu)) => gpu,
            _ => &self.cpu,
        }
    }

    /// The moment that the last picture shows.
    pub(crate) fn frame(&self) -> &Frame {
        self.changed.as_ref().unwrap_or_else(|| self.last().frame())
    }

    /// Whether the last picture's camera is the scene's own, widened for a narrow picture.
    pub(crate) fn is_widened(&self) -> bool {
        self.is_widened
    }

    /// The exposure that suits the scene, measured as the command does for animations: at its best moment, by its own camera and
    /// lights.
    pub(crate) async fn metered_stops(&mut self, scene: &Scene, look: &Look) -> Result<f32, String> {
        // At this height at least, however small the first picture is.
        let height = look.height.max(LEAST_METERED);
        let width =
            (u64::from(look.width) * u64::from(height) / u64::from(look.height.max(1))).clamp(1, 1 << 14) as u32;
        let (bounces, camera) = (Settings::STILL_BOUNCES, CameraChoice::Default);
        let settings = Settings { width, height, bounces, camera, ..settings(look)? };
        let renderer = &mut self.cpu;
        let rendered = renderer.render_async(scene, scene.still_seconds(), &settings.for_metering()).await;
        rendered.map_err(|error| error.to_string())?;
        Ok(renderer.film().metered_stops(renderer.frame()))
    }

    /// Number of pixels of a moment in which the GPU's triangle or light masks differ from the CPU's. The last picture
    /// must be the GPU's, of the same look.
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

/// The settings of a look.
pub(crate) fn settings(look: &Look) -> Result<Settings, String> {
    Ok(Settings {
        width: look.width,
        height: look.height,
        samples: look.samples,
        bounces: look.bounces,
        camera: look
            .camera
            .map_or(CameraChoice::Default, |camera| CameraChoice::Own(umbrage::spec::LookAt::from(camera).camera())),
        background: match look.background.parse()? {
            BackgroundSpec::Sky => Background::Sky,
            BackgroundSpec::Color(color) => Background::Color(color),
            other => return Err(format!("the background `{other}`: give `sky` or a colour, such as #203040")),
        },
        ..Settings::default()
    })
}

/// Widens a scene's own perspective camera by a factor; returns whether it has one.
fn widen_camera(frame: &mut Frame, factor: f32) -> bool {
    let projection = frame.cameras.first_mut().map(|named| &mut named.camera.projection);
    let Some(Projection::Perspective { tan_half_height }) = projection else { return false };
    *tan_half_height *= factor;
    true
}

/// Moves a light; a light with a direction then faces the middle of the scene.
fn move_light(frame: &mut Frame, number: usize, to: Vec3) {
    let towards = (frame.animation_bounds.center() - to).try_normalize();
    let Some(light) = frame.lights.get_mut(number) else { return };
    match &mut light.source {
        LightSource::Point { position } => *position = to,
        LightSource::Spot { position, direction, .. } => {
            *position = to;
            *direction = towards.unwrap_or(*direction);
        }
        LightSource::Directional { direction } => *direction = towards.unwrap_or(*direction),
    }
}
