// Copies each slot's triangle to the image's rows.

import package::dispatch::{Invocation, flat_index};
import package::tile_order::{pixel_of_slot};

struct RowsSize {
    size_pixels: vec2<u32>,
}

@group(0) @binding(0) var<uniform> rows_size: RowsSize;
@group(0) @binding(1) var<storage, read> rows_seen: array<u32>;
@group(0) @binding(2) var<storage, read_write> rows_triangle: array<u32>;

@compute @workgroup_size(64)
fn rows(at: Invocation) {
    let slot = flat_index(at, 64u);
    let pixel = pixel_of_slot(slot, rows_size.size_pixels.x);
    if all(pixel < rows_size.size_pixels) {
        rows_triangle[pixel.y * rows_size.size_pixels.x + pixel.x] = rows_seen[slot];
    }
}
