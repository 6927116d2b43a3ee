// Traces a block, for lights that see by faces or by angles: up to 64 points of a cell, one for each invocation, and
// triangles that come in batches through workgroup memory. Pairs that the filter leaves undecided are noted for `settle`.
//
// A stage defines `Cell` and `Point` (`own` is the triangle that it is on) for its filter, and two tests of points
// against `record`ed triangles: whether one may shadow the point, and whether it certainly does.

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

// An id is kept as an integer: as a float, the bits of a small one could be flushed to zero.
var<workgroup> record_id: array<u32, BATCH>;
var<workgroup> still_lit: atomic<u32>;
var<workgroup> goes_on: u32;

// Whether a triangle of the batch certainly shadows the point.
fn test_batch(point: Point, slot: u32, count: u32, cell: Cell) -> bool {
    for (var start = 0u; start < count; start += 32u) {
        // First finds candidates, so that the longer code runs only where a point of the subgroup has one.
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
            // A loop of at most one turn, because software adapters skip it where no point needs it.
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
