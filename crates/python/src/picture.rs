//! Pictures, in the library's words for cameras, lights and backgrounds.

use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use glam::Vec3;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use umbrage::rays::Bounds;
use umbrage::scene::{Frame, NamedCamera};
use umbrage::spec::{BackgroundSpec, CameraSpec, LightSpec};
use umbrage::{CameraChoice, Error, Image, Renderer, Settings};

use crate::arrays::hand_over;
use crate::camera::{Camera, size};
use crate::errors::{exception, expected};
use crate::light;
use crate::threads::{handle_signals, pool};

/// Interval at which a render checks for signals.
const LOOK: Duration = Duration::from_millis(50);

/// The triangles to render.
#[derive(Clone, Copy)]
pub(crate) enum Subject<'a> {
    /// A scene at a moment, in seconds.
    Moment(&'a umbrage::Scene, f64),
    /// Triangles.
    Frame(&'a Frame),
}

/// The arguments of a picture.
pub(crate) struct Look {
    settings: Settings,
    camera: Option<CameraSpec>,
    /// In place of `camera`.
    own: Option<Camera>,
    lights: Option<Vec<LightSpec>>,
    /// The upper left corner and the size of the part that is kept.
    part: [[u32; 2]; 2],
    /// Whether the stops are those that suit the film.
    measures_exposure: bool,
}

impl Look {
    /// The default size of pictures.
    const SIZE: [u32; 2] = [1280, 720];

    pub(crate) fn new(
        [width, height]: [Option<u32>; 2],
        samples: u32,
        camera: Option<&Bound<'_, PyAny>>,
        lights: Option<&Bound<'_, PyAny>>,
        background: &str,
    ) -> PyResult<Self> {
        let background: BackgroundSpec =
            background.parse().map_err(|why: String| expected("background", &why, background))?;
        let background = background.open().map_err(exception)?;
        let mut settings = Settings { samples, background, ..Settings::default() };
        let own = camera.and_then(|camera| camera.cast::<Camera>().ok());
        let (camera, canvas) = match own {
            Some(own) => {
                let own = own.get();
                let [or_width, or_height] = if own.has_image() { [None; 2] } else { Self::SIZE.map(Some) };
                (None, Some(own.canvas(width.or(or_width), height.or(or_height))?))
            }
            None => (camera.map(camera_spec).transpose()?, None),
        };
        let part = match canvas {
            Some(canvas) => {
                [settings.width, settings.height] = canvas.size;
                [canvas.corner, canvas.part]
            }
            None => {
                [settings.width, settings.height] = [width.unwrap_or(Self::SIZE[0]), height.unwrap_or(Self::SIZE[1])];
                size(settings.width, settings.height)?;
                [[0; 2], [settings.width, settings.height]]
            }
        };
        let lights = lights.map(light::specs).transpose()?;
        let own = canvas.map(|canvas| canvas.camera);
        Ok(Self { settings, camera, own, lights, part, measures_exposure: false })
    }

    pub(crate) fn with_bounces(mut self, bounces: u32) -> Self {
        self.settings.bounces = bounces;
        self
    }

    /// With stops, or as many as are measured for `"auto"`.
    pub(crate) fn with_exposure(mut self, exposure: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        let Some(exposure) = exposure else { return Ok(self) };
        self.measures_exposure = exposure.extract::<String>().is_ok_and(|word| word == "auto");
        if !self.measures_exposure {
            let stops = exposure.extract();
            self.settings.exposure_stops = stops.map_err(|_| expected("exposure", "a number or 'auto'", exposure))?;
        }
        Ok(self)
    }

    /// The settings for a subject, whose cameras and middle they may refer to.
    fn settings(&self, subject: Subject<'_>) -> PyResult<Settings> {
        let Self { settings, camera, own, lights, .. } = self;
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
            let bounds = bounds(frame);
            let center = if bounds.is_empty() { Vec3::ZERO } else { bounds.center() };
            let size = match subject {
                Subject::Moment(scene, _) => scene.size(),
                Subject::Frame(_) if bounds.is_empty() => 0.0,
                Subject::Frame(_) => bounds.size().length(),
            };
            settings.lights = Some(lights.iter().map(|light| light.local(origin).light(center, size)).collect());
        }
        Ok(settings)
    }
}

fn bounds(frame: &Frame) -> Bounds {
    if frame.animation_bounds.is_empty() { frame.bounds() } else { frame.animation_bounds }
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

/// Renders on a thread of its own while this one handles signals, and stops it if a handler raises.
pub(crate) fn render<'py>(
    py: Python<'py>,
    nthreads: usize,
    renderer: &Mutex<Renderer>,
    look: &Look,
    subject: Subject<'_>,
) -> PyResult<Bound<'py, PyAny>> {
    let pool = pool(nthreads)?;
    let image = py.detach(|| {
        let mut settings = pool.install(|| look.settings(subject))?;
        let renderer = &mut *renderer.lock().unwrap_or_else(PoisonError::into_inner);
        let progress = renderer.progress();
        let (done, waiting) = channel();
        thread::scope(|scope| {
            let worker = scope.spawn(|| {
                let image = pool.install(|| -> Result<Image, Error> {
                    match subject {
                        Subject::Moment(scene, seconds) => renderer.render(scene, seconds, &settings)?,
                        Subject::Frame(frame) => renderer.render_frame(frame, &settings)?,
                    };
                    let film = renderer.film();
                    if look.measures_exposure {
                        let shown = match subject {
                            Subject::Moment(..) => renderer.frame(),
                            Subject::Frame(frame) => frame,
                        };
                        settings.exposure_stops = film.metered_stops(shown);
                    }
                    Ok(film.develop(&settings))
                });
                // The receiver exists until this thread ends.
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
    let Image { width: all_columns, pixels, alpha, .. } = image;
    let [[left, top], [width, height]] = look.part.map(|pair| pair.map(|number| number as usize));
    let eight = |level: u16| ((u32::from(level) + 128) / 257) as u8;
    let channels = if alpha.is_empty() { 3 } else { 4 };
    let mut bytes = Vec::with_capacity(width * height * channels);
    for row in top..top + height {
        let first = row * all_columns as usize + left;
        let alpha = alpha.get(first..first + width).unwrap_or_default();
        for (column, pixel) in pixels[first..first + width].iter().enumerate() {
            bytes.extend(pixel.map(eight));
            bytes.extend(alpha.get(column).map(|&alpha| eight(alpha)));
        }
    }
    let class = py.import("umbrage.picture")?.getattr("Picture")?;
    hand_over(py, bytes, &[height, width, channels])?.call_method1("view", (class,))
}
