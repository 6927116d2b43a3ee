// Stage `settle`: decides the undecided hits of traversals by the predicate, and finds t of the nearest hits. First
// each invocation takes a listed hit, then a ray: one invocation would take too long for all hits of a ray, and
// lavapipe ends an invocation's loops after 65,535 turns.

import package::dispatch::{Invocation, flat_index, groups_of};
import package::exact::corners::{corner_bits};
import package::exact::double::{F64, f64_equal, f64_is_zero, f64_less, f64_to_f32_bits};
import package::exact::expansion::{ExpansionTerms};
import package::exact::predicate::{ExactEdges, exact_barycentric, exact_edges, exact_is_front, exact_t};
import package::exact::shadow::{ExactPoint, exact_blocked_by, exact_is_on};
import package::exact::vector::{f64_vector_from_f32_bits, f64_vector_subtract};
import package::rays::read::{read_number, read_point, read_ray, read_shadow};
import package::rays::records::{HIT_WORDS, RAY_ERROR, RAY_T_MAX, RAY_T_MIN, RECORDS_COUNT, RECORD_LANES, record_start};
import package::mask::exact::{is_there_exactly};
import package::mask::flags::{TRIANGLE_MASKED, TRIANGLE_ONE_SIDED, TRIANGLE_SHADOW_MASKED};

@group(0) @binding(0) var<storage, read> records: array<u32>;
@group(0) @binding(1) var<storage, read> triangles: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> positions: array<u32>;
@group(0) @binding(3) var<storage, read_write> traced: array<atomic<u32>>;
@group(0) @binding(4) var<storage, read_write> undecided_hits: array<u32>;
@group(0) @binding(5) var<storage, read_write> hits: array<u32>;
@group(0) @binding(6) var<storage, read> masks: array<u32>;

// As in `tester.wgsl`.
const UNDECIDED_COUNT: u32 = 0u;
const UNDECIDED_GROUPS: u32 = 1u;
const UNDECIDED_RAYS: u32 = 5u;
const UNDECIDED_FIRST: u32 = 16u;
const UNDECIDED_WORDS: u32 = 8u;
const NOTHING: u32 = 0xffffffffu;

const SETTLE_INFINITE = F64(0u, 0x7ff00000u);

// Whether rays may start at points of triangles.
override RAY_FROM_TRIANGLES: bool = false;

// Number of listed hits, at most the room for them.
fn undecided_count() -> u32 {
    return min(undecided_hits[UNDECIDED_COUNT], (arrayLength(&undecided_hits) - UNDECIDED_FIRST) / UNDECIDED_WORDS);
}

// Whether a triangle is there at the point of a hit, and on a side that it has.
fn is_there(id: u32, edges: ExactEdges, meets_backs: bool, is_shadow: bool) -> bool {
    let kind = triangles[id].w;
    if (kind & TRIANGLE_ONE_SIDED) != 0u && exact_is_front(edges) == meets_backs {
        return false;
    }
    let is_masked = (kind & select(TRIANGLE_MASKED, TRIANGLE_SHADOW_MASKED, is_shadow)) != 0u;
    return !is_masked || is_there_exactly(triangles[id], exact_barycentric(edges), is_shadow);
}

@compute @workgroup_size(1)
fn size_undecided() {
    let groups = groups_of((undecided_count() + RECORD_LANES - 1u) / RECORD_LANES);
    undecided_hits[UNDECIDED_GROUPS] = groups.x;
    undecided_hits[UNDECIDED_GROUPS + 1u] = groups.y;
    undecided_hits[UNDECIDED_GROUPS + 2u] = groups.z;
    undecided_hits[UNDECIDED_RAYS] = records[RECORDS_COUNT];
}

// t of a listed hit; infinite if the ray misses the triangle, or certainly hits a nearer one.
@compute @workgroup_size(64)
fn settle_hits(at: Invocation) {
    let index = flat_index(at, RECORD_LANES);
    if index >= undecided_count() {
        return;
    }
    let base = UNDECIDED_FIRST + index * UNDECIDED_WORDS;
    let number = undecided_hits[base + 1u];
    var t = SETTLE_INFINITE;
    if bitcast<f32>(undecided_hits[base + 3u]) <= bitcast<f32>(atomicLoad(&traced[4u * number + 2u])) {
        let word = record_start(number);
        let ray = read_ray(word);
        var terms: ExpansionTerms;
        let edges = exact_edges(&terms, ray, corner_bits(undecided_hits[base]));
        var is_hit = edges.side != 0 && is_there(undecided_hits[base], edges, false, false);
        if RAY_FROM_TRIANGLES && is_hit {
            let error = read_number(word + RAY_ERROR);
            let corners = corner_bits(undecided_hits[base]);
            is_hit = f64_is_zero(error) || !exact_is_on(&terms, ExactPoint(ray.origin, error), corners);
        }
        if is_hit {
            let found = exact_t(&terms, ray, edges);
            if f64_less(read_number(word + RAY_T_MIN), found) && f64_less(found, read_number(word + RAY_T_MAX)) {
                t = found;
            }
            let weights = exact_barycentric(edges);
            undecided_hits[base + 6u] = weights.x;
            undecided_hits[base + 7u] = weights.y;
        }
    }
    undecided_hits[base + 4u] = t.x;
    undecided_hits[base + 5u] = t.y;
}

// Writes each ray's nearest hit.
@compute @workgroup_size(64)
fn settle_nearest(at: Invocation) {
    let number = flat_index(at, RECORD_LANES);
    if number >= records[RECORDS_COUNT] {
        return;
    }
    var nearest = NOTHING;
    var t = SETTLE_INFINITE;
    var weights = vec2(0u);
    var next = atomicLoad(&traced[4u * number + 1u]);
    while next < undecided_count() {
        let base = UNDECIDED_FIRST + next * UNDECIDED_WORDS;
        let id = undecided_hits[base];
        let other = F64(undecided_hits[base + 4u], undecided_hits[base + 5u]);
        if f64_less(other, t) || (nearest != NOTHING && f64_equal(other, t) && id < nearest) {
            t = other;
            nearest = id;
            weights = vec2(undecided_hits[base + 6u], undecided_hits[base + 7u]);
        }
        next = undecided_hits[base + 2u];
    }
    let base = number * HIT_WORDS;
    hits[base] = nearest;
    hits[base + 2u] = t.x;
    hits[base + 3u] = t.y;
    hits[base + 4u] = weights.x;
    hits[base + 5u] = weights.y;
}

// Whether the triangle of a listed hit shadows a point.
@compute @workgroup_size(64)
fn settle_blocked(at: Invocation) {
    let index = flat_index(at, RECORD_LANES);
    if index >= undecided_count() {
        return;
    }
    let base = UNDECIDED_FIRST + index * UNDECIDED_WORDS;
    let number = undecided_hits[base + 1u];
    if atomicLoad(&traced[4u * number]) != 0u {
        return;
    }
    let word = record_start(number);
    let shadow = read_shadow(word, read_point(word));
    var terms: ExpansionTerms;
    var edges: ExactEdges;
    let id = undecided_hits[base];
    if exact_blocked_by(&terms, shadow, corner_bits(id), &edges) && is_there(id, edges, shadow.from_point, true) {
        atomicOr(&traced[4u * number], 1u);
    }
}

// For a listed hit on the way of light to a point: whether light passes through the triangle, the weights of the
// crossing, and its distance from the point, negative if the back is on the light's side.
@compute @workgroup_size(64)
fn settle_passed(at: Invocation) {
    let index = flat_index(at, RECORD_LANES);
    if index >= undecided_count() {
        return;
    }
    let base = UNDECIDED_FIRST + index * UNDECIDED_WORDS;
    let word = record_start(undecided_hits[base + 1u]);
    let shadow = read_shadow(word, read_point(word));
    var terms: ExpansionTerms;
    var edges: ExactEdges;
    let id = undecided_hits[base];
    let corners = corner_bits(id);
    undecided_hits[base + 4u] = 0u;
    if !exact_blocked_by(&terms, shadow, corners, &edges) {
        return;
    }
    // As seen from the light.
    let is_front = exact_is_front(edges) != shadow.from_point;
    if !is_front && (triangles[id].w & TRIANGLE_ONE_SIDED) != 0u {
        return;
    }
    let weights = exact_barycentric(edges);
    let a = bitcast<vec3<f32>>(corners.a);
    let to_second = bitcast<vec3<f32>>(corners.b) - a;
    let to_third = bitcast<vec3<f32>>(corners.c) - a;
    let from_point = f64_vector_subtract(f64_vector_from_f32_bits(corners.a), shadow.point.position);
    let first = bitcast<vec3<f32>>(
        vec3<u32>(f64_to_f32_bits(from_point.x), f64_to_f32_bits(from_point.y), f64_to_f32_bits(from_point.z)),
    );
    let crossing = first + to_second * bitcast<f32>(weights.x) + to_third * bitcast<f32>(weights.y);
    undecided_hits[base + 4u] = 1u;
    undecided_hits[base + 5u] = bitcast<u32>(select(-1.0, 1.0, is_front) * length(crossing));
    undecided_hits[base + 6u] = weights.x;
    undecided_hits[base + 7u] = weights.y;
}
