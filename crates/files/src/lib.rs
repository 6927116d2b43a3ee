//! Scenes of files: readers of glTF, OBJ, PLY, STL, point caches and numbered sequences, and decoders of textures.
//!
//! [`open`] makes a [`Scene`](umbrage_scene::Scene) of a file by its format's reader.
#![forbid(unsafe_code)]

mod folder;
mod foreign;
mod formats;
pub mod image_file;
mod memory;
mod open;
mod origin;
mod polygon;
mod scalar;
mod smooth;
mod still;
mod text;
mod texture;

mod gltf;
mod obj;
mod ply;
mod point_cache;
mod sequence;
mod stl;

pub use open::{Clip, OpenOptions, open, open_bytes, open_files, open_with};
pub use texture::{AVIF_LEFT_OUT, decode_texture};
