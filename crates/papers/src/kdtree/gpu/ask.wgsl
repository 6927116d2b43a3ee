// Stage `ask`: for each slot whose hit is in a light's reach, asks whether a triangle is between the hit and the light.

import package::dispatch::{Invocation, flat_index};
import package::exact::double::{F64};
import package::exact::shadow::{exact_point};
import package::rays::light::{ShadowLight};
import package::rays::question::{put_no_question, put_question};
import package::rays::records::{HIT_WORDS, NO_TRIANGLE, RECORD_LANES, record_start};
import package::rays::write::{put_header};
import package::point_view::{PointView, ray_of_slot};

@group(0) @binding(0) var<uniform> shadow_light: ShadowLight;
@group(0) @binding(1) var<uniform> point_view: PointView;
@group(0) @binding(2) var<storage, read> hits: array<u32>;
@group(0) @binding(3) var<storage, read_write> records: array<u32>;

@compute @workgroup_size(64)
fn ask(at: Invocation) {
    let slot = flat_index(at, RECORD_LANES);
    if slot == 0u {
        put_header(point_view.slots, shadow_light.packet);
    }
    if slot >= point_view.slots {
        return;
    }
    let id = hits[slot * HIT_WORDS];
    if id == NO_TRIANGLE {
        put_no_question(record_start(slot));
        return;
    }
    let t = F64(hits[slot * HIT_WORDS + 2u], hits[slot * HIT_WORDS + 3u]);
    put_question(record_start(slot), exact_point(ray_of_slot(slot), t), id, slot);
}
