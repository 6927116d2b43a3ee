// What `trace` does with a block, however the light sees points and triangles: up to 64 points of a cell, one an
// invocation, and triangles that come in batches through workgroup memory. What the filter leaves undecided is noted for
// `settle`.
//
// A stage says what a `Cell` and a `Point` (`own` is the triangle that it is on) are to its filter, and which points a
// triangle that was `record`ed may shadow, and does for certain.

import package::dispatch::{flat_group};
import package::light::blocks::{LIGHT_BLOCKS_FIRST, LIGHT_BLOCK_WORDS};
import package::light::undecided::{leave_undecided};
import package::mask::filter::{MASK_THERE, MASK_UNDECIDED, mask_filter};
import package::mask::flags::{TRIANGLE_SHADOW_MASKED};
import stage::{
    Cell, Point, blocks, cell_of_block, does_shadow, light, lit, may_shadow, pairs, point_at, point_on, record, sorted,
    triangles,
};

const BATCH: u32 = 64u;

// An id is no number: the bits of a small one would be taken for zero.
var<workgroup> record_id: array<u32, BATCH>;
var<workgroup> still_lit: atomic<u32>;
var<workgroup> goes_on: u32;

// Whether the point is in shadow for certain, as far as these triangles go.
fn test_batch(point: Point, slot: u32, count: u32, cell: Cell) -> bool {
    for (var start = 0u; start < count; start += 32u) {
        // First which may be before it: the rest runs only where some point of a few has one.
        var candidates = 0u;
        for (var i = 0u; i < min(count - start, 32u); i++) {
            candidates |= u32(may_shadow(start + i, point) && record_id[start + i] != point.own) << i;
        }
        while candidates != 0u {
            let number = start + firstTrailingBit(candidates);
            candidates &= candidates - 1u;
            let id = record_id[number];
            let is_certain = does_shadow(number, point);
            var answer = select(MASK_UNDECIDED, MASK_THERE, is_certain);
            // A loop of one turn at most: software adapters skip it where no point needs it.
            var is_masked = is_certain && (triangles[id].w & TRIANGLE_SHADOW_MASKED) != 0u;
            while is_masked {
                answer = mask_filter(triangles[id], point_on(number, id, point, cell), true);
                is_masked = false;
            }
            if answer == MASK_THERE {
                return true;
            }
            if answer == MASK_UNDECIDED {
                leave_undecided(slot, id);
            }
        }
    }
    return false;
}

fn trace_block(group: vec3<u32>, lane: u32) {
    let block = flat_group(group);
    if block >= blocks[0] {
        return;
    }
    let entry = LIGHT_BLOCKS_FIRST + block * LIGHT_BLOCK_WORDS;
    let first_pair = blocks[entry + 3u];
    let end_pair = min(blocks[entry + 4u], arrayLength(&pairs));
    let cell = cell_of_block(entry);

    let number = blocks[entry + 1u] + lane;
    var is_dark = number >= blocks[entry + 2u];
    var point: Point;
    var slot = 0u;
    if !is_dark {
        slot = sorted[number].w;
        point = point_at(number, sorted[light.slots + number / 4u][number & 3u], cell);
        is_dark = ((atomicLoad(&lit[light.mask + slot / 32u]) >> (slot & 31u)) & 1u) == 0u;
    }
    for (var first = first_pair; first < end_pair; first += BATCH) {
        if first + lane < end_pair {
            let id = pairs[first + lane];
            record_id[lane] = id;
            record(lane, id, cell);
        }
        if lane == 0u {
            atomicStore(&still_lit, 0u);
        }
        workgroupBarrier();
        if !is_dark {
            is_dark = test_batch(point, slot, min(end_pair - first, BATCH), cell);
            if is_dark {
                atomicAnd(&lit[light.mask + slot / 32u], ~(1u << (slot & 31u)));
            } else {
                atomicOr(&still_lit, 1u);
            }
        }
        workgroupBarrier();
        if lane == 0u {
            goes_on = atomicLoad(&still_lit);
        }
        if workgroupUniformLoad(&goes_on) == 0u {
            break;
        }
    }
}
