// A light for shadow questions.
struct ShadowLight {
    // Its position or, if directional, its direction of travel, in bits of f32.
    vector: vec3<u32>,
    is_directional: u32,
    // A spot's cone: the axis away from the light, in bits of f32, and the squared cosine of its half-angle as F64.
    axis: vec3<u32>,
    has_cone: u32,
    squared_cosine: vec2<u32>,
    // Whether triangles shadow it.
    casts_shadow: u32,
    // Questions of a packet.
    packet: u32,
    // First word of its mask.
    mask: u32,
    // First word of the transmittances of surfaces between points and lights.
    tints: u32,
}
