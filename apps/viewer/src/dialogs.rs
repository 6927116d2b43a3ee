//! The system's own dialogues, which wait on threads of theirs.

use std::path::PathBuf;
use std::sync::mpsc::{Receiver, channel};

/// A dialogue that may be open.
#[derive(Default)]
pub(crate) struct Dialogs {
    open: Option<Receiver<Option<PathBuf>>>,
}

impl Dialogs {
    /// Asks for a scene's file, unless that is being done already.
    pub(crate) fn ask_for_scene(&mut self, wake: impl Fn() + Send + 'static) {
        if self.open.is_some() {
            return;
        }
        let (sender, receiver) = channel();
        let dialog = rfd::AsyncFileDialog::new()
            .set_title("Open a scene")
            .add_filter("Scenes", &["gltf", "glb", "obj", "ply", "stl", "pc2", "mdd"])
            .add_filter("All files", &["*"])
            .pick_file();
        std::thread::spawn(move || {
            let chosen = pollster::block_on(dialog).map(|file| file.path().to_owned());
            // The window may be gone.
            sender.send(chosen).ok();
            wake();
        });
        self.open = Some(receiver);
    }

    /// The file that was chosen, once.
    pub(crate) fn chosen(&mut self) -> Option<PathBuf> {
        let answer = self.open.as_ref()?.try_recv();
        match answer {
            Err(std::sync::mpsc::TryRecvError::Empty) => None,
            answer => {
                self.open = None;
                answer.ok().flatten()
            }
        }
    }
}
