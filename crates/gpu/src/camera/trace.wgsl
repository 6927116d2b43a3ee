// Stages `trace` and `merge`: find the triangle that each pixel sees.
//
// A workgroup has a tile of 16×16 pixels, one for each invocation, and takes the tile's triangles in batches through
// workgroup memory, from front to back. Hits that the filter can't decide, and hits whose depths it can't tell apart,
// become nodes of a list for each pixel, which stage `settle` decides.

import package::camera::nodes::{
    NODES_ANY, NODES_COUNT, NODES_FIRST, NODES_GROUPS, NODES_PIXELS, NODES_PIXEL_GROUPS, NODE_CERTAIN, NODE_FRONT,
    NODE_KEY, NODE_NEXT, NODE_SLOT, NODE_WORDS, NONE, node_pixel_room,
};
import package::camera::work::{
    BLOCK_PAIRS, BLOCK_WORDS, MAPPING, TRACING_TILE, WORK_BLOCKS, WORK_FIRST_BLOCK, WORK_KEYS,
};
import package::dispatch::{Invocation, flat_group, groups_of};
import package::grid::set_up::{INFINITE, U, corners_of, edges_near, rect_of, shows_back};
import package::grid::space::{Raster, Space, from_ordered_bits, slice_depth};
import package::mask::filter::{MASK_CUT, MASK_THERE, mask_filter};
import package::mask::flags::{TRIANGLE_MASKED, TRIANGLE_ONE_SIDED};
import package::mask::rough_point::{rough_point};
import package::tile_order::{slot_of_pixel};

@group(0) @binding(0) var<uniform> space: Space;
@group(0) @binding(1) var<storage, read> triangles: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> vertices: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read> positions: array<u32>;
// The end of each cell's list, then the blocks.
@group(0) @binding(4) var<storage, read> cells: array<u32>;
@group(0) @binding(5) var<storage, read> pairs: array<u32>;
// The triangle of each pixel, then the partial results of cut tiles: four words for each of a block's pixels.
@group(0) @binding(6) var<storage, read_write> seen: array<u32>;
@group(0) @binding(7) var<storage, read_write> nodes: array<atomic<u32>>;
@group(0) @binding(8) var<storage, read> masks: array<u32>;

const RECORDS: u32 = 128u;

// Edge functions and key at the sorting tile's middle, packed; the edge error is negative where the winding is uncertain.
var<workgroup> record_a: array<vec4<f32>, RECORDS>;
var<workgroup> record_b: array<vec4<f32>, RECORDS>;
var<workgroup> record_c: array<vec3<f32>, RECORDS>;
var<workgroup> record_d: array<vec3<f32>, RECORDS>;
// The triangle's id, and a bit for each column and row of the tile that its bounds touch. Integers have arrays of their own:
// as floats, the bits of small ones could be flushed to zero.
var<workgroup> record_id: array<u32, RECORDS>;
var<workgroup> record_pixels: array<u32, RECORDS>;
var<workgroup> unfinished: atomic<u32>;
var<workgroup> goes_on: u32;

// The start of the interval in which hits count: the triangle that the pixel has seen already, if it looks behind, or
// else the camera.
struct Front {
    triangle: u32,
    key: f32,
    error: f32,
}

// The triangle that a pixel certainly sees so far, and its list of undecided nodes.
struct Best {
    triangle: u32,
    key: f32,
    error: f32,
    node: u32,
    // The pixel's slot.
    pixel: u32,
}

fn record(slot: u32, id: u32, tile_first: vec2<i32>, raster: Raster) {
    let triangle = triangles[id].xyz;
    let corners = corners_of(vertices[triangle.x], vertices[triangle.y], vertices[triangle.z]);
    let whole = rect_of(corners, raster);
    let side = i32(TRACING_TILE / MAPPING);
    let first = clamp(whole.first - tile_first, vec2<i32>(0), vec2<i32>(side));
    let last = clamp(whole.last - tile_first, vec2<i32>(-1), vec2<i32>(side - 1));
    let middle = (first + last) / 2;
    let reach = max(max(last.x - middle.x, last.y - middle.y), max(middle.x - first.x, middle.y - first.y));
    let edges = edges_near(corners, (tile_first + middle) << vec2<u32>(raster.fraction_bits), f32(reach), raster);
    let shows_nothing = (triangles[id].w & TRIANGLE_ONE_SIDED) != 0u && shows_back(edges, raster);
    record_pixels[slot] = select(0u, bits_of_rect(first, last), all(first <= last) && !shows_nothing);
    // Moved from the triangle's own middle to the tile's.
    let shift = half_side() - vec2<f32>(middle);
    let edge_error = edges.edge_error + shift_error(edges.a, edges.b, edges.c);
    record_a[slot] = vec4<f32>(edges.a, select(-edge_error, edge_error, edges.is_oriented));
    record_b[slot] = vec4<f32>(edges.b, edges.key_error
        + shift_error(vec3<f32>(edges.key.x), vec3<f32>(edges.key.y), vec3<f32>(edges.key.z)));
    record_c[slot] = edges.c + edges.a * shift.x + edges.b * shift.y;
    record_d[slot] = vec3<f32>(edges.key.xy, edges.key.z + edges.key.x * shift.x + edges.key.y * shift.y);
    record_id[slot] = id;
}

// Rounding error of a·x + b·y + c, moved by at most half a tile and then evaluated at most half a tile away: three
// roundings of these terms, then two of them and two of the moved c, which may be as large again.
fn shift_error(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> f32 {
    let terms = 7.0 * half_side() * (abs(a) + abs(b)) + 3.0 * abs(c);
    return U * max(max(terms.x, terms.y), terms.z);
}

// Half the side of a sorting tile, in pixels.
fn half_side() -> f32 {
    return 0.5 * f32(TRACING_TILE / MAPPING);
}

// Bits of the columns from `first.x` to `last.x`, then of the rows from `first.y` to `last.y`.
fn bits_of_rect(first: vec2<i32>, last: vec2<i32>) -> u32 {
    let bits = (vec2<u32>(2u) << vec2<u32>(last)) - (vec2<u32>(1u) << vec2<u32>(first));
    return bits.x | (bits.y << 16u);
}

fn push_node(best: ptr<function, Best>, id: u32, key: f32) {
    let node = atomicAdd(&nodes[NODES_COUNT], 1u);
    let base = NODES_FIRST + node * NODE_WORDS;
    // The first comparison guards against products beyond 32 bits.
    if node < arrayLength(&nodes) / NODE_WORDS && base + NODE_WORDS <= arrayLength(&nodes) {
        atomicStore(&nodes[base], id);
        atomicStore(&nodes[base + NODE_NEXT], (*best).node);
        atomicStore(&nodes[base + NODE_KEY], bitcast<u32>(key));
        atomicStore(&nodes[base + NODE_SLOT], (*best).pixel);
        (*best).node = node;
    }
}

// Whether two vertices are at the same point.
fn are_same_point(a: u32, b: u32) -> bool {
    return a == b || (positions[3u * a] == positions[3u * b] && positions[3u * a + 1u] == positions[3u * b + 1u]
        && positions[3u * a + 2u] == positions[3u * b + 2u]);
}

// Whether two triangles have the same corners, in any order, and so the same hits.
fn same_triangle(a: u32, b: u32) -> bool {
    let first = triangles[a].xyz;
    let second = triangles[b].xyz;
    for (var turn = 0u; turn < 3u; turn++) {
        let x = second[turn];
        let y = second[(turn + 1u) % 3u];
        let z = second[(turn + 2u) % 3u];
        if are_same_point(first.x, x) && ((are_same_point(first.y, y) && are_same_point(first.z, z))
            || (are_same_point(first.y, z) && are_same_point(first.z, y))) {
            return true;
        }
    }
    return false;
}

// Takes a certain or possible hit into a pixel's `Best`. Returns whether the hit stays undecided.
fn offer(best: ptr<function, Best>, id: u32, key: f32, error: f32, is_hit: bool) -> bool {
    let has_best = (*best).triangle != NONE;
    if has_best && key + error < (*best).key - (*best).error {
        return false;
    }
    if is_hit && (!has_best || key - error > (*best).key + (*best).error) {
        (*best).triangle = id;
        (*best).key = key;
        (*best).error = error;
        return false;
    }
    return true;
}

// Leaves a possible nearest hit to `settle`, unless its triangle is a copy of the one seen already.
fn leave_undecided(best: ptr<function, Best>, id: u32, nearest: f32, is_hit: bool) {
    if is_hit && same_triangle(id, (*best).triangle) {
        (*best).triangle = min(id, (*best).triangle);
    } else {
        push_node(best, id, nearest);
    }
}

// Whether a pixel, `p` from its tile's middle, may be on a triangle.
fn may_hit(slot: u32, bits: u32, p: vec2<f32>) -> bool {
    let edge = edges_at(slot, p);
    let error = record_a[slot].w;
    let is_beside = min(min(edge.x, edge.y), edge.z) < -abs(error)
        && (error > 0.0 || max(max(edge.x, edge.y), edge.z) > abs(error));
    return (record_pixels[slot] & bits) == bits && !is_beside;
}

fn edges_at(slot: u32, p: vec2<f32>) -> vec3<f32> {
    return record_a[slot].xyz * p.x + record_b[slot].xyz * p.y + record_c[slot];
}

// Tests records from `first` on against a pixel: first finds all candidates, then tests these. So the longer code runs
// only where a pixel of the subgroup has a candidate.
fn test_batch(best: ptr<function, Best>, front: Front, first: u32, count: u32, pixel: vec2<u32>) {
    let p = vec2<f32>(pixel) - half_side();
    let bits = (1u << pixel.x) | (0x10000u << pixel.y);
    for (var start = 0u; start < count; start += 32u) {
        var candidates = 0u;
        for (var i = 0u; i < min(count - start, 32u); i++) {
            candidates |= u32(may_hit(first + start + i, bits, p)) << i;
        }
        while candidates != 0u {
            let slot = first + start + firstTrailingBit(candidates);
            candidates &= candidates - 1u;
            let d = record_d[slot];
            let edge = edges_at(slot, p);
            let edge_error = record_a[slot].w;
            var is_hit = edge_error > 0.0 && min(min(edge.x, edge.y), edge.z) > edge_error;
            let key = d.x * p.x + d.y * p.y + d.z;
            let id = record_id[slot];
            // Loops of at most one turn, because software adapters skip a loop where no pixel needs it.
            var is_masked = is_hit && (triangles[id].w & TRIANGLE_MASKED) != 0u;
            var is_cut = false;
            while is_masked {
                let point = rough_point(
                    triangles[id].xyz, edge, edge_error, space.raster.is_orthographic == 1u);
                let answer = mask_filter(triangles[id], point, false);
                is_cut = answer == MASK_CUT;
                is_hit = answer == MASK_THERE;
                is_masked = false;
            }
            let front_error = front.error + record_b[slot].w;
            is_cut |= id == front.triangle || key > front.key + front_error;
            is_hit = is_hit && key < front.key - front_error;
            var is_undecided = !is_cut && offer(best, id, key, record_b[slot].w, is_hit);
            while is_undecided {
                leave_undecided(best, id, key + record_b[slot].w, is_hit);
                is_undecided = false;
            }
        }
    }
}

// Upper bound on the keys of pairs from `pair` on, in the tile's current slice and the slices behind it.
fn bound_of_rest(first_cell: u32, pair: u32, slice: ptr<function, u32>) -> f32 {
    let slices = space.raster.slices;
    while *slice < slices && cells[first_cell + *slice] <= pair {
        *slice += 1u;
    }
    if *slice == 0u {
        return INFINITE;
    }
    let work = space.raster.tile_columns * space.raster.tile_rows * slices;
    let first = cells[work + WORK_KEYS];
    let last = cells[work + WORK_KEYS + 1u];
    if first <= last {
        return INFINITE;
    }
    // Slice limits are integers, so the bound is exact.
    return from_ordered_bits(first - *slice * slice_depth(first, last, slices));
}

// A block of work: its tile's first pixel, its number among the tile's blocks, the number of these, and the index of
// the first of their partial results. `blocks` is zero if there is no such block.
struct Block {
    tile_first: vec2<u32>,
    number: u32,
    blocks: u32,
    first_partial: u32,
}

fn block_at(number: u32) -> Block {
    let raster = space.raster;
    let work = raster.tile_columns * raster.tile_rows * raster.slices;
    if number >= cells[work + WORK_BLOCKS] {
        return Block(vec2<u32>(0u), 0u, 0u, 0u);
    }
    let entry = work + WORK_FIRST_BLOCK + number * BLOCK_WORDS;
    let columns = (raster.tile_columns + MAPPING - 1u) / MAPPING;
    let tile_first = vec2<u32>(cells[entry] % columns, cells[entry] / columns) * TRACING_TILE;
    return Block(tile_first, cells[entry + 1u], cells[entry + 2u], cells[entry + 3u]);
}

// Position in its tile of an invocation's pixel, in storage order.
fn local_pixel(lane: u32) -> vec2<u32> {
    return vec2<u32>(((lane >> 4u) & 3u) * 4u + (lane & 3u), (lane >> 6u) * 4u + ((lane >> 2u) & 3u));
}

@compute @workgroup_size(256)
fn trace(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let raster = space.raster;
    let block = block_at(flat_group(group));
    if block.blocks == 0u {
        return;
    }
    let tile_first = block.tile_first;
    let local = local_pixel(lane);
    let side = TRACING_TILE / MAPPING;
    let sub = local / side;
    let pixel = tile_first + local;
    var is_inside = pixel.x < u32(raster.columns) && pixel.y < u32(raster.rows);
    // Parallel rays start at depth zero; the edge functions of perspective rays are positive only in front of the camera.
    var front = Front(NONE, select(INFINITE, 0.0, raster.is_orthographic == 1u), 0.0);
    if raster.sees_behind == 1u && is_inside {
        front = front_of(pixel);
        // A pixel without a triangle has none behind it.
        is_inside = front.triangle != NONE;
    }

    // Each sorting tile has its share of the records.
    let share = RECORDS / (MAPPING * MAPPING);
    let own = sub.y * MAPPING + sub.x;
    let filled = lane / share;
    let own_list = list_of(tile_first / side + sub, block.number);
    let filled_sub = vec2<u32>(filled % MAPPING, filled / MAPPING);
    let filled_list = list_of(tile_first / side + filled_sub, block.number);
    let filled_first = vec2<i32>(tile_first + filled_sub * side);

    var best = Best(NONE, 0.0, 0.0, NONE, slot_of_pixel(pixel, u32(raster.columns)));
    var slice = 0u;
    for (var batch = 0u; batch < BLOCK_PAIRS; batch += share) {
        let pair = filled_list.x + batch + lane % share;
        if lane < RECORDS && pair < filled_list.y {
            record(lane, pairs[pair], filled_first, raster);
        }
        if lane == 0u {
            atomicStore(&unfinished, 0u);
        }
        workgroupBarrier();
        let next = own_list.x + batch + share;
        if is_inside && own_list.x + batch < own_list.y {
            let count = min(own_list.y - own_list.x - batch, share);
            test_batch(&best, front, own * share, count, local - sub * side);
            let is_settled = next >= own_list.y
                || (best.triangle != NONE && best.key - best.error > bound_of_rest(own_list.z, next, &slice));
            if !is_settled {
                atomicOr(&unfinished, 1u);
            }
        }
        workgroupBarrier();
        if lane == 0u {
            goes_on = atomicLoad(&unfinished);
        }
        if workgroupUniformLoad(&goes_on) == 0u {
            break;
        }
    }
    if block.blocks > 1u {
        let word = partial_word(block.first_partial + block.number, lane);
        if word + 4u <= arrayLength(&seen) {
            seen[word] = best.triangle;
            seen[word + 1u] = bitcast<u32>(best.key);
            seen[word + 2u] = bitcast<u32>(best.error);
            seen[word + 3u] = best.node;
        }
    } else if is_inside {
        write_seen(best, front.triangle);
    }
}

// The triangle that a pixel has seen so far, with its key.
fn front_of(pixel: vec2<u32>) -> Front {
    let raster = space.raster;
    let id = seen[slot_of_pixel(pixel, u32(raster.columns))];
    if id == NONE {
        return Front(NONE, 0.0, 0.0);
    }
    let triangle = triangles[id].xyz;
    let corners = corners_of(vertices[triangle.x], vertices[triangle.y], vertices[triangle.z]);
    let edges = edges_near(corners, vec2<i32>(pixel) << vec2<u32>(raster.fraction_bits), 0.0, raster);
    return Front(id, edges.key.z, edges.key_error);
}

// First word of the partial result of a block's pixel.
fn partial_word(block: u32, lane: u32) -> u32 {
    let slots = (((u32(space.raster.columns) + 63u) >> 6u) * ((u32(space.raster.rows) + 63u) >> 6u)) << 12u;
    return slots + (block * 256u + lane) * 4u;
}

// The range of a sorting tile's list that block `number` takes: its first and end index, and the tile's first cell.
fn list_of(tile: vec2<u32>, number: u32) -> vec3<u32> {
    let raster = space.raster;
    if tile.x >= raster.tile_columns || tile.y >= raster.tile_rows {
        return vec3<u32>(0u);
    }
    let first_cell = (tile.y * raster.tile_columns + tile.x) * raster.slices;
    let start = select(0u, cells[max(first_cell, 1u) - 1u], first_cell > 0u);
    let end = min(cells[first_cell + raster.slices - 1u], arrayLength(&pairs));
    let first = min(start + number * BLOCK_PAIRS, end);
    return vec3<u32>(first, min(first + BLOCK_PAIRS, end), first_cell);
}

// Writes the triangle that is seen for certain, or queues the pixel for `settle`.
fn write_seen(best: Best, front: u32) {
    if front != NONE && (best.triangle != NONE || best.node != NONE) {
        atomicStore(&nodes[NODES_ANY], 1u);
    }
    if best.node == NONE {
        seen[best.pixel] = best.triangle;
        return;
    }
    var last = best;
    if best.triangle != NONE {
        push_node(&last, best.triangle | NODE_CERTAIN, best.key - best.error);
    }
    if front != NONE {
        push_node(&last, front | NODE_FRONT, INFINITE);
    }
    seen[best.pixel] = last.node;
    // If nodes and pixels meet, the frame is rendered again with more room.
    let count = atomicAdd(&nodes[NODES_PIXELS], 1u);
    if count < node_pixel_room(atomicLoad(&nodes[NODES_COUNT]), arrayLength(&nodes)) {
        atomicStore(&nodes[arrayLength(&nodes) - 1u - count], best.pixel);
    }
}

// Joins the partial results of a tile's blocks.
@compute @workgroup_size(256)
fn merge(at: Invocation) {
    let raster = space.raster;
    let block = block_at(flat_group(at.group));
    // The first block of a cut tile merges for all of them.
    if block.number != 0u || block.blocks < 2u {
        return;
    }
    let pixel = block.tile_first + local_pixel(at.lane);
    if pixel.x >= u32(raster.columns) || pixel.y >= u32(raster.rows) {
        return;
    }
    var front = NONE;
    if raster.sees_behind == 1u {
        front = seen[slot_of_pixel(pixel, u32(raster.columns))];
        if front == NONE {
            return;
        }
    }
    var best = Best(NONE, 0.0, 0.0, NONE, slot_of_pixel(pixel, u32(raster.columns)));
    for (var number = 0u; number < block.blocks; number++) {
        let word = partial_word(block.first_partial + number, at.lane);
        if word + 4u > arrayLength(&seen) {
            break;
        }
        let partial = vec4<u32>(seen[word], seen[word + 1u], seen[word + 2u], seen[word + 3u]);
        // The block's own nodes go before those of earlier blocks.
        if partial.w != NONE {
            append_nodes(&best, partial.w);
        }
        let key = bitcast<f32>(partial.y);
        let error = bitcast<f32>(partial.z);
        if partial.x != NONE && offer(&best, partial.x, key, error, true) {
            leave_undecided(&best, partial.x, key + error, true);
        }
    }
    write_seen(best, front);
}

fn append_nodes(best: ptr<function, Best>, first: u32) {
    let rest = (*best).node;
    (*best).node = first;
    if rest == NONE {
        return;
    }
    var last = first;
    while atomicLoad(&nodes[NODES_FIRST + last * NODE_WORDS + NODE_NEXT]) != NONE {
        last = atomicLoad(&nodes[NODES_FIRST + last * NODE_WORDS + NODE_NEXT]);
    }
    atomicStore(&nodes[NODES_FIRST + last * NODE_WORDS + NODE_NEXT], rest);
}

// Writes the dispatch sizes for settling nodes and pixels. They are zero if there was too little room: lists may be
// broken then, and the frame is rendered again.
@compute @workgroup_size(1)
fn size_settle() {
    let count = atomicLoad(&nodes[NODES_COUNT]);
    let pixels = atomicLoad(&nodes[NODES_PIXELS]);
    let is_whole = count < arrayLength(&nodes) / NODE_WORDS && pixels <= node_pixel_room(count, arrayLength(&nodes));
    let of_nodes = groups_of(select(0u, (count + 63u) / 64u, is_whole));
    let of_pixels = groups_of(select(0u, (pixels + 63u) / 64u, is_whole));
    for (var axis = 0u; axis < 3u; axis++) {
        atomicStore(&nodes[NODES_GROUPS + axis], of_nodes[axis]);
        atomicStore(&nodes[NODES_PIXEL_GROUPS + axis], of_pixels[axis]);
    }
}
