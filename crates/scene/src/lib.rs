//! What is there at time t?
#![forbid(unsafe_code)]

mod check;
mod error;
mod frame;
mod light;
mod material;
mod opacity;
mod polygon;
mod scene;
mod still;
mod text;
mod texture;

mod demo;
mod gltf;
mod obj;
mod ply;
mod sequence;
mod stl;

pub use check::BadFrame;
pub use demo::{DEMOS, DemoScene};
pub use error::Error;
pub use frame::{Frame, Mesh, NamedCamera};
pub use gltf::rig;
pub use light::Light;
pub use material::{Alpha, Material, Materials, TextureUse, Volume};
pub use opacity::FrameOpacity;
pub use scene::{Animation, Clip, OpenOptions, Scene};
pub use texture::{ColorSpace, Filter, Texture, Wrap};
