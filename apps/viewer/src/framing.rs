//! Cameras that frame the scene's subject, or all of it.

use std::sync::Arc;

use umbrage::rays::{Bounds, Camera};

use crate::app::{App, CameraChoice, Shown};
use crate::free_camera;

impl App {
    /// Frames the subject, once the worker has found it.
    pub(crate) fn frame_subject(&mut self) {
        if let Some(open) = &self.open {
            self.is_framing = true;
            self.worker.find_subject(Arc::clone(&open.scene), self.timeline.seconds);
            self.stop_refining();
        }
    }

    /// Frames the subject, or the whole scene where there is none.
    pub(crate) fn frame_found(&mut self, subject: Option<Bounds>) {
        self.is_framing = false;
        match subject {
            Some(subject) => self.frame(subject),
            None => self.frame_all(),
        }
    }

    /// Frames the whole scene, over the whole animation.
    pub(crate) fn frame_all(&mut self) {
        if let Some(Shown { picture, .. }) = &self.shown {
            self.frame(picture.bounds);
        }
    }

    /// Frames a box, in the current direction of view.
    fn frame(&mut self, bounds: Bounds) {
        let Some(Shown { picture, .. }) = &self.shown else { return };
        let (forward, aspect) = (picture.view.camera.forward, picture.view.width as f32 / picture.view.height as f32);
        let framed = Camera::framing(bounds.corners(), forward, aspect, 0.7);
        let depth = (bounds.center() - framed.position).dot(framed.forward);
        let depth = if depth > 0.0 { depth } else { 1.0 };
        self.camera = CameraChoice::Free(free_camera::of(&framed, depth));
    }
}
