// Where the ray of a pixel meets the triangle that it is known to show.

import package::shade::tables::{PROJECTION_ORTHOGRAPHIC, shade_positions, shade_sample, shade_triangles};

struct Triangle {
    vertices: vec3<u32>,
    // World positions.
    corners: array<vec3<f32>, 3>,
    // From the first corner to the others.
    to_second: vec3<f32>,
    to_third: vec3<f32>,
}

struct Hit {
    // Weights of the second and the third vertex.
    barycentric: vec2<f32>,
    // Along the camera's forward axis.
    depth: f32,
}

fn triangle_of(id: u32) -> Triangle {
    let vertices = shade_triangles[id].xyz;
    let corners = array<vec3<f32>, 3>(position_of(vertices.x), position_of(vertices.y), position_of(vertices.z));
    return Triangle(vertices, corners, corners[1] - corners[0], corners[2] - corners[0]);
}

fn position_of(vertex: u32) -> vec3<f32> {
    return vec3<f32>(shade_positions[3u * vertex], shade_positions[3u * vertex + 1u], shade_positions[3u * vertex + 2u]);
}

// How far right and up of the camera's axis a pixel's ray is: at depth 1 for a perspective, else everywhere.
fn ray_across(pixel: vec2<u32>) -> vec2<f32> {
    // Whole numbers first, so that they stay exact.
    let in_image = vec2<i32>(pixel) + vec2<i32>(0, i32(shade_sample.first_row));
    let image = vec2<i32>(i32(shade_sample.size_pixels.x), i32(shade_sample.image_height));
    let doubled = vec2<f32>(2 * in_image - image) + 2.0 * shade_sample.offset_pixels;
    let scale = shade_sample.half_height / f32(shade_sample.image_height);
    return vec2<f32>(doubled.x, -doubled.y) * scale;
}

// The ray's unit direction.
fn ray_direction(across: vec2<f32>) -> vec3<f32> {
    if shade_sample.projection == PROJECTION_ORTHOGRAPHIC {
        return normalize(shade_sample.forward);
    }
    return normalize(shade_sample.forward + (shade_sample.right * across.x + shade_sample.up * across.y));
}

// The edge functions are those of a reader who looks along the ray: corners are given by how far they are from the ray,
// so what cancels is no larger than the triangle. The point is kept inside of the triangle, which it can miss by a
// rounding.
fn hit_of(triangle: Triangle, across: vec2<f32>) -> Hit {
    let a = in_camera(triangle.corners[0] - shade_sample.position);
    let b = in_camera(triangle.corners[1] - shade_sample.position);
    let c = in_camera(triangle.corners[2] - shade_sample.position);
    let from_ray_a = a.xy - across * ray_spread(a.z);
    let from_ray_b = b.xy - across * ray_spread(b.z);
    let from_ray_c = c.xy - across * ray_spread(c.z);
    let weights = vec3<f32>(
        perp_dot(from_ray_b, from_ray_c),
        perp_dot(from_ray_c, from_ray_a),
        perp_dot(from_ray_a, from_ray_b),
    );
    let side = select(1.0, -1.0, weights.x + weights.y + weights.z < 0.0);
    let inside = max(weights * side, vec3<f32>(0.0));
    let sum = inside.x + inside.y + inside.z;
    // Seen so exactly from its edge that all of it is one line.
    var barycentric = vec2<f32>(1.0 / 3.0);
    if sum > 0.0 {
        barycentric = inside.yz / sum;
    }
    return Hit(barycentric, a.z + barycentric.x * (b.z - a.z) + barycentric.y * (c.z - a.z));
}

// A world vector along the camera's axes.
fn in_camera(vector: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(dot(vector, shade_sample.right), dot(vector, shade_sample.up), dot(vector, shade_sample.forward));
}

// How far apart at a depth rays are that start, or at depth 1 are, one unit apart.
fn ray_spread(depth: f32) -> f32 {
    return select(depth, 1.0, shade_sample.projection == PROJECTION_ORTHOGRAPHIC);
}

fn perp_dot(a: vec2<f32>, b: vec2<f32>) -> f32 {
    return a.x * b.y - a.y * b.x;
}
