//! Exact visibility and exact shadows for triangle scenes that change completely every frame.
#![forbid(unsafe_code)]

mod background;
mod film;
mod frame;
pub mod output;
mod settings;
mod stats;

pub use background::{Background, Panorama};
pub use film::{Film, Image};
pub use frame::{Error, Renderer};
pub use settings::{Settings, ToneMap};
pub use stats::{OmittedTriangles, Stage, Stats};
pub use umbrage_rays as rays;
pub use umbrage_scene as scene;
pub use umbrage_scene::Scene;
