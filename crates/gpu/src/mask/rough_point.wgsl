// Rough position of the point where a ray meets a triangle in pixel space.

import package::grid::set_up::{U};
import package::grid::space::{VERTEX_REGULAR};
import package::mask::filter::{RoughPoint};
import stage::{vertices};

// The meeting point of a ray and a triangle in pixel space, from edge functions that each have an error of `edge_error`.
fn rough_point(corners: vec3<u32>, edges: vec3<f32>, edge_error: f32, are_parallel: bool) -> RoughPoint {
    let of_corners = vec3<u32>(vertices[corners.x].z, vertices[corners.y].z, vertices[corners.z].z);
    let kinds = vertices[corners.x].w | vertices[corners.y].w | vertices[corners.z].w;
    // Parallel rays need no division, and homogeneous edge functions are weights already.
    let is_divided = !are_parallel && kinds == VERTEX_REGULAR;
    let keys = select(vec3<f32>(1.0), bitcast<vec3<f32>>(of_corners), is_divided);
    let weights = edges * keys;
    let sum = weights.x + weights.y + weights.z;
    let largest = max(max(keys.x, keys.y), keys.z);
    let error = 4.0 * edge_error * largest / sum + 32.0 * U;
    return RoughPoint(weights.yz / sum, error);
}
