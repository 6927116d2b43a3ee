// Stage `trace` of a light: which points have a triangle before them.
//
// A workgroup has a block: up to 64 points of a cell, one each, and triangles that it takes in batches through workgroup
// memory. What the filter leaves open is noted for `settle`.

import package::dispatch::{flat_group, groups_of};
import package::grid::set_up::{edges_near};
import package::grid::space::{Space};
import package::light::blocks::{LIGHT_BLOCK_POINTS};
import package::light::light::{Light};
import package::light::points::{OPEN_COUNT};

@group(0) @binding(0) var<uniform> light: Light;
@group(0) @binding(1) var<uniform> spaces: array<Space, 6>;
@group(0) @binding(2) var<storage, read> triangles: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read> vertices: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read> sorted: array<vec4<u32>>;
@group(0) @binding(5) var<storage, read> pairs: array<u32>;
@group(0) @binding(6) var<storage, read> blocks: array<u32>;
@group(0) @binding(7) var<storage, read> seen: array<u32>;
@group(0) @binding(8) var<storage, read_write> lit: array<atomic<u32>>;
@group(0) @binding(9) var<storage, read_write> open: array<atomic<u32>>;

const BATCH: u32 = 64u;

var<workgroup> record_a: array<vec4<f32>, BATCH>;
var<workgroup> record_b: array<vec4<f32>, BATCH>;
var<workgroup> record_c: array<vec4<f32>, BATCH>;
var<workgroup> record_d: array<vec4<f32>, BATCH>;
var<workgroup> still_lit: atomic<u32>;
var<workgroup> goes_on: u32;

// A point in relation to the middle of its cell.
struct Point {
    position: vec2<f32>,
    key: f32,
    key_error: f32,
    // The triangle that it is on.
    own: u32,
    place: u32,
}

fn record(slot: u32, id: u32, face: u32, middle: vec2<i32>, raster: Raster) {
    let triangle = triangles[id].xyz;
    let base = face * light.vertices;
    let corners = corners_of(vertices[base + triangle.x], vertices[base + triangle.y], vertices[base + triangle.z]);
    let edges = edges_near(corners, middle, 0.5, raster);
    // The sign of the error tells whether the triangle's winding is certain.
    record_a[slot] = vec4<f32>(edges.a, select(-edges.edge_error, edges.edge_error, edges.is_oriented));
    record_b[slot] = vec4<f32>(edges.b, edges.key_error);
    record_c[slot] = vec4<f32>(edges.c, bitcast<f32>(id));
    record_d[slot] = vec4<f32>(edges.key, 0.0);
}

fn edges_at(slot: u32, p: vec2<f32>) -> vec3<f32> {
    return record_a[slot].xyz * p.x + record_b[slot].xyz * p.y + record_c[slot].xyz;
}

fn key_at(slot: u32, p: vec2<f32>) -> f32 {
    return record_d[slot].x * p.x + record_d[slot].y * p.y + record_d[slot].z;
}

// Whether a triangle may be before a point.
fn may_shadow(slot: u32, point: Point) -> bool {
    let edge = edges_at(slot, point.position);
    let error = record_a[slot].w;
    let is_beside = min(min(edge.x, edge.y), edge.z) < -abs(error)
        && (error > 0.0 || max(max(edge.x, edge.y), edge.z) > abs(error));
    let is_behind = key_at(slot, point.position) + record_b[slot].w < point.key - point.key_error;
    return !is_beside && !is_behind && bitcast<u32>(record_c[slot].w) != point.own;
}

fn does_shadow(slot: u32, point: Point) -> bool {
    let edge = edges_at(slot, point.position);
    let is_before = key_at(slot, point.position) - record_b[slot].w > point.key + point.key_error;
    return min(min(edge.x, edge.y), edge.z) > record_a[slot].w && record_a[slot].w > 0.0 && is_before;
}

// Whether the point is in shadow for certain, as far as these triangles go.
fn test_batch(point: Point, count: u32) -> bool {
    for (var start = 0u; start < count; start += 32u) {
        // First which may be before it: the rest runs only where some point of a few has one.
        var candidates = 0u;
        for (var i = 0u; i < min(count - start, 32u); i++) {
            candidates |= u32(may_shadow(start + i, point)) << i;
        }
        while candidates != 0u {
            let slot = start + firstTrailingBit(candidates);
            candidates &= candidates - 1u;
            if does_shadow(slot, point) {
                return true;
            }
            leave_open(point.place, bitcast<u32>(record_c[slot].w));
        }
    }
    return false;
}

fn leave_open(place: u32, id: u32) {
    let word = OPEN_FIRST + 2u * atomicAdd(&open[OPEN_COUNT], 1u);
    if word + 2u <= arrayLength(&open) {
        atomicStore(&open[word], place);
        atomicStore(&open[word + 1u], id);
    }
}

@compute @workgroup_size(64)
fn trace(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let block = flat_group(group, groups);
    if block >= blocks[0] {
        return;
    }
    let entry = LIGHT_BLOCKS_FIRST + block * LIGHT_BLOCK_WORDS;
    let cell = blocks[entry];
    let first_pair = blocks[entry + 3u];
    let end_pair = min(blocks[entry + 4u], arrayLength(&pairs));
    let side = u32(spaces[0].raster.columns);
    let face = cell / (side * side);
    let raster = spaces[face].raster;
    let in_face = cell - face * side * side;
    let column_and_row = vec2<i32>(vec2<u32>(in_face % side, in_face / side));
    let middle = (column_and_row << vec2<u32>(raster.fraction_bits)) + (1 << (raster.fraction_bits - 1u));

    let number = blocks[entry + 1u] + lane;
    var is_dark = number >= blocks[entry + 2u];
    var point = Point(vec2<f32>(0.0), 0.0, 0.0, 0u, 0u);
    if !is_dark {
        let found = sorted[number];
        let unit = exp2(-f32(raster.fraction_bits));
        let key = bitcast<f32>(found.z);
        point = Point(
            vec2<f32>(bitcast<vec2<i32>>(found.xy) - middle) * unit, key, 4.0 * U * abs(key), seen[found.w], found.w);
        is_dark = (atomicLoad(&lit[light.mask + point.place / 32u]) >> (point.place & 31u) & 1u) == 0u;
    }
    for (var first = first_pair; first < end_pair; first += BATCH) {
        if first + lane < end_pair {
            record(lane, pairs[first + lane], face, middle, raster);
        }
        if lane == 0u {
            atomicStore(&still_lit, 0u);
        }
        workgroupBarrier();
        if !is_dark {
            is_dark = test_batch(point, min(end_pair - first, BATCH));
            if is_dark {
                atomicAnd(&lit[light.mask + point.place / 32u], ~(1u << (point.place & 31u)));
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

// The size of the dispatch that settles what is open.
@compute @workgroup_size(1)
fn size_settle() {
    let room = (arrayLength(&open) - OPEN_FIRST) / 2u;
    let groups = groups_of((min(atomicLoad(&open[OPEN_COUNT]), room) + 63u) / 64u);
    atomicStore(&open[OPEN_GROUPS], groups.x);
    atomicStore(&open[OPEN_GROUPS + 1u], groups.y);
    atomicStore(&open[OPEN_GROUPS + 2u], groups.z);
}
