// Stage `trace` of a light with faces: finds points that triangles shadow, by edge functions and keys near the
// triangle's part of a cell.

import package::grid::set_up::{U, corner_error, corners_of, edges_near, shows_back};
import package::grid::space::{Space, VERTEX_REGULAR, power_of_two};
import package::light::batches::{BATCH, trace_block};
import package::light::cells::{BIN_FRACTION_BITS, BIN_UNIT};
import package::light::light::{Light};
import package::light::undecided::{write_settle_groups};
import package::mask::filter::{RoughPoint};
import package::mask::flags::{TRIANGLE_ONE_SIDED};
import package::mask::rough_point::{rough_point};

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

var<workgroup> record_a: array<vec4<f32>, BATCH>;
var<workgroup> record_b: array<vec4<f32>, BATCH>;
var<workgroup> record_c: array<vec3<f32>, BATCH>;
var<workgroup> record_d: array<vec3<f32>, BATCH>;
// The middle of the triangle's bounds in the cell, and their half extents, in fixed-point.
var<workgroup> record_box: array<vec4<i32>, BATCH>;

// In fixed-point.
struct Cell {
    face: u32,
    low: vec2<i32>,
    high: vec2<i32>,
}

struct Point {
    // In fixed-point.
    position: vec2<i32>,
    key: f32,
    key_error: f32,
    own: u32,
}

fn cell_of_block(entry: u32) -> Cell {
    let low = vec2<i32>(i32(blocks[entry + 5u]), i32(blocks[entry + 6u])) << vec2<u32>(BIN_FRACTION_BITS);
    let high = vec2<i32>(i32(blocks[entry + 7u]), i32(blocks[entry + 8u])) << vec2<u32>(BIN_FRACTION_BITS);
    return Cell(blocks[entry], low, high);
}

fn point_at(number: u32, own: u32, cell: Cell) -> Point {
    let found = sorted[number];
    let key = bitcast<f32>(found.z);
    let key_error = 4.0 * U * abs(key) + spaces[cell.face].raster.depth_error;
    return Point(bitcast<vec2<i32>>(found.xy), key, key_error, own);
}

fn record(slot: u32, id: u32, cell: Cell) {
    let raster = spaces[cell.face].raster;
    let triangle = triangles[id].xyz;
    let base = cell.face * light.vertices;
    let corners = corners_of(vertices[base + triangle.x], vertices[base + triangle.y], vertices[base + triangle.z]);
    var low = cell.low;
    var high = cell.high;
    if corners.kind == VERTEX_REGULAR {
        let a = bitcast<vec2<i32>>(corners.a.xy);
        let b = bitcast<vec2<i32>>(corners.b.xy);
        let c = bitcast<vec2<i32>>(corners.c.xy);
        let error = i32(corner_error(corners, raster));
        low = max(low, min(min(a, b), c) - error);
        high = max(min(high, max(max(a, b), c) + error), low);
    }
    let middle = low + (high - low) / 2;
    // Empty if the triangle is beside the cell, or shows a side that it doesn't have.
    let half = select(vec2<i32>(-1), high - middle, all(high > low));
    let reach = f32(max(half.x, half.y)) * power_of_two(-i32(raster.fraction_bits));
    let edges = edges_near(corners, middle, max(reach, 0.0), raster);
    let is_gone = (triangles[id].w & TRIANGLE_ONE_SIDED) != 0u && shows_back(edges, raster);
    // The error is negative where the triangle's winding is uncertain.
    record_a[slot] = vec4<f32>(edges.a, select(-edges.edge_error, edges.edge_error, edges.is_oriented));
    record_b[slot] = vec4<f32>(edges.b, edges.key_error);
    record_c[slot] = edges.c;
    record_d[slot] = edges.key;
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

// Whether a triangle may shadow a point.
fn may_shadow(slot: u32, point: Point) -> bool {
    let p = offset_in_record(slot, point);
    let is_in_box = all(abs(point.position - record_box[slot].xy) <= record_box[slot].zw);
    let edge = edges_at(slot, p);
    let error = record_a[slot].w;
    let is_beside = min(min(edge.x, edge.y), edge.z) < -abs(error)
        && (error > 0.0 || max(max(edge.x, edge.y), edge.z) > abs(error));
    let is_behind = key_at(slot, p) + record_b[slot].w < point.key - point.key_error;
    return is_in_box && !is_beside && !is_behind;
}

fn does_shadow(slot: u32, point: Point) -> bool {
    let p = offset_in_record(slot, point);
    let edge = edges_at(slot, p);
    let is_before = key_at(slot, p) - record_b[slot].w > point.key + point.key_error;
    return min(min(edge.x, edge.y), edge.z) > record_a[slot].w && record_a[slot].w > 0.0 && is_before;
}

// The point where the shadow ray meets a triangle.
fn point_on(slot: u32, id: u32, point: Point, cell: Cell) -> RoughPoint {
    let edges = edges_at(slot, offset_in_record(slot, point));
    let corners = triangles[id].xyz + cell.face * light.vertices;
    return rough_point(corners, edges, record_a[slot].w, light.is_directional == 1u);
}

@compute @workgroup_size(64)
fn trace(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    trace_block(group, lane);
}

// Writes the size of the dispatch that settles undecided pairs.
@compute @workgroup_size(1)
fn size_settle() {
    write_settle_groups();
}
