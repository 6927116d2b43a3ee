// Stage `ask`: for each slot that shows something in a light's reach, whether anything is between.

import package::dispatch::{Invocation, flat_index};
import package::exact::cone::{exact_is_in_cone};
import package::exact::double::{F64};
import package::exact::shadow::{exact_point};
import package::kdtree::light::{KdLight};
import package::kdtree::records::{
    HIT_WORDS, NO_TRIANGLE, RECORD_LANES, RECORD_OWN, RECORD_TAG, SHADOW_ERROR, SHADOW_IS_DIRECTIONAL, SHADOW_LIGHT,
    record_start,
};
import package::kdtree::write::{put_header, put_number, put_vector};
import package::point_view::{PointView, ray_of_slot};

@group(0) @binding(0) var<uniform> kd_light: KdLight;
@group(0) @binding(1) var<uniform> point_view: PointView;
@group(0) @binding(2) var<storage, read> hits: array<u32>;
@group(0) @binding(3) var<storage, read_write> records: array<u32>;

@compute @workgroup_size(64)
fn ask(at: Invocation) {
    let slot = flat_index(at, RECORD_LANES);
    if slot == 0u {
        put_header(point_view.slots, kd_light.packet);
    }
    if slot >= point_view.slots {
        return;
    }
    let word = record_start(slot);
    let id = hits[slot * HIT_WORDS];
    records[word + RECORD_OWN] = id;
    records[word + RECORD_TAG] = NO_TRIANGLE;
    if id == NO_TRIANGLE {
        return;
    }
    let t = F64(hits[slot * HIT_WORDS + 2u], hits[slot * HIT_WORDS + 3u]);
    let point = exact_point(ray_of_slot(slot), t);
    if kd_light.has_cone != 0u
        && !exact_is_in_cone(point.position, kd_light.vector, kd_light.axis, kd_light.squared_cosine) {
        return;
    }
    put_vector(word, point.position);
    put_number(word + SHADOW_ERROR, point.error);
    for (var axis = 0u; axis < 3u; axis++) {
        records[word + SHADOW_LIGHT + axis] = kd_light.vector[axis];
    }
    records[word + SHADOW_IS_DIRECTIONAL] = kd_light.is_directional;
    records[word + RECORD_TAG] = slot;
}
