// A generation of rays and its planes. The first generation has a camera ray per slot.

import package::tile_order::{pixel_of_slot};
import stage::{onward_step, planes};

struct OnwardStep {
    // Number of rays or slots.
    count: u32,
    is_first: u32,
    // Columns and rows of planes: the image's, or one row of rays.
    size: vec2<u32>,
    // Offset of the planes of ways in `planes`; number of these planes; whether lights are traced before shading.
    ways_plane: u32,
    ways: u32,
    is_asked_first: u32,
    // Offsets of the plane of flat colours in the rays' planes and in the film; NOWHERE without one.
    flat_plane: u32,
    flat_plane_of_film: u32,
}

const NOWHERE: u32 = 0xffffffffu;

// A ray's index in planes; `NOWHERE` for a slot outside of the image.
fn index_in_planes(number: u32) -> u32 {
    if onward_step.is_first == 0u {
        return number;
    }
    let column_and_row = pixel_of_slot(number, onward_step.size.x);
    return select(NOWHERE, column_and_row.y * onward_step.size.x + column_and_row.x, all(column_and_row < onward_step.size));
}

// A value of one of the planes of ways.
fn way_at(index: u32, plane: u32) -> vec4<f32> {
    return planes[onward_step.ways_plane + plane * onward_step.size.x * onward_step.size.y + index];
}

// The ways of a ray: WAY_… bits.
fn way_bits(index: u32) -> u32 {
    return u32(way_at(index, 1u).w);
}
