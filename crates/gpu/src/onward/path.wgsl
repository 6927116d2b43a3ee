// The path from a ray to the camera: crates/umbrage/src/cpu/onward.rs.

import package::onward::media::{Media};

struct OnwardPath {
    // Throughput to the camera.
    through: vec3<f32>,
    // Length of the path from the ray's origin to the camera.
    travelled: f32,
    // The media along the ray.
    media: Media,
    // The pixel that shows it.
    pixel: u32,
    // Number of bounces: reflections and refractions.
    bounces: u32,
    // Number of surfaces passed straight on since the last bounce.
    layers: u32,
    // Largest GGX width of rough surfaces along the path.
    blur: f32,
}
