// Stage `locate`: where the camera's rays go on from, of those that do.

import package::dispatch::{Invocation, flat_index};
import package::exact::corners::{corner_bits};
import package::exact::expansion::{ExpansionTerms};
import package::exact::predicate::{exact_edges, exact_t};
import package::exact::shadow::{exact_point};
import package::onward::put_point::{put_point};
import package::onward::step::{NOWHERE, OnwardStep, index_in_planes, second_way};
import package::point_view::{PointView, ray_of_slot};

@group(0) @binding(0) var<uniform> onward_step: OnwardStep;
@group(0) @binding(1) var<uniform> point_view: PointView;
@group(0) @binding(2) var<storage, read> planes: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> seen: array<u32>;
@group(0) @binding(4) var<storage, read> triangles: array<vec4<u32>>;
@group(0) @binding(5) var<storage, read> positions: array<u32>;
@group(0) @binding(6) var<storage, read_write> points: array<u32>;

@compute @workgroup_size(64)
fn locate(at: Invocation) {
    let slot = flat_index(at, 64u);
    if slot >= onward_step.count {
        return;
    }
    let pixel = index_in_planes(slot);
    if pixel == NOWHERE {
        return;
    }
    if planes[second_way(pixel)].w > 0.0 {
        let ray = ray_of_slot(slot);
        let id = seen[slot];
        var terms: ExpansionTerms;
        let t = exact_t(&terms, ray, exact_edges(&terms, ray, corner_bits(id)));
        put_point(slot, exact_point(ray, t), id, pixel);
    }
}
