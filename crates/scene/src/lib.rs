//! Scenes at time t: readers of files, animation and frames of triangles.
#![forbid(unsafe_code)]

mod check;
mod derived;
mod error;
mod folder;
mod foreign;
mod formats;
mod frame;
mod ground;
mod hidden;
#[doc(hidden)]
pub mod image_file;
mod instances;
mod layers;
mod light;
mod marks;
mod material;
mod memory;
mod objects;
mod opacity;
mod origin;
mod polygon;
mod scene;
mod smooth;
mod still;
mod survey;
mod text;
mod texture;

mod gltf;
mod obj;
mod ply;
mod point_cache;
pub mod rig;
mod sequence;
mod stl;

pub use check::{BadFrame, check_camera, check_lights};
pub use error::Error;
pub use frame::{Frame, Mesh, NamedCamera};
pub use ground::{Ground, GroundChoice, GroundSurface};
pub use instances::{BadInstance, Instance, InstanceHit, Instances};
pub use layers::{Anisotropy, Clearcoat, Iridescence, Layers, Sheen, Specular};
pub use light::{Light, LightShape};
pub use marks::{MarkRun, Marks};
pub use material::{Alpha, Material, Materials, TextureUse, Volume};
pub use objects::Objects;
pub use opacity::{FrameOpacity, OpaquePart};
pub use scene::{Animated, Animation, Clip, OpenOptions, Scene};
pub use texture::{AVIF_LEFT_OUT, ColorSpace, Filter, Texture, TextureTraffic, Wrap};
