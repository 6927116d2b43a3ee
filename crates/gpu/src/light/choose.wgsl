// Stage `choose`: chooses the faces of a light's grid from the bounds of all points. One face around a spot's cone, or
// if the light sees the bounds well from outside; else the six of a cube around the light.

import package::exact::double::{f64_to_f32_bits};
import package::grid::space::{Raster, Space, power_of_two};
import package::light::cells::{BINS, BIN_FRACTION_BITS};
import package::light::choices::{axes_along, from_bounds, write_faces, write_projection};
import package::light::light::{Light};
import package::light::points::{BOUNDS_LOW, POINT_ERROR};

@group(0) @binding(0) var<uniform> light: Light;
@group(0) @binding(1) var<storage, read> bounds: array<u32>;
@group(0) @binding(2) var<storage, read_write> spaces: array<Space>;
@group(0) @binding(3) var<storage, read_write> header: array<u32>;

// A face's plane at depth one: its axes, and the rectangle that its cells cover.
struct Face {
    right: vec3<f32>,
    up: vec3<f32>,
    forward: vec3<f32>,
    low: vec2<f32>,
    high: vec2<f32>,
}

// Points may be outside of the face by rounding, not by more.
const MARGIN: f32 = 1e-3;
// Largest extent of a single face from its axis, at depth one.
const WIDEST: f32 = 3.0;

@compute @workgroup_size(1)
fn choose() {
    let low = from_bounds(BOUNDS_LOW, true);
    let high = from_bounds(BOUNDS_LOW + 3u, false);
    var faces = 1u;
    // No point is seen, so there is nothing to do.
    if !all(low <= high) {
        faces = 0u;
    } else if light.is_directional == 1u {
        let middle = 0.5 * low + 0.5 * high;
        write_space(0u, fitted(along(light.vector), middle, low, high, true), middle, light.side_of_one);
    } else if tangent_of_cone() < WIDEST {
        write_space(0u, around_cone(low, high), light.vector, light.side_of_one);
    } else {
        let towards = 0.5 * low + 0.5 * high - light.vector;
        let face = fitted(along(towards), light.vector, low, high, false);
        if all(abs(face.low) <= vec2<f32>(WIDEST)) && all(abs(face.high) <= vec2<f32>(WIDEST)) {
            write_space(0u, face, light.vector, light.side_of_one);
        } else {
            faces = 6u;
            for (var number = 0u; number < 6u; number++) {
                write_space(number, cube_face(number), light.vector, light.side_of_six);
            }
        }
    }
    write_faces(faces);
}

// Tangent of a spot's half-angle; very large if there is no cone.
fn tangent_of_cone() -> f32 {
    let largest = max(max(abs(light.axis.x), abs(light.axis.y)), abs(light.axis.z));
    if !(largest > 1e-15 && largest < 1e15) {
        return 1e30;
    }
    // Rounded down by far more than the error of f32 or of the cone's own edge.
    let squared_cosine = bitcast<f32>(f64_to_f32_bits(light.squared_cosine)) / dot(light.axis, light.axis) - 4e-5;
    return select(1e30, sqrt(max(1.0 / squared_cosine - 1.0, 0.0)), squared_cosine > 1e-3);
}

// The face around a spot's cone, cut to the part that the bounds of all points cover.
fn around_cone(low: vec3<f32>, high: vec3<f32>) -> Face {
    let axes = along(light.axis);
    let widest = vec2<f32>(tangent_of_cone() * (1.0 + MARGIN));
    let of_box = fitted(axes, light.vector, low, high, false);
    var face = axes;
    face.low = -widest;
    face.high = widest;
    let cut_low = max(face.low, of_box.low);
    let cut_high = min(face.high, of_box.high);
    // If the bounds aren't in front of the light, or are wholly outside, the whole cone remains.
    if all(abs(of_box.low) <= vec2<f32>(WIDEST)) && all(abs(of_box.high) <= vec2<f32>(WIDEST))
        && all(cut_low + 1e-5 < cut_high) {
        face.low = cut_low;
        face.high = cut_high;
    }
    return face;
}

// A face along `vector`, without a rectangle.
fn along(vector: vec3<f32>) -> Face {
    let axes = axes_along(vector);
    return Face(axes.right, axes.up, axes.forward, vec2<f32>(0.0), vec2<f32>(0.0));
}

// The rectangle that a box covers; a very large one if the box isn't wholly in front of the light.
fn fitted(axes: Face, origin: vec3<f32>, low: vec3<f32>, high: vec3<f32>, is_parallel: bool) -> Face {
    var face = axes;
    face.low = vec2<f32>(1e30);
    face.high = vec2<f32>(-1e30);
    for (var number = 0u; number < 8u; number++) {
        let is_high = vec3<bool>((number & 1u) != 0u, (number & 2u) != 0u, (number & 4u) != 0u);
        let corner = select(low, high, is_high) - origin;
        let depth = select(dot(corner, face.forward), 1.0, is_parallel);
        let position = vec2<f32>(dot(corner, face.right), dot(corner, face.up));
        if !(depth * WIDEST > max(abs(position.x), abs(position.y))) && !is_parallel {
            face.high = vec2<f32>(1e30);
            return face;
        }
        face.low = min(face.low, position / depth);
        face.high = max(face.high, position / depth);
    }
    let size = max(face.high - face.low, vec2<f32>(1e-3 * max(face.high.x - face.low.x, face.high.y - face.low.y)));
    let spare = max(MARGIN * size, vec2<f32>(select(1e-6, 1e-30, is_parallel)))
        + 1e-6 * (abs(face.low) + abs(face.high));
    face.low -= spare;
    face.high += spare;
    return face;
}

fn cube_face(number: u32) -> Face {
    let axis = number >> 1u;
    let sign = select(1.0, -1.0, (number & 1u) == 1u);
    var face: Face;
    face.forward[axis] = sign;
    face.right[(axis + 1u) % 3u] = 1.0;
    face.up[(axis + 2u) % 3u] = 1.0;
    face.low = vec2<f32>(-1.0 - MARGIN);
    face.high = vec2<f32>(1.0 + MARGIN);
    return face;
}

fn write_space(number: u32, face: Face, origin: vec3<f32>, side: u32) {
    let fraction_bits = BIN_FRACTION_BITS;
    let unit = power_of_two(i32(fraction_bits));
    let scale = f32(BINS) * unit / (face.high - face.low);
    var raster: Raster;
    raster.columns = i32(BINS);
    raster.rows = i32(BINS);
    raster.fraction_bits = fraction_bits;
    raster.tile_columns = side;
    raster.tile_rows = side;
    raster.slices = light.slices;
    raster.first_cell = number * side * side * light.slices;
    raster.is_orthographic = light.is_directional;
    // The error that `map` allows, and a rounding.
    raster.position_error = 6u;
    // Rows go up here, so axes are right-handed, like a camera's with rows that go down.
    raster.is_mirrored = u32(dot(cross(face.right, face.up), face.forward) < 0.0);

    // (x − low · depth) · scale; for parallel light (x − low) · scale.
    let shift = -face.low * scale;
    let of_depth = select(shift, vec2<f32>(0.0), light.is_directional == 1u);
    let x = face.right * scale.x + face.forward * of_depth.x;
    let y = face.up * scale.y + face.forward * of_depth.y;
    let added = select(vec2<f32>(0.0), shift, light.is_directional == 1u);
    let reach = max(abs(x), abs(y));
    raster.row_reach = max(max(reach.x, reach.y), reach.z);
    // As for cameras; at most half a unit, since faces are at least 2⁻¹⁹ wide and `row_reach` is below 2⁴⁸.
    raster.depth_bits = u32(clamp(48.0 - ceil(log2(raster.row_reach)), 0.0, 12.0));
    if light.is_directional == 1u {
        // Depths also have an error of 2⁻⁴⁹ of the range of fixed-point positions.
        let found_from = abs(origin) + light.reach;
        let aside = face.high - face.low;
        raster.depth_error = 4.0 * POINT_ERROR * (found_from.x + found_from.y + found_from.z + aside.x + aside.y);
    }
    spaces[number].raster = raster;
    write_projection(number, array<f32, 14>(
        origin.x, origin.y, origin.z,
        x.x, x.y, x.z, y.x, y.y, y.z, face.forward.x, face.forward.y, face.forward.z,
        added.x, added.y));
}
