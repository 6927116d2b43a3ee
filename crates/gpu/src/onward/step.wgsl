// A generation of rays, and the planes of what it has shown. The first are the camera's: those of a slot each.

import package::tile_order::{pixel_of_slot};
import stage::{onward_step};

struct OnwardStep {
    // How many rays or slots there are.
    count: u32,
    is_first: u32,
    // Columns and rows of planes: those of the pixels, or one row of rays.
    size: vec2<u32>,
    // Where the first of two planes begins: a mirror's direction and how far it is from there to the camera; then how much
    // of what is there reaches it, and whether that is followed.
    ways_plane: u32,
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

// Where the planes say how much is followed.
fn second_way(index: u32) -> u32 {
    return onward_step.ways_plane + onward_step.size.x * onward_step.size.y + index;
}
