// A light that points are asked about.
struct KdLight {
    // Its position, or the direction in which it travels, in bits of f32.
    vector: vec3<u32>,
    is_directional: u32,
    // A spot's cone: away from the light, in bits of f32, and the squared cosine of its half-angle as F64.
    axis: vec3<u32>,
    has_cone: u32,
    squared_cosine: vec2<u32>,
    // Whether anything keeps it away.
    casts_shadow: u32,
    // How many questions go in a packet.
    packet: u32,
    // Where its bits start, in words.
    mask: u32,
    // Where the words start that say how much of lights comes through what is before points.
    tints: u32,
}
