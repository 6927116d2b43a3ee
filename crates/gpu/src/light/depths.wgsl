// How near and how far points are, for slices between: gathered by a workgroup, which writes them in the end.

import package::grid::header::{HEADER_POINT_KEYS};
import package::grid::space::{ordered_bits};
import stage::{header, light};

// As in the header.
var<workgroup> keys_of_group: array<atomic<u32>, 2>;

fn note_key(key: u32) {
    if light.slices > 1u {
        let ordered = ordered_bits(bitcast<f32>(key));
        atomicMax(&keys_of_group[0], ordered);
        atomicMax(&keys_of_group[1], ~ordered);
    }
}

// After a barrier.
fn write_keys(lane: u32) {
    if light.slices > 1u && lane < 2u {
        atomicMax(&header[HEADER_POINT_KEYS + lane], atomicLoad(&keys_of_group[lane]));
    }
}
