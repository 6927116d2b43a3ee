// Stage `rays`: makes the camera's rays, one for each slot, so that the rays of a tile's blocks are neighbours.

import package::dispatch::{Invocation, flat_index};
import package::exact::corners::{corner_bits};
import package::exact::double::{F64, F64_ZERO};
import package::exact::expansion::{ExpansionTerms};
import package::exact::predicate::{exact_edges, exact_t};
import package::rays::records::{
    NO_TRIANGLE, RAY_DIRECTION, RAY_ERROR, RAY_T_MAX, RAY_T_MIN, RECORD_LANES, RECORD_OWN, RECORD_TAG, record_start,
};
import package::rays::write::{put_header, put_number, put_vector};
import package::point_view::{PointView, ray_of_slot};
import package::tile_order::{pixel_of_slot};

struct KdRays {
    // Rays of a packet.
    packet: u32,
    // Whether rays start behind the triangles of `front`.
    sees_behind: u32,
}

@group(0) @binding(0) var<uniform> point_view: PointView;
@group(0) @binding(1) var<uniform> kd_rays: KdRays;
@group(0) @binding(2) var<storage, read> triangles: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read> positions: array<u32>;
// The triangle that each slot has shown before.
@group(0) @binding(4) var<storage, read> front: array<u32>;
@group(0) @binding(5) var<storage, read_write> records: array<u32>;

const RAYS_ONE = F64(0u, 0x3ff00000u);
const RAYS_INFINITE = F64(0u, 0x7ff00000u);

@compute @workgroup_size(64)
fn rays(at: Invocation) {
    let slot = flat_index(at, RECORD_LANES);
    if slot == 0u {
        put_header(point_view.slots, kd_rays.packet);
    }
    if slot >= point_view.slots {
        return;
    }
    let size = vec2<u32>(point_view.view.width, point_view.rows);
    let ray = ray_of_slot(slot);
    var is_asked = all(pixel_of_slot(slot, size.x) < size);
    var t_min = F64_ZERO;
    if is_asked && kd_rays.sees_behind != 0u {
        let id = front[slot];
        is_asked = id != NO_TRIANGLE;
        if is_asked {
            var terms: ExpansionTerms;
            t_min = exact_t(&terms, ray, exact_edges(&terms, ray, corner_bits(id)));
        }
    }
    let word = record_start(slot);
    put_vector(word, ray.origin);
    put_vector(word + RAY_DIRECTION, ray.direction);
    // A slot without a ray gets an empty interval.
    if is_asked {
        put_number(word + RAY_T_MIN, t_min);
        put_number(word + RAY_T_MAX, RAYS_INFINITE);
    } else {
        put_number(word + RAY_T_MIN, RAYS_ONE);
        put_number(word + RAY_T_MAX, F64_ZERO);
    }
    put_number(word + RAY_ERROR, F64_ZERO);
    records[word + RECORD_OWN] = NO_TRIANGLE;
    records[word + RECORD_TAG] = slot;
}
