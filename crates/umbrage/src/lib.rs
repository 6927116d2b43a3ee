//! Exact visibility and exact shadows for triangle scenes that change completely every frame.
#![forbid(unsafe_code)]

mod background;
mod cpu;
mod film;
mod frame;
pub mod output;
mod panorama;
mod sampling;
mod settings;
mod shade;
mod stats;
mod tone_map;

pub use background::Background;
pub use cpu::LightMask;
pub use film::{Film, Image};
pub use frame::{Error, Renderer};
pub use panorama::Panorama;
pub use settings::{Settings, ToneMap};
pub use stats::{OmittedTriangles, Stage, Stats};
pub use umbrage_rays as rays;
pub use umbrage_scene as scene;
pub use umbrage_scene::Scene;
