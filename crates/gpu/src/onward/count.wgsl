// Stage `count`: counts the rays that each ray of a generation spawns. Prefix sums of the counts are their indices, so that
// rays stay in the order of their pixels.

import package::dispatch::{Invocation, flat_index};
import package::onward::step::{NOWHERE, OnwardStep, index_in_planes, way_bits};
import package::onward::way::{way_count};

@group(0) @binding(0) var<uniform> onward_step: OnwardStep;
@group(0) @binding(1) var<storage, read> planes: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read_write> starts: array<u32>;

@compute @workgroup_size(64)
fn count(at: Invocation) {
    let number = flat_index(at, 64u);
    if number >= onward_step.count {
        return;
    }
    let index = index_in_planes(number);
    var rays = 0u;
    if index != NOWHERE {
        rays = way_count(way_bits(index));
    }
    starts[number] = rays;
}
