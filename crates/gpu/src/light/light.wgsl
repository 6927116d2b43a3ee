// A light's parameters, shared by all stages of its grid.

struct Light {
    // Position, or a directional light's direction of travel.
    vector: vec3<f32>,
    is_directional: u32,
    // Side of a face in cells: of the only face, and of each of six.
    side_of_one: u32,
    side_of_six: u32,
    vertices: u32,
    triangles: u32,
    // First word of the light's bits in the masks.
    mask: u32,
    slots: u32,
    // Bound on the coordinates of rays' origins.
    reach: f32,
    // Whether the user sets the angles that get cells of their own.
    has_clamp: u32,
    // A spot's cone: the axis away from the light, and the squared cosine of its half-angle as F64.
    axis: vec3<f32>,
    // Depth slices of a tile.
    slices: u32,
    squared_cosine: vec2<u32>,
    // Direction of the image's rows.
    along_rows: vec3<f32>,
    // The user's lowest and highest angles, as integers.
    clamp_low: vec2<i32>,
    clamp_high: vec2<i32>,
}
