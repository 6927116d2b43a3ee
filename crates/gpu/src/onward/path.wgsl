// What becomes of the light that comes along a ray: crates/umbrage/src/cpu/onward.rs.

import package::onward::media::{Media};

struct OnwardPath {
    // How much of it reaches the camera.
    through: vec3<f32>,
    // How far it goes from the ray's origin to the camera.
    travelled: f32,
    // What it goes through along the ray.
    media: Media,
    // The pixel that shows it.
    pixel: u32,
    // By how many mirrors, and how often into glass or out of it, it comes.
    bounces: u32,
    // Through how many surfaces it comes to the last of these.
    layers: u32,
    // The largest GGX width of rough surfaces by which it comes.
    blur: f32,
}
