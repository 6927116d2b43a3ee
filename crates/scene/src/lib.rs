//! Scenes at time t: frames of triangles with materials, lights and cameras, and sources of these.
#![forbid(unsafe_code)]

mod check;
mod error;
mod frame;
mod ground;
mod hidden;
mod instances;
mod layers;
mod light;
mod marks;
mod material;
mod objects;
mod opacity;
pub mod rig;
mod scene;
mod texture;

pub use check::{BadFrame, check_camera, check_light, check_lights, check_material};
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
pub use scene::{Animated, Animation, Scene};
pub use texture::{ColorSpace, Filter, Texture, TextureTraffic, TilePool, Wrap, linear_from_srgb};
