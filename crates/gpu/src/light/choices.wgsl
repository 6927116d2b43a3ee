// Inputs and outputs of `choose`, for lights that see by faces or by angles.

import package::dispatch::{groups_of};
import package::exact::double::{f64_from_f32_bits};
import package::grid::header::{HEADER_FACES, HEADER_TRIANGLE_GROUPS, HEADER_VERTEX_GROUPS};
import package::grid::space::{from_ordered_bits};
import stage::{bounds, header, light, spaces};

// A light's axes.
struct Axes {
    right: vec3<f32>,
    up: vec3<f32>,
    forward: vec3<f32>,
}

// A corner of the bounds of all points.
fn from_bounds(word: u32, is_complement: bool) -> vec3<f32> {
    var corner: vec3<f32>;
    for (var axis = 0u; axis < 3u; axis++) {
        let bits = bounds[word + axis];
        corner[axis] = from_ordered_bits(select(bits, ~bits, is_complement));
    }
    return corner;
}

// Axes with the third along `vector`.
fn axes_along(vector: vec3<f32>) -> Axes {
    // Scaled first, because squares of very large or small numbers leave f32's range.
    let largest = max(max(abs(vector.x), abs(vector.y)), abs(vector.z));
    let forward = select(vec3<f32>(0.0, 0.0, 1.0), normalize(vector / largest), largest > 1e-30 && largest < 1e30);
    let helper = select(vec3<f32>(1.0, 0.0, 0.0), vec3<f32>(0.0, 1.0, 0.0), abs(forward.x) > 0.7);
    let right = normalize(cross(helper, forward));
    return Axes(right, cross(forward, right), forward);
}

// Writes the origin, the rows for x, y and depth, and the terms added to x and y.
fn write_projection(number: u32, numbers: array<f32, 14>) {
    var of_space = numbers;
    for (var pair = 0u; pair < 7u; pair++) {
        let first = f64_from_f32_bits(bitcast<u32>(of_space[2u * pair]));
        let second = f64_from_f32_bits(bitcast<u32>(of_space[2u * pair + 1u]));
        spaces[number].projection[pair] = vec4<u32>(first, second);
    }
}

fn write_faces(faces: u32) {
    header[HEADER_FACES] = faces;
    write_groups(HEADER_VERTEX_GROUPS, (light.vertices + 255u) / 256u, faces);
    write_groups(HEADER_TRIANGLE_GROUPS, (light.triangles + 255u) / 256u, faces);
}

fn write_groups(word: u32, count: u32, faces: u32) {
    let groups = groups_of(count);
    header[word] = groups.x;
    header[word + 1u] = groups.y;
    header[word + 2u] = select(0u, faces, count > 0u);
}
