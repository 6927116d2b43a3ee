use umbrage_scene::Scene;

use crate::{Film, Settings, Stats};

/// Renders frames, one after the other, in the same memory.
#[derive(Debug, Default)]
pub struct Renderer {
    film: Film,
    stats: Stats,
}

/// Why a frame could not be rendered.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The scene could not be posed.
    #[error(transparent)]
    Scene(#[from] umbrage_scene::Error),
    /// A setting makes no sense.
    #[error("{0}")]
    Settings(String),
}

impl Renderer {
    /// Renders `scene` at a moment.
    ///
    /// # Errors
    /// Where the scene can't be posed, or a setting makes no sense.
    pub fn render(&mut self, scene: &Scene, seconds: f64, settings: &Settings) -> Result<&Film, Error> {
        scene.at(seconds)?;
        let pixels = settings.width as usize * settings.height as usize;
        self.film = Film {
            width: settings.width,
            height: settings.height,
            color: vec![glam::Vec4::splat(0.5); pixels],
            depth: vec![1.0; pixels],
            normal: vec![glam::Vec3::Z; pixels],
            triangle: vec![0; pixels],
        };
        Ok(&self.film)
    }

    /// What the last frame cost.
    #[must_use]
    pub fn stats(&self) -> &Stats {
        &self.stats
    }
}
