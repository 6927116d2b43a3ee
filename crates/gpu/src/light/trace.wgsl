// Stage `trace` of a light: which points have a triangle before them.
//
// A workgroup has a block: up to 64 points of a cell, one each, and triangles that it takes in batches through workgroup
// memory. What the filter leaves undecided is noted for `settle`.

import package::dispatch::{flat_group, groups_of};
import package::grid::set_up::{U, corner_error, corners_of, edges_near, shows_back};
import package::grid::space::{Raster, Space, VERTEX_REGULAR, power_of_two};
import package::light::blocks::{LIGHT_BLOCKS_FIRST, LIGHT_BLOCK_WORDS};
import package::light::cells::{BIN_FRACTION_BITS, BIN_UNIT};
import package::light::light::{Light};
import package::light::points::{UNDECIDED_COUNT, UNDECIDED_FIRST, UNDECIDED_GROUPS};
import package::mask::filter::{MASK_THERE, MASK_UNDECIDED, mask_filter, rough_point};
import package::mask::flags::{TRIANGLE_ONE_SIDED, TRIANGLE_SHADOW_MASKED};

@group(0) @binding(0) var<uniform> light: Light;
@group(0) @binding(1) var<uniform> spaces: array<Space, 6>;
@group(0) @binding(2) var<storage, read> triangles: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read> vertices: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read> sorted: array<vec4<u32>>;
@group(0) @binding(5) var<storage, read> pairs: array<u32>;
@group(0) @binding(6) var<storage, read> blocks: array<u32>;
@group(0) @binding(7) var<storage, read_write> lit: array<atomic<u32>>;
@group(0) @binding(8) var<storage, read_write> undecided: array<atomic<u32>>;
@group(0) @binding(9) var<storage, read> masks: array<u32>;

const BATCH: u32 = 64u;

var<workgroup> record_a: array<vec4<f32>, BATCH>;
var<workgroup> record_b: array<vec4<f32>, BATCH>;
var<workgroup> record_c: array<vec3<f32>, BATCH>;
var<workgroup> record_d: array<vec3<f32>, BATCH>;
// An id is no number: the bits of a small one would be taken for zero.
var<workgroup> record_id: array<u32, BATCH>;
// The middle of where a triangle is in the cell, and how far that reaches, in fixed-point.
var<workgroup> record_box: array<vec4<i32>, BATCH>;
var<workgroup> still_lit: atomic<u32>;
var<workgroup> goes_on: u32;

struct Point {
    // In fixed-point.
    position: vec2<i32>,
    key: f32,
    key_error: f32,
    // The triangle that it is on.
    own: u32,
    pixel: u32,
}

fn record(slot: u32, id: u32, face: u32, cell_low: vec2<i32>, cell_high: vec2<i32>, raster: Raster) {
    let triangle = triangles[id].xyz;
    let base = face * light.vertices;
    let corners = corners_of(vertices[base + triangle.x], vertices[base + triangle.y], vertices[base + triangle.z]);
    var low = cell_low;
    var high = cell_high;
    if corners.kind == VERTEX_REGULAR {
        let a = bitcast<vec2<i32>>(corners.a.xy);
        let b = bitcast<vec2<i32>>(corners.b.xy);
        let c = bitcast<vec2<i32>>(corners.c.xy);
        let error = i32(corner_error(corners, raster));
        low = max(low, min(min(a, b), c) - error);
        high = max(min(high, max(max(a, b), c) + error), low);
    }
    let middle = low + (high - low) / 2;
    // Empty where the triangle is beside the cell, or shows a side that isn't there.
    let half = select(vec2<i32>(-1), high - middle, all(high > low));
    let reach = f32(max(half.x, half.y)) * power_of_two(-i32(raster.fraction_bits));
    let edges = edges_near(corners, middle, max(reach, 0.0), raster);
    let is_gone = (triangles[id].w & TRIANGLE_ONE_SIDED) != 0u && shows_back(edges, raster);
    // The sign of the error tells whether the triangle's winding is certain.
    record_a[slot] = vec4<f32>(edges.a, select(-edges.edge_error, edges.edge_error, edges.is_oriented));
    record_b[slot] = vec4<f32>(edges.b, edges.key_error);
    record_c[slot] = edges.c;
    record_d[slot] = edges.key;
    record_id[slot] = id;
    record_box[slot] = vec4<i32>(middle, select(half, vec2<i32>(-1), is_gone));
}

fn offset_in_record(slot: u32, point: Point) -> vec2<f32> {
    return vec2<f32>(point.position - record_box[slot].xy) * BIN_UNIT;
}

fn edges_at(slot: u32, p: vec2<f32>) -> vec3<f32> {
    return record_a[slot].xyz * p.x + record_b[slot].xyz * p.y + record_c[slot];
}

fn key_at(slot: u32, p: vec2<f32>) -> f32 {
    return record_d[slot].x * p.x + record_d[slot].y * p.y + record_d[slot].z;
}

// Whether a triangle may be before a point.
fn may_shadow(slot: u32, point: Point) -> bool {
    let p = offset_in_record(slot, point);
    let is_in_box = all(abs(point.position - record_box[slot].xy) <= record_box[slot].zw);
    let edge = edges_at(slot, p);
    let error = record_a[slot].w;
    let is_beside = min(min(edge.x, edge.y), edge.z) < -abs(error)
        && (error > 0.0 || max(max(edge.x, edge.y), edge.z) > abs(error));
    let is_behind = key_at(slot, p) + record_b[slot].w < point.key - point.key_error;
    return is_in_box && !is_beside && !is_behind && record_id[slot] != point.own;
}

fn does_shadow(slot: u32, point: Point) -> bool {
    let p = offset_in_record(slot, point);
    let edge = edges_at(slot, p);
    let is_before = key_at(slot, p) - record_b[slot].w > point.key + point.key_error;
    return min(min(edge.x, edge.y), edge.z) > record_a[slot].w && record_a[slot].w > 0.0 && is_before;
}

// Whether the point is in shadow for certain, as far as these triangles go.
fn test_batch(point: Point, count: u32, face: u32) -> bool {
    for (var start = 0u; start < count; start += 32u) {
        // First which may be before it: the rest runs only where some point of a few has one.
        var candidates = 0u;
        for (var i = 0u; i < min(count - start, 32u); i++) {
            candidates |= u32(may_shadow(start + i, point)) << i;
        }
        while candidates != 0u {
            let slot = start + firstTrailingBit(candidates);
            candidates &= candidates - 1u;
            let id = record_id[slot];
            let is_certain = does_shadow(slot, point);
            var answer = select(MASK_UNDECIDED, MASK_THERE, is_certain);
            // A loop of one turn at most: software adapters skip it where no point needs it.
            var is_masked = is_certain && (triangles[id].w & TRIANGLE_SHADOW_MASKED) != 0u;
            while is_masked {
                let edge = edges_at(slot, offset_in_record(slot, point));
                let corners = triangles[id].xyz + face * light.vertices;
                let on_triangle = rough_point(corners, edge, record_a[slot].w, light.is_directional == 1u);
                answer = mask_filter(triangles[id], on_triangle, true);
                is_masked = false;
            }
            if answer == MASK_THERE {
                return true;
            }
            if answer == MASK_UNDECIDED {
                leave_undecided(point.pixel, id);
            }
        }
    }
    return false;
}

fn leave_undecided(pixel: u32, id: u32) {
    let word = UNDECIDED_FIRST + 2u * atomicAdd(&undecided[UNDECIDED_COUNT], 1u);
    if word + 2u <= arrayLength(&undecided) {
        atomicStore(&undecided[word], pixel);
        atomicStore(&undecided[word + 1u], id);
    }
}

@compute @workgroup_size(64)
fn trace(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let block = flat_group(group);
    if block >= blocks[0] {
        return;
    }
    let entry = LIGHT_BLOCKS_FIRST + block * LIGHT_BLOCK_WORDS;
    let face = blocks[entry];
    let first_pair = blocks[entry + 3u];
    let end_pair = min(blocks[entry + 4u], arrayLength(&pairs));
    let raster = spaces[face].raster;
    let low = vec2<i32>(i32(blocks[entry + 5u]), i32(blocks[entry + 6u])) << vec2<u32>(BIN_FRACTION_BITS);
    let high = vec2<i32>(i32(blocks[entry + 7u]), i32(blocks[entry + 8u])) << vec2<u32>(BIN_FRACTION_BITS);

    let number = blocks[entry + 1u] + lane;
    var is_dark = number >= blocks[entry + 2u];
    var point = Point(vec2<i32>(0), 0.0, 0.0, 0u, 0u);
    if !is_dark {
        let found = sorted[number];
        let key = bitcast<f32>(found.z);
        let own = sorted[light.slots + number / 4u][number & 3u];
        let key_error = 4.0 * U * abs(key) + raster.depth_error;
        point = Point(bitcast<vec2<i32>>(found.xy), key, key_error, own, found.w);
        is_dark = ((atomicLoad(&lit[light.mask + point.pixel / 32u]) >> (point.pixel & 31u)) & 1u) == 0u;
    }
    for (var first = first_pair; first < end_pair; first += BATCH) {
        if first + lane < end_pair {
            record(lane, pairs[first + lane], face, low, high, raster);
        }
        if lane == 0u {
            atomicStore(&still_lit, 0u);
        }
        workgroupBarrier();
        if !is_dark {
            is_dark = test_batch(point, min(end_pair - first, BATCH), face);
            if is_dark {
                atomicAnd(&lit[light.mask + point.pixel / 32u], ~(1u << (point.pixel & 31u)));
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

// The size of the dispatch that settles what is undecided.
@compute @workgroup_size(1)
fn size_settle() {
    let room = (arrayLength(&undecided) - UNDECIDED_FIRST) / 2u;
    let groups = groups_of((min(atomicLoad(&undecided[UNDECIDED_COUNT]), room) + 63u) / 64u);
    atomicStore(&undecided[UNDECIDED_GROUPS], groups.x);
    atomicStore(&undecided[UNDECIDED_GROUPS + 1u], groups.y);
    atomicStore(&undecided[UNDECIDED_GROUPS + 2u], groups.z);
}
