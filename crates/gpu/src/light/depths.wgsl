// Finds the nearest and farthest points, which bound the depth slices: each workgroup gathers keys, then writes them.

import package::grid::header::{HEADER_POINT_KEYS};
import package::grid::space::{ordered_bits};
import stage::{header, light};

// Same words as in the header.
var<workgroup> keys_of_group: array<atomic<u32>, 2>;

fn note_key(key: u32) {
    if light.slices > 1u {
        let ordered = ordered_bits(bitcast<f32>(key));
        atomicMax(&keys_of_group[0], ordered);
        atomicMax(&keys_of_group[1], ~ordered);
    }
}

// Call it after a barrier.
fn write_keys(lane: u32) {
    if light.slices > 1u && lane < 2u {
        atomicMax(&header[HEADER_POINT_KEYS + lane], atomicLoad(&keys_of_group[lane]));
    }
}
