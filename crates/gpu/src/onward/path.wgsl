// What becomes of the light that comes along a ray.
struct OnwardPath {
    // How much of it reaches the camera.
    through: vec3<f32>,
    // How far it goes from the ray's origin to the camera.
    travelled: f32,
    // The pixel that shows it.
    pixel: u32,
}
