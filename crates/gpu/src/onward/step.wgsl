// A generation of rays, and the planes of what it has shown. The first are the camera's: those of a slot each.

import package::tile_order::{pixel_of_slot};
import stage::{onward_step, planes};

struct OnwardStep {
    // How many rays or slots there are.
    count: u32,
    is_first: u32,
    // Columns and rows of planes: those of the pixels, or one row of rays.
    size: vec2<u32>,
    // Where the planes of its ways begin, how many there are, and whether lights are asked before shading.
    ways_plane: u32,
    ways: u32,
    is_asked_first: u32,
    // Where in the rays' planes, and in the film's, is what is shown as it is; NOWHERE where that isn't kept.
    flat_plane: u32,
    flat_plane_of_film: u32,
}

const NOWHERE: u32 = 0xffffffffu;

// Where a ray is in planes; `NOWHERE` for a slot that is no pixel.
fn index_in_planes(number: u32) -> u32 {
    if onward_step.is_first == 0u {
        return number;
    }
    let column_and_row = pixel_of_slot(number, onward_step.size.x);
    return select(NOWHERE, column_and_row.y * onward_step.size.x + column_and_row.x, all(column_and_row < onward_step.size));
}

// What one of the planes of ways says.
fn way_at(index: u32, plane: u32) -> vec4<f32> {
    return planes[onward_step.ways_plane + plane * onward_step.size.x * onward_step.size.y + index];
}

// Which ways there are.
fn way_bits(index: u32) -> u32 {
    return u32(way_at(index, 1u).w);
}
