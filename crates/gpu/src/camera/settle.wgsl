// Stage `settle`: decides by the predicate the hits that `trace` has left undecided. First each invocation takes a
// node, then a pixel: one invocation would take too long for all nodes of a pixel, and lavapipe ends an invocation's
// loops after 65,535 turns.

import package::camera::nodes::{
    NODES_COUNT, NODES_FIRST, NODES_PIXELS, NODE_CERTAIN, NODE_FRONT, NODE_KEY, NODE_NEXT, NODE_SLOT, NODE_T,
    NODE_TRIANGLE, NODE_WORDS, NONE,
};
import package::dispatch::{Invocation, flat_index};
import package::exact::corners::{corner_bits};
import package::exact::double::{F64, F64_ZERO, f64_equal, f64_less};
import package::exact::expansion::{ExpansionTerms};
import package::exact::predicate::{exact_barycentric, exact_edges, exact_is_front, exact_t};
import package::mask::exact::{is_there_exactly};
import package::mask::flags::{TRIANGLE_MASKED, TRIANGLE_ONE_SIDED};
import package::point_view::{PointView, ray_of_slot};

@group(0) @binding(0) var<uniform> point_view: PointView;
@group(0) @binding(1) var<storage, read> triangles: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> positions: array<u32>;
@group(0) @binding(3) var<storage, read_write> seen: array<u32>;
@group(0) @binding(4) var<storage, read_write> nodes: array<u32>;
@group(0) @binding(5) var<storage, read> masks: array<u32>;

const F64_INFINITE = F64(0u, 0x7ff00000u);

// Writes t of a node's triangle for its pixel; infinite where the pixel doesn't see it, or certainly sees a nearer one.
@compute @workgroup_size(64)
fn settle_nodes(at: Invocation) {
    let number = flat_index(at, 64u);
    let base = NODES_FIRST + number * NODE_WORDS;
    if number >= nodes[NODES_COUNT] || (nodes[base] & NODE_FRONT) != 0u {
        return;
    }
    let t = seen_at(base);
    nodes[base + NODE_T] = t.x;
    nodes[base + NODE_T + 1u] = t.y;
}

fn seen_at(base: u32) -> F64 {
    let slot = nodes[base + NODE_SLOT];
    let ray = ray_of_slot(slot);
    var terms: ExpansionTerms;

    // The triangle that the pixel has seen already is its first node; one that it certainly sees is the first of the rest.
    let seen_node = NODES_FIRST + seen[slot] * NODE_WORDS;
    let has_front = (nodes[seen_node] & NODE_FRONT) != 0u;
    let next = NODES_FIRST + nodes[seen_node + NODE_NEXT] * NODE_WORDS;
    let first = select(seen_node, next, has_front);
    let is_certain = (nodes[base] & NODE_CERTAIN) != 0u;
    if !is_certain && (nodes[first] & NODE_CERTAIN) != 0u
        && bitcast<f32>(nodes[base + NODE_KEY]) < bitcast<f32>(nodes[first + NODE_KEY]) {
        return F64_INFINITE;
    }
    // First the triangle seen already, if there is one, then the node's own: in one loop, since the predicate compiles
    // slowly.
    var farther_than = F64_ZERO;
    var t = F64_ZERO;
    for (var turn = select(1u, 0u, has_front); turn < 2u; turn++) {
        let id = nodes[select(seen_node, base, turn == 1u)] & NODE_TRIANGLE;
        let edges = exact_edges(&terms, ray, corner_bits(id));
        if turn == 1u {
            if edges.side == 0 || ((triangles[id].w & TRIANGLE_ONE_SIDED) != 0u && !exact_is_front(edges)) {
                return F64_INFINITE;
            }
            if (triangles[id].w & TRIANGLE_MASKED) != 0u
                && !is_there_exactly(triangles[id], exact_barycentric(edges), false) {
                return F64_INFINITE;
            }
        }
        farther_than = t;
        t = exact_t(&terms, ray, edges);
    }
    return select(F64_INFINITE, t, f64_less(farther_than, t));
}

// Writes the triangle that a pixel sees: the nearest of its nodes.
@compute @workgroup_size(64)
fn settle(at: Invocation) {
    let number = flat_index(at, 64u);
    if number >= nodes[NODES_PIXELS] {
        return;
    }
    let slot = nodes[arrayLength(&nodes) - 1u - number];
    var nearest = F64_INFINITE;
    var triangle = NONE;
    var node = seen[slot];
    while node != NONE {
        let base = NODES_FIRST + node * NODE_WORDS;
        node = nodes[base + NODE_NEXT];
        if (nodes[base] & NODE_FRONT) != 0u {
            continue;
        }
        let id = nodes[base] & NODE_TRIANGLE;
        let t = F64(nodes[base + NODE_T], nodes[base + NODE_T + 1u]);
        if f64_less(t, nearest) || (f64_equal(t, nearest) && triangle != NONE && id < triangle) {
            nearest = t;
            triangle = id;
        }
    }
    seen[slot] = triangle;
}
