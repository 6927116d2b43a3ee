// Stage `settle` of a light: decides undecided pairs by the predicate. Each invocation has a pair.

import package::dispatch::{Invocation, flat_index};
import package::exact::corners::{corner_bits};
import package::exact::expansion::{ExpansionTerms};
import package::exact::predicate::{ExactEdges, exact_barycentric, exact_is_front};
import package::exact::shadow::{exact_blocked_by, exact_shadow};
import package::light::light::{Light};
import package::light::points::{UNDECIDED_COUNT, UNDECIDED_FIRST, UNDECIDED_PAGE, UNDECIDED_PAGE_TRIANGLES};
import package::light::seen_point::{seen_point};
import package::mask::exact::{is_there_exactly};
import package::mask::flags::{TRIANGLE_ONE_SIDED, TRIANGLE_SHADOWLESS, TRIANGLE_SHADOW_MASKED};
import package::point_view::{PointView};

@group(0) @binding(0) var<uniform> light: Light;
@group(0) @binding(1) var<uniform> point_view: PointView;
@group(0) @binding(2) var<storage, read> triangles: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read> positions: array<u32>;
@group(0) @binding(4) var<storage, read> seen: array<u32>;
@group(0) @binding(5) var<storage, read> undecided: array<u32>;
@group(0) @binding(6) var<storage, read_write> lit: array<atomic<u32>>;
@group(0) @binding(7) var<storage, read> masks: array<u32>;

@compute @workgroup_size(64)
fn settle(at: Invocation) {
    let number = flat_index(at, 64u);
    let word = UNDECIDED_FIRST + 2u * number;
    if number >= undecided[UNDECIDED_COUNT] || word + 2u > arrayLength(&undecided) {
        return;
    }
    let slot = undecided[word];
    let mask = light.mask + slot / 32u;
    let bit = 1u << (slot & 31u);
    if (atomicLoad(&lit[mask]) & bit) == 0u {
        return;
    }
    var terms: ExpansionTerms;
    let own = seen[slot];
    let point = seen_point(slot, own);
    let shadow = exact_shadow(light.is_directional == 1u, bitcast<vec3<u32>>(light.vector), point);

    var first = undecided[word + 1u];
    var end = first + 1u;
    if (first & UNDECIDED_PAGE) != 0u {
        first = (first & ~UNDECIDED_PAGE) * UNDECIDED_PAGE_TRIANGLES;
        end = min(first + UNDECIDED_PAGE_TRIANGLES, light.triangles);
    }
    for (var id = first; id < end; id++) {
        var edges: ExactEdges;
        let is_whole = all(triangles[id].xyz < vec3<u32>(light.vertices));
        if id == own || !is_whole || (triangles[id].w & TRIANGLE_SHADOWLESS) != 0u
            || !exact_blocked_by(&terms, shadow, corner_bits(id), &edges) {
            continue;
        }
        // A ray from the point meets the side that faces away from the light.
        if (triangles[id].w & TRIANGLE_ONE_SIDED) != 0u && exact_is_front(edges) == shadow.from_point {
            continue;
        }
        if (triangles[id].w & TRIANGLE_SHADOW_MASKED) == 0u
            || is_there_exactly(triangles[id], exact_barycentric(edges), true) {
            atomicAnd(&lit[mask], ~bit);
            return;
        }
    }
}
