// Stage `settle`: decides by the predicate what tracing has left open. An invocation has a pixel.

import package::camera::nodes::{NODES_FIRST};
import package::dispatch::{flat_group};
import package::exact::camera::{ExactView, exact_pixel_ray};
import package::exact::predicate::{exact_edges, exact_t, exact_is_front, exact_barycentric};
import package::mask::exact::{is_there_exactly};
import package::tile_order::{pixel_of_place};

struct SettleView {
    view: ExactView,
    // Where samples are in their pixels.
    x_offset: vec2<u32>,
    y_offset: vec2<u32>,
    culls_back_faces: u32,
    // Of the whole image.
    first_row: u32,
}

@group(0) @binding(0) var<uniform> settle_view: SettleView;
@group(0) @binding(1) var<storage, read> triangles: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> positions: array<u32>;
@group(0) @binding(3) var<storage, read_write> seen: array<u32>;
@group(0) @binding(4) var<storage, read> nodes: array<u32>;
@group(0) @binding(5) var<storage, read> masks: array<u32>;

fn position_bits(vertex: u32) -> vec3<u32> {
    return vec3<u32>(positions[3u * vertex], positions[3u * vertex + 1u], positions[3u * vertex + 2u]);
}

fn corner_bits(id: u32) -> CornerBits {
    let corners = triangles[id].xyz;
    return CornerBits(position_bits(corners.x), position_bits(corners.y), position_bits(corners.z));
}

@compute @workgroup_size(64)
fn settle(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let number = flat_group(group, groups) * 64u + lane;
    if number >= nodes[NODES_PIXELS] || number >= node_pixel_room(nodes[NODES_COUNT], arrayLength(&nodes)) {
        return;
    }
    let place = nodes[arrayLength(&nodes) - 1u - number];
    let pixel = pixel_of_place(place, settle_view.view.width);
    let row = pixel.y + settle_view.first_row;
    let ray = exact_pixel_ray(settle_view.view, pixel.x, row, settle_view.x_offset, settle_view.y_offset);

    var terms: ExpansionTerms;
    // What was seen already is the first node.
    var node = seen[place];
    var farther_than = F64_ZERO;
    let front = nodes[NODES_FIRST + node * NODE_WORDS];
    if (front & NODE_FRONT) != 0u {
        farther_than = exact_t(&terms, ray, exact_edges(&terms, ray, corner_bits(front & ~NODE_FRONT)));
        node = nodes[NODES_FIRST + node * NODE_WORDS + 1u];
    }
    var nearest = F64_ZERO;
    // What the nearest hit so far has as its key; others below it by more than any error aren't asked about.
    var nearest_key = 0.0;
    var triangle = NONE;
    while node != NONE {
        let base = NODES_FIRST + node * NODE_WORDS;
        let id = nodes[base];
        let highest_key = bitcast<f32>(nodes[base + 2u]);
        node = nodes[base + 1u];
        if triangle != NONE && highest_key < nearest_key - 1e-5 * abs(nearest_key) {
            continue;
        }
        let edges = exact_edges(&terms, ray, corner_bits(id));
        if edges.side == 0 || (settle_view.culls_back_faces == 1u && !exact_is_front(edges)) {
            continue;
        }
        if (triangles[id].w & TRIANGLE_MASKED) != 0u
            && !is_there_exactly(triangles[id], exact_barycentric(edges), false) {
            continue;
        }
        let t = exact_t(&terms, ray, edges);
        if !f64_less(farther_than, t) {
            continue;
        }
        let is_nearer = f64_less(t, nearest) || (f64_equal(t, nearest) && id < triangle);
        if triangle == NONE || is_nearer {
            nearest = t;
            triangle = id;
            let depth = bitcast<f32>(f64_to_f32_bits(t));
            nearest_key = select(1.0 / depth, -depth, settle_view.view.is_orthographic == 1u);
        }
    }
    seen[place] = triangle;
}
