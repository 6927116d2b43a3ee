// Hits of pixels' rays on triangles that they are known to show.

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

// Offset of a pixel's ray from the camera's axis, to the right and up: at depth 1 for a perspective, else at any depth.
fn ray_across(pixel: vec2<u32>) -> vec2<f32> {
    // Integers first, so that they stay exact.
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

// Edge functions are evaluated in a view along the ray, from the corners' offsets to the ray, so the terms that cancel
// are no larger than the triangle. The point is clamped to the triangle, which it can miss by a rounding.
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
    // The triangle is seen exactly edge-on.
    var barycentric = vec2<f32>(1.0 / 3.0);
    if sum > 0.0 {
        barycentric = inside.yz / sum;
    }
    return Hit(barycentric, a.z + barycentric.x * (b.z - a.z) + barycentric.y * (c.z - a.z));
}

// Components of a world vector along the camera's axes.
fn in_camera(vector: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(dot(vector, shade_sample.right), dot(vector, shade_sample.up), dot(vector, shade_sample.forward));
}

// Distance at a depth between rays that start one unit apart, or for a perspective are one unit apart at depth 1.
fn ray_spread(depth: f32) -> f32 {
    return select(depth, 1.0, shade_sample.projection == PROJECTION_ORTHOGRAPHIC);
}

fn perp_dot(a: vec2<f32>, b: vec2<f32>) -> f32 {
    return a.x * b.y - a.y * b.x;
}
