// Stage `choose` of a light that sees by angles: chooses its axes, and the power of two that scales offsets from it.

import package::grid::header::{HEADER_ANGLES_DIVIDED};
import package::grid::space::{Raster, Space, power_of_two};
import package::light::choices::{axes_along, from_bounds, write_faces, write_projection};
import package::light::light::{Light};
import package::light::points::{BOUNDS_LOW, POINT_ERROR};

@group(0) @binding(0) var<uniform> light: Light;
@group(0) @binding(1) var<storage, read> bounds: array<u32>;
@group(0) @binding(2) var<storage, read_write> spaces: array<Space>;
@group(0) @binding(3) var<storage, read_write> header: array<u32>;

@compute @workgroup_size(1)
fn choose() {
    let low = from_bounds(BOUNDS_LOW, true);
    let high = from_bounds(BOUNDS_LOW + 3u, false);
    // No point is seen, so there is nothing to do.
    if !all(low <= high) {
        write_faces(0u);
        return;
    }
    // A spot's own direction, or the one towards the middle of the points' bounds.
    let is_spot = any(light.axis != vec3<f32>(0.0));
    let towards = select(0.5 * low + 0.5 * high - light.vector, light.axis, is_spot);
    var axes = axes_along(towards);
    // To the right along the image's rows, unless the light looks along them.
    let across = light.along_rows - axes.forward * dot(axes.forward, light.along_rows);
    if dot(across, across) > 1e-4 * dot(light.along_rows, light.along_rows) {
        axes.right = normalize(across);
        axes.up = cross(axes.right, axes.forward);
    }
    // A quarter of the farthest point's largest coordinate, which is in f32's range if the coordinates are.
    let low_offset = abs(0.25 * low - 0.25 * light.vector);
    let high_offset = abs(0.25 * high - 0.25 * light.vector);
    let farthest = max(low_offset, high_offset);
    let exponent = i32(bitcast<u32>(max(max(farthest.x, farthest.y), farthest.z)) >> 23u) - 127;
    // At most 2⁵⁰, so that the bounds of `trace` hold.
    let scale = power_of_two(clamp(-exponent - 3, -126, 50));

    var raster: Raster;
    raster.tile_columns = light.side_of_one;
    raster.tile_rows = light.side_of_one;
    raster.slices = light.slices;
    raster.row_reach = scale;
    let largest = max(max(abs(light.vector.x), abs(light.vector.y)), abs(light.vector.z));
    raster.depth_error = 4.0 * POINT_ERROR * (light.reach * scale + largest * scale);
    spaces[0].raster = raster;
    write_projection(0u, array<f32, 14>(
        light.vector.x, light.vector.y, light.vector.z,
        axes.right.x, axes.right.y, axes.right.z, axes.up.x, axes.up.y, axes.up.z,
        axes.forward.x, axes.forward.y, axes.forward.z, 0.0, 0.0));
    if light.has_clamp == 1u {
        header[HEADER_ANGLES_DIVIDED] = u32(light.clamp_low.x);
        header[HEADER_ANGLES_DIVIDED + 1u] = u32(light.clamp_low.y);
        header[HEADER_ANGLES_DIVIDED + 2u] = u32(light.clamp_high.x);
        header[HEADER_ANGLES_DIVIDED + 3u] = u32(light.clamp_high.y);
    }
    write_faces(1u);
}
