// Puts what each place shows into the image's rows.

import package::dispatch::{flat_group};
import package::tile_order::{pixel_of_place};

struct RowsSize {
    size_pixels: vec2<u32>,
}

@group(0) @binding(0) var<uniform> rows_size: RowsSize;
@group(0) @binding(1) var<storage, read> rows_seen: array<u32>;
@group(0) @binding(2) var<storage, read_write> rows_triangle: array<u32>;

@compute @workgroup_size(64)
fn rows(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let place = flat_group(group, groups) * 64u + lane;
    let pixel = pixel_of_place(place, rows_size.size_pixels.x);
    if all(pixel < rows_size.size_pixels) {
        rows_triangle[pixel.y * rows_size.size_pixels.x + pixel.x] = rows_seen[place];
    }
}
