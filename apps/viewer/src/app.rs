//! The window's state: the open scene, the user's choices, and the picture on the screen.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use eframe::egui::{self, TextureHandle, TextureId};
use serde::{Deserialize, Serialize};
use umbrage::scene::{Clip, Light, NamedCamera, OpenOptions};
use umbrage::spec::{BackgroundSpec, LookAt};
use umbrage::{HeatKind, Scene};

use crate::canvas::{Canvas, Pixels};
use crate::choices::{Choices, EngineChoice, Resolution};
use crate::coarseness::Coarseness;
use crate::dialogs::{Dialogs, Wanted};
use crate::focus::Focus;
use crate::free_camera;
use crate::history::History;
use crate::light_list::LightList;
use crate::notices::Notices;
use crate::order::{FileOrder, Look, Order, Picture};
use crate::pace::Pace;
use crate::probe::Probe;
use crate::recording::Recording;
use crate::show::Show;
use crate::surface::Surface;
use crate::timeline::Timeline;
use crate::watch::Watch;
use crate::window_device::{Graphics, WindowDevice};
use crate::worker::{Done, Opened, Worker};

/// Everything that the window shows and remembers.
pub struct App {
    pub(crate) kept: Kept,
    pub(crate) worker: Worker,
    pub(crate) open: Option<OpenScene>,
    /// The scene that is being opened.
    pub(crate) opening: Option<PathBuf>,
    pub(crate) timeline: Timeline,
    pub(crate) camera: CameraChoice,
    pub(crate) lights: LightList,
    pub(crate) show: Show,
    pub(crate) shows_light_grid: bool,
    canvas: Canvas,
    surface: Surface,
    pub(crate) shown: Option<Shown>,
    /// Center and size of the open scene's subject: where lights are put, and how far they and the camera move.
    pub(crate) focus: Option<Focus>,
    pub(crate) probe: Option<Probe>,
    pub(crate) history: History,
    pub(crate) pace: Pace,
    /// The coarseness of pictures in motion.
    pub(crate) coarseness: Coarseness,
    pub(crate) notices: Notices,
    pub(crate) recording: Option<Recording>,
    pub(crate) watch: Option<Watch>,
    pub(crate) is_help_open: bool,
    /// Size of the picture's area on the screen, in pixels.
    pub(crate) screen: [u32; 2],
    /// The file dialogues.
    pub(crate) dialogs: Dialogs,
    /// The scene and the look of the last order.
    ordered: Option<(u64, Look)>,
    /// The number of the order that is being rendered.
    in_flight: Option<u64>,
    /// Whether that order adds samples to the picture on the screen.
    is_refining: bool,
    /// The full size of the ordered picture, which may be coarser.
    whole: [u32; 2],
    /// Whether the window stores nothing when it closes.
    pub(crate) forgets: bool,
    /// Whether the worker is to find the subject that the camera frames.
    pub(crate) is_framing: bool,
    orders: u64,
    pictures: u64,
    screenshot: Option<PathBuf>,
    title: String,
    /// When the clock last advanced.
    clock: Instant,
}

/// State that outlives the window.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct Kept {
    pub(crate) choices: Choices,
    pub(crate) recent: Vec<PathBuf>,
    pub(crate) shows_work: bool,
    pub(crate) hides_controls: bool,
    pub(crate) hides_strip: bool,
}

/// A scene that is open.
pub(crate) struct OpenScene {
    pub(crate) address: PathBuf,
    pub(crate) options: OpenOptions,
    pub(crate) scene: Arc<Scene>,
    /// Later scenes have higher numbers.
    number: u64,
}

/// The choice of camera.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum CameraChoice {
    /// The scene's first camera, or else one that sees everything.
    Default,
    /// One of the scene's cameras.
    OfScene(usize),
    /// A camera that the user has moved.
    Free(LookAt),
}

/// The picture on the screen.
pub(crate) struct Shown {
    pub(crate) picture: Picture,
    /// The picture's full size, before it is made coarser for motion.
    pub(crate) whole: [u32; 2],
    pub(crate) texture: TextureId,
    /// The colours of its work.
    pub(crate) heat: Option<TextureHandle>,
    /// The tints of a light's cells.
    pub(crate) light_grid: Option<TextureHandle>,
}

/// How the window starts.
#[derive(Clone, Debug, Default)]
pub struct Start {
    /// The scene to open; the built-in cloth if there is none.
    pub scene: Option<PathBuf>,
    /// Which of its animations play, and how fast a sequence is.
    pub options: OpenOptions,
    /// Whether files are read again when they change.
    pub watches: bool,
    /// The engine; `None` for the last choice.
    pub engine: Option<EngineChoice>,
    /// Size of pictures in pixels; `None` for the last choice.
    pub size: Option<[u32; 2]>,
    /// Samples of each pixel of a picture that stays; `None` for the last choice.
    pub samples: Option<u32>,
    /// The lights; `None` for the scene's own.
    pub lights: Option<Vec<Light>>,
    /// Whether stored state is neither read nor written.
    pub forgets: bool,
}

impl App {
    /// Maximum number of remembered files.
    const MOST_RECENT: usize = 12;
    /// The storage key of [`Kept`].
    pub(crate) const KEY: &'static str = "umbrage";

    /// A window's state. `context` is woken whenever there is something new to show. Where `graphics` are known, pictures of
    /// a GPU that draws the window as well stay on it.
    #[must_use]
    pub fn new(
        context: &egui::Context,
        start: Start,
        storage: Option<&dyn eframe::Storage>,
        graphics: Option<Graphics>,
    ) -> Self {
        let storage = storage.filter(|_| !start.forgets);
        let mut kept: Kept = storage.and_then(|storage| eframe::get_value(storage, Self::KEY)).unwrap_or_default();
        if let Some(engine) = start.engine {
            kept.choices.engine = engine;
        }
        if let Some(size) = start.size {
            kept.choices.resolution = Resolution::Fixed(size);
        }
        if let Some(samples) = start.samples {
            kept.choices.samples = samples;
        }
        let woken = context.clone();
        let device = graphics.as_ref().and_then(WindowDevice::of);
        let mut app = Self {
            kept,
            worker: Worker::start(device, move || woken.request_repaint()),
            open: None,
            opening: None,
            timeline: Timeline::default(),
            camera: CameraChoice::Default,
            lights: start.lights.map_or_else(LightList::default, LightList::of),
            show: Show::Light,
            shows_light_grid: false,
            surface: graphics.as_ref().map(|graphics| graphics.surface.clone()).unwrap_or_default(),
            canvas: Canvas::new(graphics.map(|graphics| graphics.state)),
            shown: None,
            focus: None,
            probe: None,
            history: History::default(),
            pace: Pace::default(),
            coarseness: Coarseness::default(),
            notices: Notices::default(),
            recording: None,
            watch: start.watches.then(Watch::default),
            is_help_open: false,
            screen: [0, 0],
            dialogs: Dialogs::default(),
            ordered: None,
            in_flight: None,
            is_refining: false,
            whole: [0, 0],
            forgets: start.forgets,
            is_framing: false,
            orders: 0,
            pictures: 0,
            screenshot: None,
            title: String::new(),
            clock: Instant::now(),
        };
        app.open(start.scene.unwrap_or_else(|| "demo:cloth".into()), start.options);
        app
    }

    /// Opens a scene in place of the one that is open, once it is read.
    pub(crate) fn open(&mut self, address: PathBuf, options: OpenOptions) {
        self.opening = Some(address.clone());
        self.is_framing = false;
        self.worker.open(address, options);
    }

    /// Opens a file as a scene or as a background.
    pub(crate) fn open_as(&mut self, wanted: Wanted, path: PathBuf) {
        match wanted {
            Wanted::Scene => self.open(path, OpenOptions::for_pictures()),
            Wanted::Background => self.kept.choices.surroundings = BackgroundSpec::File(path),
        }
    }

    /// Opens the same scene with another of its animations, or because its file has changed.
    pub(crate) fn reopen(&mut self, options: Option<OpenOptions>) {
        if let Some(open) = &self.open {
            let (address, options) = (open.address.clone(), options.unwrap_or_else(|| open.options.clone()));
            self.open(address, options);
        }
    }

    /// Shows all objects of the open scene but those with these names.
    pub(crate) fn hide(&mut self, names: Vec<String>) {
        self.stop_refining();
        let Some(open) = &mut self.open else { return };
        match open.scene.hiding(&names) {
            Ok(scene) => {
                (open.scene, open.options.hidden) = (Arc::new(scene), names);
                open.number += 1;
                self.in_flight = None;
            }
            Err(why) => self.notices.error(why),
        }
    }

    /// Takes over the worker's results, and advances time.
    pub(crate) fn receive(&mut self, context: &egui::Context) {
        for done in self.worker.done().collect::<Vec<_>>() {
            self.take(context, done);
        }
        if let Some(news) = self.surface.news() {
            self.notices.error(news);
        }
        let now = Instant::now();
        let passed = now.duration_since(std::mem::replace(&mut self.clock, now)).as_secs_f64();
        if let Some((wanted, path)) = self.dialogs.chosen() {
            self.open_as(wanted, path);
        }
        if let (Some(watch), Some(open)) = (&mut self.watch, &self.open) {
            context.request_repaint_after(Watch::INTERVAL);
            if watch.has_changed(&open.address) && self.opening.is_none() {
                self.reopen(None);
            }
        }
        match &self.recording {
            // Each frame is shown for the time that it takes.
            Some(recording) => self.timeline.seconds = recording.seconds(),
            None => self.timeline.advance(passed),
        }
    }

    fn take(&mut self, context: &egui::Context, done: Done) {
        match done {
            Done::Opened(opened) => self.opened(opened),
            Done::NotOpened { address, why } => {
                self.opening = None;
                self.kept.recent.retain(|recent| *recent != address);
                self.notices.error(why);
            }
            Done::Picture(picture) => self.replace_picture(context, *picture),
            // Choices made meanwhile are ordered from their first picture on.
            Done::Stopped => (self.in_flight, self.ordered) = (None, None),
            Done::NoBackground(why) => {
                (self.in_flight, self.ordered) = (None, None);
                self.kept.choices.surroundings = BackgroundSpec::default();
                self.notices.error(why);
            }
            Done::Probed(probe) => self.probe = Some(*probe),
            Done::Subject(subject) => self.frame_found(subject),
            Done::Recorded { frame } => {
                if let Some(recording) = &mut self.recording {
                    recording.frame = frame + 1;
                }
            }
            Done::Written(path) => {
                self.recording = None;
                self.notices.say(format!("Written: {}", path.display()));
            }
            Done::Failed(why) => {
                self.in_flight = None;
                self.recording = None;
                self.is_framing = false;
                // The next moment would most likely fail as well.
                self.timeline.is_playing = false;
                self.notices.error(why);
            }
        }
    }

    fn opened(&mut self, opened: Opened) {
        let Opened { address, options, scene } = opened;
        self.opening = None;
        self.in_flight = None;
        let is_same = self.open.as_ref().is_some_and(|open| open.address == address);
        if self.open.is_some() && !is_same {
            self.camera = CameraChoice::Default;
            self.lights.reset();
            self.timeline.seconds = 0.0;
            self.probe = None;
            self.focus = None;
        }
        self.timeline.set_duration(scene.duration_seconds());
        self.coarseness.clear();
        if !is_same {
            self.timeline.is_playing = self.timeline.moves();
        }
        for warning in scene.warnings() {
            self.notices.say(warning.clone());
        }
        self.kept.recent.retain(|recent| *recent != address);
        self.kept.recent.insert(0, address.clone());
        self.kept.recent.truncate(Self::MOST_RECENT);
        let number = self.open.as_ref().map_or(0, |open| open.number + 1);
        self.open = Some(OpenScene { address, options, scene, number });
    }

    fn replace_picture(&mut self, context: &egui::Context, mut picture: Picture) {
        // Pictures of a replaced scene are dropped.
        if self.in_flight != Some(picture.number) {
            return;
        }
        self.in_flight = None;
        let size = picture.size();
        let image = |pixels| egui::ColorImage::new(size, pixels);
        let heat = picture
            .heat
            .as_ref()
            .map(|heat| context.load_texture("heat map", image(heat.pixels()), egui::TextureOptions::NEAREST));
        let light_grid = picture
            .light_grid
            .as_ref()
            .map(|grid| context.load_texture("light grid", image(grid.tints.clone()), egui::TextureOptions::NEAREST));
        let Some(texture) = self.canvas.show(context, size, std::mem::replace(&mut picture.pixels, Pixels::Shown))
        else {
            return self.notices.error("the picture is on a device that this window doesn't draw with".to_owned());
        };
        self.lights.follow(&picture.lights);
        self.entitle(context, &picture.device);
        // The chart is of pictures with the same number of samples.
        if self.is_refining {
            self.pace.clear();
        } else {
            self.history.add(&picture);
            self.pace.add(Instant::now());
            if self.may_be_coarse() {
                self.coarseness.add(picture.milliseconds);
            }
        }
        self.pictures += 1;
        self.focus = self.focus.or(picture.focus);
        self.shown = Some(Shown { picture, whole: self.whole, texture, heat, light_grid });
    }

    /// Names the window after the scene and the device that renders it.
    fn entitle(&mut self, context: &egui::Context, device: &str) {
        let scene = self.address().map(|address| address.display().to_string()).unwrap_or_default();
        let title = format!("{scene} - {device} - Umbrage");
        if title != self.title {
            context.send_viewport_cmd(egui::ViewportCommand::Title(title.clone()));
            self.title = title;
        }
    }

    /// Orders a picture of the user's choices, unless it equals the last order or that one is still being rendered. A
    /// picture that stays is followed by ones with more samples, until something changes.
    pub(crate) fn order(&mut self) {
        let Some(open) = &self.open else { return };
        if self.screen.contains(&0) {
            return;
        }
        let choices = &self.kept.choices;
        let mut settings = choices.settings(self.screen);
        if let Some(recording) = &self.recording {
            [settings.width, settings.height] = recording.size;
        }
        settings.lights = self.lights.chosen();
        settings.camera = match &self.camera {
            CameraChoice::Default => umbrage::CameraChoice::Default,
            CameraChoice::OfScene(camera) => umbrage::CameraChoice::Scene(*camera),
            CameraChoice::Free(free) => free.camera().into(),
        };
        let needs_light = self.show == Show::Heat(HeatKind::Points) || self.shows_light_grid;
        let mut look = Look {
            seconds: self.timeline.seconds,
            settings,
            background: choices.surroundings.clone(),
            engine: choices.engine.clone(),
            show: self.show,
            shows_light_grid: self.shows_light_grid,
            light: needs_light.then(|| self.lights.selected.unwrap_or(0)),
        };
        let is_file = self.recording.is_some() || self.screenshot.is_some();
        let shown =
            self.ordered.as_ref().filter(|(scene, ordered)| *scene == open.number && ordered.differs_in_samples(&look));
        let is_same = shown.is_some();
        // A coarse picture is followed by a whole one.
        let samples = shown.filter(|_| !self.is_coarse()).map(|(_, ordered)| ordered.settings.samples);
        if self.in_flight.is_some() {
            if is_file || !is_same {
                self.stop_refining();
            }
            return;
        }
        if !is_file {
            look.settings.samples = choices.samples_after(samples);
            if samples == Some(look.settings.samples) {
                return;
            }
        }
        let file = match (&self.recording, self.screenshot.take()) {
            (Some(recording), _) => Some(FileOrder::Frame(recording.clone())),
            (None, screenshot) => screenshot.map(FileOrder::Still),
        };
        self.is_refining = !is_file && is_same;
        self.ordered = Some((open.number, look.clone()));
        self.whole = [look.settings.width, look.settings.height];
        if !is_file && !is_same && self.may_be_coarse() {
            [look.settings.width, look.settings.height] = self.coarseness.size(self.whole);
        }
        self.orders += 1;
        self.in_flight = Some(self.orders);
        let (number, scene) = (self.orders, Arc::clone(&open.scene));
        self.worker.render(Order { number, scene, look, needs_focus: self.focus.is_none(), file });
    }

    /// Whether the picture on the screen has fewer pixels than one that stays.
    fn is_coarse(&self) -> bool {
        self.shown.as_ref().is_some_and(|shown| shown.picture.size() != shown.whole.map(|side| side as usize))
    }

    /// Whether pictures in motion may be coarse: false where the user inspects single pixels.
    fn may_be_coarse(&self) -> bool {
        let is_fixed = matches!(self.kept.choices.resolution, Resolution::Fixed(_));
        !is_fixed && self.show == Show::Light && !self.shows_light_grid && self.recording.is_none()
    }

    /// Stops the current picture if it only adds samples.
    pub(crate) fn stop_refining(&self) {
        if self.is_refining && self.in_flight.is_some() {
            self.worker.stop();
        }
    }

    /// Writes the next picture to a file.
    pub(crate) fn take_screenshot(&mut self, path: PathBuf) {
        self.screenshot = Some(path);
    }

    /// The free camera, which starts where the picture is seen from; `None` before the first picture.
    pub(crate) fn free_camera(&mut self) -> Option<&mut LookAt> {
        if !matches!(self.camera, CameraChoice::Free(_)) {
            let picture = &self.shown.as_ref()?.picture;
            let camera = picture.view.camera;
            let Focus { center, size } = picture.focus.unwrap_or(self.focus());
            let depth = (center - camera.position).dot(camera.forward);
            let depth = if depth > 0.0 { depth } else { size };
            self.camera = CameraChoice::Free(free_camera::of(&camera, depth));
        }
        match &mut self.camera {
            CameraChoice::Free(free) => Some(free),
            CameraChoice::Default | CameraChoice::OfScene(_) => None,
        }
    }

    /// The scene's subject.
    pub(crate) fn focus(&self) -> Focus {
        self.focus.unwrap_or_default()
    }

    pub(crate) fn cameras(&self) -> &[NamedCamera] {
        self.shown.as_ref().map_or(&[], |shown| &shown.picture.cameras)
    }

    /// Which of the open scene's animations play.
    pub(crate) fn clip(&self) -> Clip {
        self.open.as_ref().map_or(Clip::Auto, |open| open.options.clip.clone())
    }

    /// The open scene's address.
    pub(crate) fn address(&self) -> Option<&Path> {
        self.open.as_ref().map(|open| open.address.as_path())
    }

    /// Samples of each pixel of the shown picture; 0 before the first.
    #[must_use]
    pub fn samples(&self) -> u32 {
        self.shown.as_ref().map_or(0, |shown| shown.picture.stats.samples)
    }

    /// The words where the picture will be, until there is one.
    pub(crate) fn in_place_of_a_picture(&self) -> &'static str {
        match (self.opening.is_some(), self.open.is_some()) {
            (true, _) => "Opening …",
            (false, false) => "Drop a scene here",
            (false, true) if self.in_flight.is_some() || self.ordered.is_none() => "Rendering …",
            (false, true) => "No picture",
        }
    }

    /// Number of pictures shown so far.
    #[must_use]
    pub fn pictures(&self) -> u64 {
        self.pictures
    }

    /// Whether nothing is being opened or written, and the picture of the current choices is on the screen, perhaps with
    /// some of its samples: while an animation plays, its last picture.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        let is_shown = if self.timeline.is_playing {
            self.shown.is_some()
        } else {
            !self.is_coarse() && (self.in_flight.is_none() || self.is_refining)
        };
        is_shown && self.opening.is_none() && !self.is_framing && self.recording.is_none() && self.screenshot.is_none()
    }
}
