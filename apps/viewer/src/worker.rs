//! The thread that opens scenes and renders them, so that the window never waits.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

use umbrage::rays::Bounds;
use umbrage::scene::OpenOptions;
use umbrage::{Progress, Scene};

use crate::order::{Order, Picture};
use crate::probe::Probe;
use crate::studio::Studio;
use crate::subject;
use crate::window_device::WindowDevice;

/// Takes orders; a newer order replaces a waiting one.
pub(crate) struct Worker {
    waiting: Arc<Waiting>,
    /// Progress of the picture that is being rendered.
    progress: Progress,
    done: Receiver<Done>,
    thread: Option<JoinHandle<()>>,
}

/// A result of the thread.
pub(crate) enum Done {
    /// A scene is open.
    Opened(Opened),
    /// A scene couldn't be opened.
    NotOpened {
        address: PathBuf,
        why: String,
    },
    Picture(Box<Picture>),
    /// A picture's background couldn't be read.
    NoBackground(String),
    /// A picture was stopped on request.
    Stopped,
    /// The probe of a pixel of the last picture.
    Probed(Box<Probe>),
    /// Bounds of the scene's subject, if it has one.
    Subject(Option<Bounds>),
    /// A frame of a recording is written, but not the last.
    Recorded {
        frame: u32,
    },
    /// A screenshot, or a whole recording, is written.
    Written(PathBuf),
    /// A picture couldn't be rendered, or a file not written.
    Failed(String),
}

/// A scene with its address and options.
pub(crate) struct Opened {
    pub(crate) address: PathBuf,
    pub(crate) options: OpenOptions,
    pub(crate) scene: Arc<Scene>,
}

#[derive(Default)]
struct Waiting {
    jobs: Mutex<Jobs>,
    news: Condvar,
}

#[derive(Default)]
struct Jobs {
    open: Option<(PathBuf, OpenOptions)>,
    order: Option<Box<Order>>,
    probe: Option<[u32; 2]>,
    /// A scene and time whose subject is sought.
    subject: Option<(Arc<Scene>, f64)>,
    closes: bool,
}

impl Jobs {
    fn are_none(&self) -> bool {
        let Self { open, order, probe, subject, closes } = self;
        !closes && open.is_none() && order.is_none() && probe.is_none() && subject.is_none()
    }
}

impl Worker {
    /// Starts the thread, which calls `tell` after each result. An engine may share the device of the `window`.
    pub(crate) fn start(window: Option<WindowDevice>, tell: impl Fn() + Send + 'static) -> Self {
        let waiting = Arc::new(Waiting::default());
        let (sender, done) = channel();
        let (jobs, progress) = (Arc::clone(&waiting), Progress::default());
        let reported = progress.clone();
        let thread = std::thread::spawn(move || work(&jobs, window.as_ref(), &reported, &sender, &tell));
        Self { waiting, progress, done, thread: Some(thread) }
    }

    /// Opens a scene. Waiting orders are dropped, and the current picture is stopped.
    pub(crate) fn open(&self, address: PathBuf, options: OpenOptions) {
        self.progress.stop();
        let mut jobs = self.jobs();
        *jobs = Jobs { open: Some((address, options)), closes: jobs.closes, ..Jobs::default() };
        self.waiting.news.notify_one();
    }

    /// Renders a picture, in place of a waiting one.
    pub(crate) fn render(&self, order: Order) {
        self.progress.resume();
        self.jobs().order = Some(Box::new(order));
        self.waiting.news.notify_one();
    }

    /// Stops the current picture, and the waiting one.
    pub(crate) fn stop(&self) {
        self.progress.stop();
    }

    /// Probes a pixel of the last picture.
    pub(crate) fn probe(&self, pixel: [u32; 2]) {
        self.jobs().probe = Some(pixel);
        self.waiting.news.notify_one();
    }

    /// Finds a scene's subject at a time.
    pub(crate) fn find_subject(&self, scene: Arc<Scene>, seconds: f64) {
        self.jobs().subject = Some((scene, seconds));
        self.waiting.news.notify_one();
    }

    /// The results since the last call.
    pub(crate) fn done(&self) -> impl Iterator<Item = Done> {
        self.done.try_iter()
    }

    fn jobs(&self) -> MutexGuard<'_, Jobs> {
        lock(&self.waiting.jobs)
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.jobs().closes = true;
        self.waiting.news.notify_one();
        if let Some(thread) = self.thread.take() {
            self.progress.stop();
            drop(thread.join());
        }
    }
}

/// Ignores poisoning: no holder of the lock panics between two changes.
fn lock(jobs: &Mutex<Jobs>) -> MutexGuard<'_, Jobs> {
    jobs.lock().unwrap_or_else(PoisonError::into_inner)
}

fn work(waiting: &Waiting, window: Option<&WindowDevice>, progress: &Progress, done: &Sender<Done>, tell: &impl Fn()) {
    let mut studio = Studio::new(window.cloned(), progress.clone());
    loop {
        let mut jobs = lock(&waiting.jobs);
        while jobs.are_none() {
            jobs = waiting.news.wait(jobs).unwrap_or_else(PoisonError::into_inner);
        }
        if jobs.closes {
            return;
        }
        let Jobs { open, order, probe, subject, .. } = std::mem::take(&mut *jobs);
        drop(jobs);
        // A bug ends this picture rather than the window.
        let outcome = catch_unwind(AssertUnwindSafe(|| match open {
            Some((address, options)) => vec![opened(address, options)],
            None => {
                // Probed first, since the pixel belongs to the visible picture, which is older than the order.
                let probed = probe.and_then(|pixel| studio.probe(pixel)).map(|probe| Done::Probed(Box::new(probe)));
                let found = subject.map(|(scene, seconds)| Done::Subject(subject::bounds(&scene, seconds)));
                let rendered = order.into_iter().flat_map(|order| studio.render(&order));
                probed.into_iter().chain(found).chain(rendered).collect()
            }
        }));
        let outcome = outcome.unwrap_or_else(|_| {
            studio = Studio::new(window.cloned(), progress.clone());
            vec![Done::Failed("a mistake of the renderer's: it gave up on this picture".to_owned())]
        });
        for news in outcome {
            if done.send(news).is_err() {
                return;
            }
        }
        tell();
    }
}

fn opened(address: PathBuf, options: OpenOptions) -> Done {
    match umbrage::open_with(&address, &options) {
        Ok(scene) => Done::Opened(Opened { address, options, scene: Arc::new(scene) }),
        Err(error) => Done::NotOpened { address, why: error.to_string() },
    }
}
