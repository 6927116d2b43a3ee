//! Pictures, in the library's words for cameras, lights and backgrounds.

use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use glam::Vec3;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use umbrage::scene::{Frame, NamedCamera};
use umbrage::spec::{BackgroundSpec, CameraSpec, LightSpec};
use umbrage::{CameraChoice, Error, Image, Renderer, Settings};

use crate::arrays::hand_over;
use crate::camera::{Camera, size};
use crate::errors::{exception, expected};
use crate::light::Light;
use crate::threads::{handle_signals, pool};

/// How often a render looks whether it shall end.
const LOOK: Duration = Duration::from_millis(50);

/// What is rendered.
#[derive(Clone, Copy)]
pub(crate) enum Subject<'a> {
    /// A scene at a moment, in seconds.
    Moment(&'a umbrage::Scene, f64),
    /// Triangles.
    Frame(&'a Frame),
}

/// How a picture looks, as it is said.
pub(crate) struct Look {
    settings: Settings,
    camera: Option<CameraSpec>,
    /// In place of `camera`.
    own: Option<Camera>,
    lights: Option<Vec<LightSpec>>,
}

impl Look {
    pub(crate) fn new(
        [width, height]: [u32; 2],
        samples: u32,
        camera: Option<&Bound<'_, PyAny>>,
        lights: Option<&Bound<'_, PyAny>>,
        background: &str,
    ) -> PyResult<Self> {
        size(width, height)?;
        let background: BackgroundSpec =
            background.parse().map_err(|why: String| expected("background", &why, background))?;
        let background = background.open().map_err(exception)?;
        let settings = Settings { width, height, samples, background, ..Settings::default() };
        let mut own = None;
        let camera = match camera {
            None => None,
            Some(camera) => match camera.cast::<Camera>() {
                Ok(given) => {
                    own = Some(*given.get());
                    None
                }
                Err(_) => Some(camera_spec(camera)?),
            },
        };
        let lights = lights.map(light_specs).transpose()?;
        Ok(Self { settings, camera, own, lights })
    }

    pub(crate) fn with_light(mut self, bounces: u32, exposure_stops: f32) -> Self {
        (self.settings.bounces, self.settings.exposure_stops) = (bounces, exposure_stops);
        self
    }

    /// The settings for a subject, which says which cameras there are and where its middle is.
    fn settings(&self, subject: Subject<'_>) -> PyResult<Settings> {
        let Self { settings, camera, own, lights } = self;
        let mut settings = settings.clone();
        let origin = match subject {
            Subject::Frame(frame) => frame.origin,
            Subject::Moment(scene, _) => scene.origin(),
        };
        if let Some(own) = own {
            settings.camera = own.local(origin.into()).into();
        }
        if camera.is_none() && lights.is_none() {
            return Ok(settings);
        }
        let posed;
        let frame = match subject {
            Subject::Frame(frame) => frame,
            Subject::Moment(scene, seconds) => {
                posed = scene.at(seconds).map_err(exception)?;
                &posed
            }
        };
        match camera {
            None => {}
            Some(CameraSpec::LookAt(look_at)) => settings.camera = look_at.local(origin).camera().into(),
            Some(CameraSpec::Listed(name)) => settings.camera = listed(name, &frame.cameras)?,
        }
        if let Some(lights) = lights {
            let center = middle(frame);
            settings.lights = Some(lights.iter().map(|light| light.local(origin).light(center)).collect());
        }
        Ok(settings)
    }
}

fn middle(frame: &Frame) -> Vec3 {
    let bounds = if frame.animation_bounds.is_empty() { frame.triangles().bounds() } else { frame.animation_bounds };
    if bounds.is_empty() { Vec3::ZERO } else { bounds.center() }
}

fn listed(name: &str, cameras: &[NamedCamera]) -> PyResult<CameraChoice> {
    let named = cameras.iter().position(|camera| *camera.name == *name);
    let number = named.or_else(|| name.parse().ok().filter(|&number: &usize| number < cameras.len()));
    number.map(CameraChoice::Scene).ok_or_else(|| {
        let names: Vec<String> = cameras.iter().map(|camera| format!("'{}'", camera.name)).collect();
        let wanted = format!("one of the {} cameras of the scene [{}]", cameras.len(), names.join(", "));
        expected("camera", &wanted, name)
    })
}

fn camera_spec(camera: &Bound<'_, PyAny>) -> PyResult<CameraSpec> {
    if let Ok(number) = camera.extract::<usize>() {
        return Ok(CameraSpec::Listed(number.to_string()));
    }
    let wrong = |_| PyTypeError::new_err("camera: expected a Camera, a number or a str");
    let text: String = camera.extract().map_err(wrong)?;
    text.parse().map_err(|why: String| expected("camera", &format!("words such as X,Y,Z:X,Y,Z:FOV ({why})"), &text))
}

fn light_specs(lights: &Bound<'_, PyAny>) -> PyResult<Vec<LightSpec>> {
    let spec = |light: Bound<'_, PyAny>| {
        if let Ok(light) = light.cast::<Light>() {
            return Ok(light.get().spec());
        }
        let wrong = |_| PyTypeError::new_err("lights: expected a sequence of Light or str");
        let text: String = light.extract().map_err(wrong)?;
        text.parse().map_err(|why: String| expected("lights", &format!("words of a light ({why})"), &text))
    };
    if lights.cast::<Light>().is_ok() || lights.extract::<String>().is_ok() {
        return Ok(vec![spec(lights.clone())?]);
    }
    lights.try_iter()?.map(|light| spec(light?)).collect()
}

/// Renders on a thread of its own while this one handles signals, and ends it where one of them raises.
pub(crate) fn render<'py>(
    py: Python<'py>,
    nthreads: usize,
    renderer: &Mutex<Renderer>,
    look: &Look,
    subject: Subject<'_>,
) -> PyResult<Bound<'py, PyAny>> {
    let pool = pool(nthreads)?;
    let image = py.detach(|| {
        let settings = pool.install(|| look.settings(subject))?;
        let renderer = &mut *renderer.lock().unwrap_or_else(PoisonError::into_inner);
        let progress = renderer.progress();
        let (done, waiting) = channel();
        thread::scope(|scope| {
            let worker = scope.spawn(|| {
                let image = pool.install(|| -> Result<Image, Error> {
                    let film = match subject {
                        Subject::Moment(scene, seconds) => renderer.render(scene, seconds, &settings)?,
                        Subject::Frame(frame) => renderer.render_frame(frame, &settings)?,
                    };
                    Ok(film.develop(&settings))
                });
                // Whoever waits is there until this ends.
                let _ = done.send(());
                image
            });
            let mut interrupted = None;
            while let Err(RecvTimeoutError::Timeout) = waiting.recv_timeout(LOOK) {
                if let Err(raised) = handle_signals() {
                    progress.stop();
                    interrupted = Some(raised);
                    break;
                }
            }
            let image = worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            progress.resume();
            interrupted.map_or_else(|| image.map_err(exception), Err)
        })
    })?;
    let Image { width, height, pixels, alpha } = image;
    let eight = |level: u16| ((u32::from(level) + 128) / 257) as u8;
    let channels = if alpha.is_empty() { 3 } else { 4 };
    let mut bytes = Vec::with_capacity(pixels.len() * channels);
    for (pixel, color) in pixels.iter().enumerate() {
        bytes.extend(color.map(eight));
        bytes.extend(alpha.get(pixel).map(|&alpha| eight(alpha)));
    }
    hand_over(py, bytes, &[height as usize, width as usize, channels])
}
