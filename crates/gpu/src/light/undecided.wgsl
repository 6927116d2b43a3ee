// Undecided pairs, left to the predicate: a slot and a triangle, or a page of triangles.

import package::dispatch::{groups_of};
import package::light::points::{
    UNDECIDED_COUNT, UNDECIDED_FIRST, UNDECIDED_GROUPS, UNDECIDED_PAGE, UNDECIDED_PAGE_TRIANGLES,
};
import stage::{light, undecided};

fn leave_undecided(slot: u32, id: u32) {
    let word = UNDECIDED_FIRST + 2u * atomicAdd(&undecided[UNDECIDED_COUNT], 1u);
    if word + 2u <= arrayLength(&undecided) {
        atomicStore(&undecided[word], slot);
        atomicStore(&undecided[word + 1u], id);
    }
}

fn compare_with_all(slot: u32) {
    let pages = (light.triangles + UNDECIDED_PAGE_TRIANGLES - 1u) / UNDECIDED_PAGE_TRIANGLES;
    let first = atomicAdd(&undecided[UNDECIDED_COUNT], pages);
    for (var page = 0u; page < pages; page++) {
        let word = UNDECIDED_FIRST + 2u * (first + page);
        if word + 2u > arrayLength(&undecided) {
            return;
        }
        atomicStore(&undecided[word], slot);
        atomicStore(&undecided[word + 1u], UNDECIDED_PAGE | page);
    }
}

// Writes the size of the dispatch that settles all pairs.
fn write_settle_groups() {
    let room = (arrayLength(&undecided) - UNDECIDED_FIRST) / 2u;
    let groups = groups_of((min(atomicLoad(&undecided[UNDECIDED_COUNT]), room) + 63u) / 64u);
    atomicStore(&undecided[UNDECIDED_GROUPS], groups.x);
    atomicStore(&undecided[UNDECIDED_GROUPS + 1u], groups.y);
    atomicStore(&undecided[UNDECIDED_GROUPS + 2u], groups.z);
}
