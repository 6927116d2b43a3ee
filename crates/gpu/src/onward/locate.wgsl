// Stage `locate`: computes the exact hit points of camera rays, and stores the rays if some may go straight on.

import package::dispatch::{Invocation, flat_index};
import package::exact::corners::{corner_bits};
import package::exact::expansion::{ExpansionTerms};
import package::exact::predicate::{exact_edges, exact_t};
import package::exact::shadow::{exact_point};
import package::rays::records::{NO_TRIANGLE, RAY_DIRECTION, record_start};
import package::rays::write::{put_vector};
import package::onward::points::{POINT_TRIANGLE, POINT_WORDS};
import package::onward::put_point::{put_point};
import package::onward::step::{NOWHERE, OnwardStep, index_in_planes, way_bits};
import package::onward::way::{ALL_WAYS};
import package::point_view::{PointView, ray_of_slot};

@group(0) @binding(0) var<uniform> onward_step: OnwardStep;
@group(0) @binding(1) var<uniform> point_view: PointView;
@group(0) @binding(2) var<storage, read> planes: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> seen: array<u32>;
@group(0) @binding(4) var<storage, read> triangles: array<vec4<u32>>;
@group(0) @binding(5) var<storage, read> positions: array<u32>;
@group(0) @binding(6) var<storage, read_write> points: array<u32>;
@group(0) @binding(7) var<storage, read_write> records: array<u32>;

@compute @workgroup_size(64)
fn locate(at: Invocation) {
    let slot = flat_index(at, 64u);
    if slot >= onward_step.count {
        return;
    }
    let pixel = index_in_planes(slot);
    let is_before_shading = onward_step.is_asked_first != 0u;
    var id = NO_TRIANGLE;
    if pixel != NOWHERE {
        // Before shading, every ray may go on.
        if is_before_shading || way_bits(pixel) != 0u {
            id = seen[slot];
        }
    }
    points[slot * POINT_WORDS + POINT_TRIANGLE] = id;
    if id == NO_TRIANGLE {
        return;
    }
    let ray = ray_of_slot(slot);
    var terms: ExpansionTerms;
    let t = exact_t(&terms, ray, exact_edges(&terms, ray, corner_bits(id)));
    put_point(slot, exact_point(ray, t), t, id, pixel);
    if onward_step.ways >= ALL_WAYS {
        let word = record_start(slot);
        put_vector(word, ray.origin);
        put_vector(word + RAY_DIRECTION, ray.direction);
    }
}
