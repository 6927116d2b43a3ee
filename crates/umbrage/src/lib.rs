//! Exact visibility and exact shadows for triangle scenes that change completely every frame.
//!
//! [`open`] reads a file as a [`Scene`], [`Renderer`] renders it with [`Settings`], [`Film`] holds what each pixel saw,
//! and [`output`] writes it:
//!
//! ```
//! use umbrage::{Renderer, Settings};
//!
//! let scene = umbrage::open("demo:glass?triangles=500")?;
//! let settings = Settings { width: 64, height: 36, ..Settings::default() };
//! let mut renderer = Renderer::default();
//! let film = renderer.render(&scene, 0.5, &settings)?;
//! assert!(film.depth.iter().any(|depth| depth.is_finite()));
//! # Ok::<(), umbrage::Error>(())
//! ```
//!
//! `examples/` shows triangles of one's own that change in each frame (`own_triangles`), which points of a set a light reaches
//! (`point_visibility`), rays from anywhere (`rays`), rigid objects that move (`instances`), a lidar and the sun on faces (`lidar`), what questions take (`timed_questions`), a GPU (`gpu_frame`) and an animation in a file (`animation`).
//!
//! All that is public, and what it is for:
//!
//! - [`Renderer`] renders scenes and frames, and answers what is seen and lit; [`Error`] says why it doesn't.
//!   [`Progress`] says how far a frame has come.
//! - [`Settings`] say how: [`CameraChoice`] from where, [`Structure`] through what, [`Sides`] which of triangles,
//!   [`Background`] (with [`Panorama`] for images) before what, [`ToneMap`] how bright.
//! - [`StructureOption`] lists what can be chosen of a structure by name, within [`OptionValues`], or else
//!   [`ImpossibleOption`] or [`UnknownStructure`] says why not; [`EngineKind`], [`HeatKind`] and [`spec`] are the other words
//!   of command lines.
//! - [`Film`] is what each pixel saw, [`Image`] that for a screen; [`output`] writes files of either. [`FilmLayers`] are a film's
//!   further [`Layers`], each a [`Layer`]: a [`LightLayer`] for each light, and the [`Coverage`] of objects, each with what it has
//!   [`Covered`].
//! - [`Seen`] and [`LightMask`] are answers of [`Renderer::see`] and [`Renderer::shadow`] without a picture; [`Probe`], with a
//!   [`Blocker`] for each light, is all about one pixel.
//! - [`Stats`], made of [`Stage`], [`Settled`] and [`OmittedTriangles`], is what a frame cost; [`Work`] what the camera
//!   or a light was to do, and [`WorkCounts`] what each pixel was, which [`HeatScale`] colours.
//! - [`PixelView`] paints what pixels saw in place of light.
//! - [`Sample`] is which ray of a pixel is traced, and [`Samples`] which of them together, for those who trace the same
//!   ones themselves.
//! - [`open`], or [`open_with`] options, makes a [`Scene`] of a file or of one of the [`gallery`]; [`scene`] has what they
//!   are made of, and frames of one's own.
//! - [`rays`] has the structures, cameras and lights themselves, and the predicate that decides every hit;
//!   [`rays::Scanner`] answers any directions from one origin, and lights on any points; [`rays::Tracer`] any rays, by what takes
//!   the least; [`scene::Instances`] says which rigid object a hit is of.
#![cfg_attr(feature = "gpu", doc = "- [`gpu`] opens devices, with the feature of that name.")]
#![cfg_attr(not(feature = "gpu"), doc = "- `gpu` opens devices, with the feature of that name.")]
//! - [`glam`] is the library whose vectors all of these take.
#![forbid(unsafe_code)]

mod answers;
mod background;
mod choices;
mod cpu;
mod develop;
mod engine;
mod error;
mod exposure;
mod film;
mod frame;
#[cfg(feature = "gpu")]
pub mod gpu;
mod heat_scale;
mod layers;
mod motion;
mod noise;
mod open;
pub mod output;
mod panorama;
mod pixel_view;
mod points;
mod probe;
mod renderer;
mod sampling;
mod screen;
mod settings;
mod shade;
mod sides;
mod sky;
pub mod spec;
mod stats;
mod structure;
mod tone_map;

pub use answers::{Seen, WorkCounts};
pub use background::Background;
pub use choices::{EngineKind, HeatKind};
pub use error::Error;
pub use film::{Coverage, Covered, Film, FilmLayers, Image, LightLayer};
pub use glam;
pub use heat_scale::HeatScale;
pub use layers::{Layer, Layers};
pub use open::{open, open_with};
pub use panorama::Panorama;
pub use pixel_view::PixelView;
pub use probe::{Blocker, Probe};
pub use renderer::{Progress, Renderer};
pub use sampling::{Sample, Samples};
pub use settings::{CameraChoice, Settings, ToneMap};
pub use sides::Sides;
pub use stats::{OmittedTriangles, Settled, Stage, Stats};
pub use structure::{ImpossibleOption, OptionValues, Structure, StructureOption, UnknownStructure};
pub use umbrage_gallery as gallery;
pub use umbrage_rays as rays;
pub use umbrage_rays::{LightMask, Work};
pub use umbrage_scene as scene;
pub use umbrage_scene::Scene;

/// What `umbrage-bench` needs of the crate's inside. Not part of the public API.
#[doc(hidden)]
pub mod internals {
    pub use crate::points::{disk, pair, triple};
}

/// The examples of the README, so that they are tested.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;
