//! The window's surface, and the handling of its errors.

use std::sync::{Arc, Mutex, PoisonError};

use eframe::egui_wgpu::SurfaceErrorAction;
use umbrage::gpu::wgpu::CurrentSurfaceTexture;

/// Messages about the window's surface, from the drawing code to the interface.
#[derive(Clone, Debug, Default)]
pub struct Surface {
    message: Arc<Mutex<Option<&'static str>>>,
}

impl Surface {
    /// The action for a surface status. Unusual ones leave a message for the user.
    #[must_use]
    pub fn answer(&self, status: &CurrentSurfaceTexture) -> SurfaceErrorAction {
        let (action, message) = match status {
            // The window was resized, moved to another screen, or is out of sight.
            CurrentSurfaceTexture::Outdated => (SurfaceErrorAction::Reconfigure, None),
            CurrentSurfaceTexture::Success(_)
            | CurrentSurfaceTexture::Suboptimal(_)
            | CurrentSurfaceTexture::Occluded
            | CurrentSurfaceTexture::Timeout => (SurfaceErrorAction::SkipFrame, None),
            CurrentSurfaceTexture::Lost => {
                (SurfaceErrorAction::RecreateSurface, Some("the window's surface was lost, and made anew"))
            }
            CurrentSurfaceTexture::Validation => (
                SurfaceErrorAction::RecreateSurface,
                Some("the window couldn't be drawn, and its surface was made anew"),
            ),
        };
        if message.is_some() {
            *self.message.lock().unwrap_or_else(PoisonError::into_inner) = message;
        }
        action
    }

    /// Takes the message since the last call, if any.
    pub(crate) fn news(&self) -> Option<&'static str> {
        self.message.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lost_surfaces_are_made_anew_and_told_about_once() {
        let surface = Surface::default();
        assert!(matches!(surface.answer(&CurrentSurfaceTexture::Occluded), SurfaceErrorAction::SkipFrame));
        assert!(matches!(surface.answer(&CurrentSurfaceTexture::Outdated), SurfaceErrorAction::Reconfigure));
        assert_eq!(surface.news(), None);
        assert!(matches!(surface.clone().answer(&CurrentSurfaceTexture::Lost), SurfaceErrorAction::RecreateSurface));
        assert!(surface.news().is_some_and(|news| news.contains("lost")));
        assert_eq!(surface.news(), None);
    }
}
