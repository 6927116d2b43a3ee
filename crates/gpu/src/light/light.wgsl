// A light, as all stages of its grid see it.

struct Light {
    // Position, or the direction in which the light travels.
    vector: vec3<f32>,
    is_directional: u32,
    // Cells a side of the only face, and of each of six.
    side_of_one: u32,
    side_of_six: u32,
    vertices: u32,
    triangles: u32,
    // Where the light's bits start in the masks, in words.
    mask: u32,
    slots: u32,
    // A bound on the coordinates that rays start from.
    reach: f32,
    // Whether the user says which angles get cells of their own.
    has_clamp: u32,
    // A spot's cone: away from the light, and the squared cosine of its half-angle as F64.
    axis: vec3<f32>,
    // Depth slices of a tile.
    slices: u32,
    squared_cosine: vec2<u32>,
    // Along the image's rows.
    along_rows: vec3<f32>,
    // The user's lowest and highest angles, as integers.
    clamp_low: vec2<i32>,
    clamp_high: vec2<i32>,
}
