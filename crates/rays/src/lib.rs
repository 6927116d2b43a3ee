//! What does a ray hit?
#![forbid(unsafe_code)]

mod bounds;
mod camera;
mod light;
mod ray;
mod triangles;

pub use bounds::Bounds;
pub use camera::{Camera, Projection, View};
pub use light::LightSource;
pub use ray::{Hit, Ray};
pub use triangles::{Omitted, OmittedKind, Triangles};
