//! Exact visibility and exact shadows for triangle scenes that change completely every frame.
//!
//! [`open`] reads a file as a [`Scene`], [`Renderer`] renders it with [`Settings`], [`Film`] holds the pixels' values, and
//! [`output`] writes it:
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
//! `examples/` shows triangles of your own that change in each frame (`own_triangles`), the points of a set that a light
//! reaches (`point_visibility`), rays from anywhere (`rays`), rigid objects that move (`instances`), a lidar and the sun on
//! faces (`lidar`), the times of queries (`timed_questions`), a GPU (`gpu_frame`) and an animation in a file (`animation`).
//!
//! All public items, and their purposes:
//!
//! - [`Renderer`] renders scenes and frames, and answers visibility queries; [`Error`] gives the cause of a failure.
//!   [`Progress`] tells how far a frame has come.
//! - [`Settings`] define a picture: [`CameraChoice`] its camera, [`Structure`] the acceleration structure, [`Sides`] the
//!   sides of triangles that stop rays, [`Background`] (with [`Panorama`] for images) the surroundings, [`ToneMap`] the
//!   brightness.
//! - [`Structures`] finds structures by name. [`StructureKind`] is the trait for a structure of your own (`own_structure`),
//!   [`KindOption`] one of its options, and [`GpuStructure`] its counterpart on a GPU, with [`GpuGrids`] for grids of other
//!   cells. [`StructureOption`] describes an option by name, and [`OptionValues`] its values, one kind of which is a
//!   [`LightClamp`]; [`ImpossibleOption`], [`NoLightClamp`] or [`UnknownStructure`] give the reason for a refusal.
//!   [`EngineKind`], [`HeatKind`] and [`spec`] are the other words of command lines.
//! - [`Film`] holds each pixel's light, depth, normal and triangle, [`Image`] its colours for a screen; [`output`] writes
//!   files of either. [`FilmLayers`] are a film's further [`Layers`], each a [`Layer`]: a [`LightLayer`] for each light, and
//!   the [`Coverage`] of objects, with a [`Covered`] part for each object.
//! - [`Seen`] and [`LightMask`] are answers of [`Renderer::see`] and [`Renderer::shadow`] without a picture; [`Probe`], with
//!   a [`Blocker`] for each light, has all details of one pixel.
//! - [`Stats`], made of [`Stage`], [`Settled`] and [`OmittedTriangles`], has the times and counts of a frame; [`Work`] is
//!   the work for the camera or a light, and [`WorkCounts`] that for each pixel, which [`HeatScale`] colours.
//! - [`PixelView`] paints the pixels' hits in place of light.
//! - [`Sample`] is a ray of each pixel, and [`Samples`] are those traced together, for callers who trace the same ones
//!   themselves.
//! - [`open`], or [`open_with`] options, makes a [`Scene`] of a file or of one of the [`gallery`], [`open_bytes`] of a file
//!   in memory, [`open_files`] of several; [`scene`] has the parts of scenes, and frames of your own.
//! - [`rays`] has the structures, cameras and lights themselves, and the predicate that decides every hit. [`rays::Scanner`]
//!   traces any directions from one origin, and lights to any points; [`rays::Tracer`] any rays, by the fastest way;
//!   [`rays::Nearest`] finds the nearest point of all triangles, and points inside of closed meshes; [`scene::Instances`]
//!   tells the rigid object of a hit.
#![cfg_attr(feature = "gpu", doc = "- [`gpu`] opens devices, with the feature of that name.")]
#![cfg_attr(not(feature = "gpu"), doc = "- `gpu` opens devices, with the feature of that name.")]
//! - [`glam`] is the library of all vectors here.
#![forbid(unsafe_code)]

use std::path::Path;

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
pub mod output;
mod panorama;
mod pixel_view;
mod plan;
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
pub use panorama::Panorama;
pub use pixel_view::PixelView;
pub use probe::{Blocker, Probe};
pub use renderer::{Progress, Renderer};
pub use sampling::{Sample, Samples};
pub use settings::{CameraChoice, Settings, ToneMap};
pub use sides::Sides;
pub use stats::{OmittedTriangles, Settled, Stage, Stats};
pub use structure::{
    GpuGrids, GpuStructure, ImpossibleOption, KindOption, LightClamp, NoLightClamp, OptionValues, Structure,
    StructureKind, StructureOption, Structures, UnknownStructure,
};
pub use umbrage_files::{open_bytes, open_files};
pub use umbrage_gallery as gallery;
pub use umbrage_rays as rays;
pub use umbrage_rays::{LightMask, Work};
pub use umbrage_scene::Scene;

/// Opens a scene: a file's path, a sequence's pattern or folder, or `demo:NAME?triangles=N` for one of the
/// [gallery](gallery::DEMOS).
///
/// # Errors
/// Where the file can't be read, breaks its format or needs something unsupported, or there is no such demo.
pub fn open(address: impl AsRef<Path>) -> Result<Scene, scene::Error> {
    open_with(address, &scene::OpenOptions::default())
}

/// As [`open`], with options.
///
/// # Errors
/// As [`open`], and where `options` name a clip, a variant or an object that the file doesn't have, or want textures of the
/// gallery on demand: these are made in memory, of a few megabytes.
pub fn open_with(address: impl AsRef<Path>, options: &scene::OpenOptions) -> Result<Scene, scene::Error> {
    let address = address.as_ref();
    let text = address.to_string_lossy();
    let is_demo = text.starts_with(gallery::PREFIX);
    if is_demo && options.texture_memory.is_some() {
        let cause =
            "the built-in scenes make their few textures in memory; leave out --texture-memory, which is for files";
        return Err(scene::Error::Address { address: text.into_owned(), cause: cause.to_owned() });
    }
    if let (true, Some(variant)) = (is_demo, &options.variant) {
        let cause = format!("there is no variant `{variant}`: only glTF files have any");
        return Err(scene::Error::Address { address: text.into_owned(), cause });
    }
    let mut scene = if is_demo { gallery::open(&text)? } else { umbrage_files::open_with(address, options)? };
    if is_demo {
        scene.choose_ground(options.ground);
        let wrong = |cause| scene::Error::Address { address: text.clone().into_owned(), cause };
        scene = scene.hiding(&options.hidden).map_err(wrong)?;
    }
    match &options.clip {
        // An animation without a name is number 0.
        scene::Clip::Named(name)
            if scene.animations().is_empty() && (name != "0" || scene.duration_seconds() == 0.0) =>
        {
            let cause = format!("there is no animation `{name}` to choose: it has none with a name or number");
            Err(scene::Error::Address { address: text.into_owned(), cause })
        }
        _ => Ok(scene),
    }
}

/// The parts of scenes, and the options for opening one.
pub mod scene {
    #[doc(inline)]
    pub use umbrage_files::{AVIF_LEFT_OUT, Clip, OpenOptions, decode_texture};
    #[doc(inline)]
    pub use umbrage_scene::*;
}

/// Items that `umbrage-bench` needs of the crate's inside. Not part of the public API.
#[doc(hidden)]
pub mod internals {
    pub use crate::points::{disk, pair, triple};
}

/// The examples of the README, so that they are tested.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;
