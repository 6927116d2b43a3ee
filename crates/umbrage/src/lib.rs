//! Exact visibility and exact shadows for triangle scenes that change completely every frame.
//!
//! [`Scene`] reads a file and poses it, [`Renderer`] renders it with [`Settings`], [`Film`] holds what each pixel saw,
//! and [`output`] writes it:
//!
//! ```
//! use umbrage::{Renderer, Scene, Settings};
//!
//! let scene = Scene::open("demo:glass?triangles=500")?;
//! let settings = Settings { width: 64, height: 36, ..Settings::default() };
//! let mut renderer = Renderer::default();
//! let film = renderer.render(&scene, 0.5, &settings)?;
//! assert!(film.depth.iter().any(|depth| depth.is_finite()));
//! # Ok::<(), umbrage::Error>(())
//! ```
#![forbid(unsafe_code)]

mod answers;
mod background;
mod choices;
mod cpu;
mod engine;
mod error;
mod film;
mod frame;
#[cfg(feature = "gpu")]
#[doc(hidden)]
pub mod gpu;
mod heat_scale;
pub mod output;
mod panorama;
mod probe;
mod renderer;
mod sampling;
mod screen;
mod settings;
mod shade;
pub mod spec;
mod stats;
mod structure;
mod tone_map;

pub use answers::{Seen, WorkCounts};
pub use background::Background;
pub use choices::{EngineKind, HeatKind};
pub use cpu::{LightMask, LightWork};
pub use error::Error;
pub use film::{Film, Image};
pub use heat_scale::HeatScale;
pub use panorama::Panorama;
pub use probe::{Blocker, Probe};
pub use renderer::Renderer;
pub use sampling::Sample;
pub use settings::{CameraChoice, Settings, Structure, ToneMap};
pub use stats::{OmittedTriangles, Settled, Stage, Stats};
pub use structure::{ImpossibleOption, OptionValues, StructureOption, UnknownStructure};
pub use umbrage_rays as rays;
pub use umbrage_scene as scene;
pub use umbrage_scene::Scene;

/// The examples of the README, so that they are tested.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;
