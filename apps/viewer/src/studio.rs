//! The worker's renderer, and its state between pictures.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Instant;

use eframe::egui::Color32;
use umbrage::gpu::{DeviceLimits, Gpu, GpuError};
use umbrage::output::{BitDepth, Format, FrameRate, Options, Target, Writer, write_png};
use umbrage::rays::View;
use umbrage::spec::BackgroundSpec;
use umbrage::{Background, Error, Film, Progress, Renderer, Settings, output};

use crate::canvas::Pixels;
use crate::choices::EngineChoice;
use crate::focus::Focus;
use crate::heat::HeatMaker;
use crate::order::{FileOrder, Order, Picture};
use crate::probe::Probe;
use crate::recording;
use crate::show::Show;
use crate::timeline::Timeline;
use crate::window_device::WindowDevice;
use crate::worker::Done;

/// Renders orders.
#[derive(Default)]
pub(crate) struct Studio {
    /// The window's device, where an engine may share it.
    window: Option<WindowDevice>,
    /// Receives every picture's progress.
    progress: Progress,
    engine: Option<Engine>,
    heat: HeatMaker,
    /// The last picture's background.
    background: Option<(BackgroundSpec, Background)>,
    /// The last picture's view and sides, to probe its pixels.
    last: Option<(View, umbrage::Sides)>,
    recording: Option<Recording>,
    pixels: Vec<[u8; 4]>,
}

struct Engine {
    choice: EngineChoice,
    renderer: Renderer,
    device: String,
    /// Whether the engine shares the window's device; the window then draws its textures.
    is_windows: bool,
}

struct Recording {
    path: PathBuf,
    frame: u32,
    writer: Writer,
}

impl Studio {
    /// Makes a studio. Pictures of an engine on the window's device stay there.
    pub(crate) fn new(window: Option<WindowDevice>, progress: Progress) -> Self {
        Self { window, progress, ..Self::default() }
    }

    /// Renders a picture, or returns the reason why it failed.
    pub(crate) fn render(&mut self, order: &Order) -> Vec<Done> {
        match self.picture(order) {
            Ok(done) => done,
            Err(why) => {
                self.recording = None;
                vec![Done::Failed(why)]
            }
        }
    }

    /// Probes a pixel of the last picture.
    pub(crate) fn probe(&self, pixel: [u32; 2]) -> Option<Probe> {
        let (engine, (view, sides)) = (self.engine.as_ref()?, self.last?);
        let is_inside = pixel[0] < view.width && pixel[1] < view.height;
        is_inside.then(|| Probe::new(engine.renderer.frame(), &view, pixel, sides))
    }

    fn picture(&mut self, order: &Order) -> Result<Vec<Done>, String> {
        let start = Instant::now();
        let look = &order.look;
        let engine = Self::engine(&mut self.engine, &look.engine, self.window.as_ref())?;
        engine.renderer.report_to(self.progress.clone());
        let background = match background(&mut self.background, &look.background) {
            Ok(background) => background,
            Err(why) => return Ok(vec![Done::NoBackground(why)]),
        };
        let mut settings = Settings { background, ..look.settings.clone() };
        let (scene, seconds) = (&order.scene, look.seconds);
        // Files, views and the focus are made from the film.
        let needs_film = order.file.is_some() || look.show != Show::Light || order.needs_focus;
        let rendered = if engine.is_windows && !needs_film {
            engine.renderer.render_to_texture(scene, seconds, &settings).map(Some)
        } else {
            engine.renderer.render(scene, seconds, &settings).map(|_| None)
        };
        let texture = match rendered {
            Ok(texture) => texture,
            Err(Error::Stopped) => return Ok(vec![Done::Stopped]),
            Err(error) => {
                if let Error::Gpu(_) = error {
                    // Another device may succeed.
                    self.engine = None;
                }
                return Err(error.to_string());
            }
        };
        if let Some(pixel_view) = look.show.view() {
            let mut film = Film::default();
            engine.renderer.swap_film(&mut film);
            pixel_view.paint(&mut film, engine.renderer.frame());
            engine.renderer.swap_film(&mut film);
        }
        let renderer = &engine.renderer;
        let view = renderer.view().ok_or("nothing was rendered")?;
        settings.camera = view.camera.into();
        self.last = Some((view, settings.sides));
        let scenery = renderer.scenery();
        let film = texture.is_none().then(|| renderer.film());
        let focus = film.map(|film| Focus::new(film, &view, scenery.animation_bounds));
        let pixels = if let Some(texture) = texture {
            Pixels::OnDevice(texture)
        } else {
            renderer.film().develop_for_screen(&settings, &mut self.pixels);
            let pixels = self.pixels.iter().map(|&[red, green, blue, _]| Color32::from_rgb(red, green, blue));
            Pixels::Copied(pixels.collect())
        };
        let heat = look.show.heat().map(|heat| self.heat.make(heat, order, renderer, &settings)).transpose()?;
        let light_grid =
            look.shows_light_grid.then(|| self.heat.light_grid(order, renderer, &settings)).transpose()?.flatten();
        let picture = Picture {
            number: order.number,
            seconds,
            view,
            pixels,
            heat,
            light_grid,
            stats: renderer.stats().clone(),
            device: engine.device.clone(),
            lights: scenery.lights.clone(),
            cameras: scenery.cameras.clone(),
            bounds: scenery.animation_bounds,
            focus,
            milliseconds: start.elapsed().as_secs_f64() * 1e3,
        };
        let mut done = vec![Done::Picture(Box::new(picture))];
        if let Some(file) = &order.file {
            done.extend(write(&mut self.recording, file, &mut engine.renderer, &settings)?);
        }
        Ok(done)
    }

    /// Opens an engine, which stays open until another is chosen.
    fn engine<'a>(
        open: &'a mut Option<Engine>,
        choice: &EngineChoice,
        window: Option<&WindowDevice>,
    ) -> Result<&'a mut Engine, String> {
        if open.as_ref().is_none_or(|open| open.choice != *choice) {
            // Closed first, since there may be no memory for both.
            *open = None;
            let choice = choice.clone();
            let engine = match &choice {
                EngineChoice::Cpu => {
                    let device = format!("CPU with {}", umbrage::rays::SimdLevel::default());
                    Engine { choice, renderer: Renderer::default(), device, is_windows: false }
                }
                EngineChoice::Gpu(name) => {
                    let (gpu, is_windows) = device(name, window).map_err(|error| error.to_string())?;
                    let stay = if is_windows { "; pictures stay on it" } else { "" };
                    let device = format!("{}{stay}", gpu.adapter().name);
                    let renderer = Renderer::with_gpu(gpu).map_err(|error| error.to_string())?;
                    Engine { choice, renderer, device, is_windows }
                }
            };
            return Ok(open.insert(engine));
        }
        open.as_mut().ok_or_else(|| "no engine is open".to_owned())
    }
}

/// Opens a background, which is kept until another is wanted.
fn background(open: &mut Option<(BackgroundSpec, Background)>, wanted: &BackgroundSpec) -> Result<Background, String> {
    match open {
        Some((spec, background)) if spec == wanted => Ok(background.clone()),
        _ => {
            let background = wanted.open().map_err(|error| error.to_string())?;
            *open = Some((wanted.clone(), background.clone()));
            Ok(background)
        }
    }
}

/// Opens the device called `name`. Returns whether it is the window's.
fn device(name: &str, window: Option<&WindowDevice>) -> Result<(Gpu, bool), GpuError> {
    let of_window = window.map(|window| window.gpu(name)).transpose()?.flatten();
    match of_window {
        Some(gpu) => Ok((gpu, true)),
        None => Ok((Gpu::open(name, DeviceLimits::Adapter)?, false)),
    }
}

fn write(
    recording: &mut Option<Recording>,
    file: &FileOrder,
    renderer: &mut Renderer,
    settings: &Settings,
) -> Result<Option<Done>, String> {
    match file {
        FileOrder::Still(path) => {
            let image = renderer.film().develop(settings);
            write_png(&image, path, BitDepth::Eight).map_err(|error| error.to_string())?;
            Ok(Some(Done::Written(path.clone())))
        }
        FileOrder::Frame(recording::Recording { path, frame, frames, .. }) => {
            let running = match recording {
                Some(running) if running.path == *path && running.frame == *frame => running,
                _ if *frame == 0 => recording.insert(start(path, 0..*frames, settings)?),
                _ => return Ok(None),
            };
            let (mut film, mut picture) = (Film::default(), output::Picture::default());
            renderer.swap_film(&mut film);
            running.writer.form().develop(&mut film, settings, &mut picture);
            renderer.swap_film(&mut film);
            running.writer.write(*frame, &picture).map_err(|error| error.to_string())?;
            running.frame += 1;
            if running.frame < *frames {
                return Ok(Some(Done::Recorded { frame: *frame }));
            }
            let finished = recording.take().map_or(Ok(()), |recording| recording.writer.finish());
            finished.map_err(|error| error.to_string())?;
            Ok(Some(Done::Written(path.clone())))
        }
    }
}

fn start(path: &Path, frames: Range<u32>, settings: &Settings) -> Result<Recording, String> {
    let format = Format::of_path(path).ok_or_else(|| format!("{}: not a name of a .gif or .png", path.display()))?;
    let rate = FrameRate::new(Timeline::FPS, 1).unwrap_or_default();
    let options = Options { rate, ..Options::default() };
    let writer = Writer::create(&Target::Path(path.to_owned()), format, &frames, settings, &options);
    Ok(Recording { path: path.to_owned(), frame: 0, writer: writer.map_err(|error| error.to_string())? })
}
