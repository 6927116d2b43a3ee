//! The system's file dialogues, each waiting on its own thread.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, channel};

/// The open dialogue, if any.
#[derive(Default)]
pub(crate) struct Dialogs {
    open: Option<(Wanted, Receiver<Option<PathBuf>>)>,
}

/// The purpose of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Wanted {
    Scene,
    /// A background image of all directions.
    Background,
}

impl Wanted {
    /// The dialogue's title, the name of the file type, and its extensions.
    fn words(self) -> (&'static str, &'static str, &'static [&'static str]) {
        match self {
            Self::Scene => ("Open a scene", "Scenes", &["gltf", "glb", "obj", "ply", "stl", "pc2", "mdd"]),
            Self::Background => {
                ("Open a background", "Images of all directions", &["hdr", "exr", "png", "jpg", "jpeg"])
            }
        }
    }

    /// The purpose of a file that is dropped on the window.
    pub(crate) fn of(path: &Path) -> Self {
        let (_, _, of_images) = Self::Background.words();
        let end = path.extension().map(|end| end.to_string_lossy().to_lowercase());
        if end.is_some_and(|end| of_images.contains(&&*end)) { Self::Background } else { Self::Scene }
    }
}

impl Dialogs {
    /// Asks for a file, unless a dialogue is open already.
    pub(crate) fn ask_for(&mut self, wanted: Wanted, wake: impl Fn() + Send + 'static) {
        if self.open.is_some() {
            return;
        }
        let (sender, receiver) = channel();
        let (title, files, ends) = wanted.words();
        let dialog = rfd::AsyncFileDialog::new()
            .set_title(title)
            .add_filter(files, ends)
            .add_filter("All files", &["*"])
            .pick_file();
        std::thread::spawn(move || {
            let chosen = pollster::block_on(dialog).map(|file| file.path().to_owned());
            // The window may be gone.
            sender.send(chosen).ok();
            wake();
        });
        self.open = Some((wanted, receiver));
    }

    /// Returns the chosen file and its purpose, once.
    pub(crate) fn chosen(&mut self) -> Option<(Wanted, PathBuf)> {
        let (wanted, receiver) = self.open.as_ref()?;
        let (wanted, answer) = (*wanted, receiver.try_recv());
        match answer {
            Err(std::sync::mpsc::TryRecvError::Empty) => None,
            answer => {
                self.open = None;
                answer.ok().flatten().map(|path| (wanted, path))
            }
        }
    }
}
