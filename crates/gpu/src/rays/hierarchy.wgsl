// Stages `nearest` and `blocked` through the hierarchy of the Rust crate's `Bvh`; each invocation has a ray.
//
// The stack has one entry for a level at most, so its depth is that of the hierarchy, which is bounded for any input. An
// entry is a node, and a bit for each of its children that the ray meets and hasn't visited. These children's boxes are
// tested again when the ray is back, by the nearest hit that is known then; the child that is entered first comes first.

import package::dispatch::{Invocation, flat_index};
import package::rays::records::{RECORD_LANES};
import package::rays::tester::{
    RAY_BEYOND, RAY_COUNTS, RAY_UNIT, TracedRay, ray_at, ray_count, ray_count_steps, ray_finish, ray_is_missed, ray_test,
};

// A node has two vectors for the lowest x of its eight children's boxes, two for the highest, the same for y and for z,
// all scaled; and two for the children.
@group(0) @binding(1) var<storage, read> hierarchy: array<vec4<u32>>;
// Eight for each leaf.
@group(0) @binding(2) var<storage, read> hierarchy_ids: array<u32>;

const NODE_VECTORS: u32 = 14u;
const NODE_CHILDREN: u32 = 12u;
// A child is a node's index; or, with this bit set, the index of its last id, whose lowest three bits are the number of its
// ids minus one.
const CHILD_LEAF: u32 = 0x80000000u;
const CHILD_IDS: u32 = 7u;
const NO_CHILD: u32 = 0xffffffffu;
const ALL_CHILDREN: u32 = 0xffu;
// Maximum number of nodes above a leaf.
const HIERARCHY_DEPTH: u32 = 108u;
// Stands for the inverse of zero.
const STEEPEST: f32 = 1.0e30;
// More than the size of the scaled space.
const WIDEST: f32 = 32.0;

// A ray prepared for box tests.
struct Slabs {
    inverse: vec3<f32>,
    // Error bound of t at planes across each axis, beside a share of t.
    doubt: vec3<f32>,
    // Vectors between a node's first one and the bounds that the ray comes to first.
    backward: vec3<u32>,
    // Bounds on the interval of t.
    enter: f32,
    leave: f32,
}

fn slabs_of(ray: ptr<function, TracedRay>) -> Slabs {
    let inverse = select((*ray).inverse, vec3(STEEPEST), (*ray).inverse == vec3(0.0));
    let margin = min(12.0 * RAY_UNIT * abs((*ray).origin) + 2.0 * (*ray).blur, vec3(WIDEST));
    let doubt = 12.0 * RAY_UNIT * (*ray).reach + 2.0 * (*ray).blur;
    let leave = (*ray).length + 12.0 * RAY_UNIT * abs((*ray).length) + doubt;
    return Slabs(inverse, margin * abs(inverse), select(vec3(0u), vec3(2u), inverse < vec3(0.0)), -doubt, leave);
}

// The intervals of t in which a ray may be between the bounds of four boxes on an axis.
struct Stay {
    enter: vec4<f32>,
    leave: vec4<f32>,
}

fn stay_between(first: u32, backward: u32, origin: f32, inverse: f32, doubt: f32) -> Stay {
    let enter = (bitcast<vec4<f32>>(hierarchy[first + backward]) - origin) * inverse;
    let leave = (bitcast<vec4<f32>>(hierarchy[first + (2u - backward)]) - origin) * inverse;
    return Stay(enter - doubt - 12.0 * RAY_UNIT * abs(enter), leave + doubt + 12.0 * RAY_UNIT * abs(leave));
}

// Lower bounds of the t at which a ray enters four children; beyond everything for those that it misses.
fn enters(ray: ptr<function, TracedRay>, slabs: Slabs, first: u32) -> vec4<f32> {
    let origin = (*ray).origin;
    let x = stay_between(first, slabs.backward.x, origin.x, slabs.inverse.x, slabs.doubt.x);
    let y = stay_between(first + 4u, slabs.backward.y, origin.y, slabs.inverse.y, slabs.doubt.y);
    let z = stay_between(first + 8u, slabs.backward.z, origin.z, slabs.inverse.z, slabs.doubt.z);
    let enter = max(max(x.enter, y.enter), max(z.enter, vec4(slabs.enter)));
    let leave = min(min(x.leave, y.leave), min(z.leave, vec4(min(slabs.leave, (*ray).best))));
    let is_child = hierarchy[first + NODE_CHILDREN] != vec4(NO_CHILD);
    return select(vec4(RAY_BEYOND), enter, is_child & (enter <= leave));
}

fn bits_of(is_set: vec4<bool>) -> u32 {
    return dot(select(vec4(0u), vec4(1u, 2u, 4u, 8u), is_set), vec4(1u));
}

fn walk_hierarchy(ray: ptr<function, TracedRay>) {
    let slabs = slabs_of(ray);
    // Nodes, and below them the bits of their children.
    var stack: array<u32, HIERARCHY_DEPTH>;
    var waiting = 0u;
    var node = 0u;
    var left = ALL_CHILDREN;
    loop {
        if RAY_COUNTS {
            (*ray).visits.x += 1u;
        }
        let first = node * NODE_VECTORS;
        let low = select(vec4(RAY_BEYOND), enters(ray, slabs, first), (vec4(left) & vec4(1u, 2u, 4u, 8u)) != vec4(0u));
        let high =
            select(vec4(RAY_BEYOND), enters(ray, slabs, first + 1u), (vec4(left) & vec4(16u, 32u, 64u, 128u)) != vec4(0u));
        let nearest = min(low, high);
        let least = min(min(nearest.x, nearest.y), min(nearest.z, nearest.w));
        var child = NO_CHILD;
        if least < RAY_BEYOND {
            let slot = firstTrailingBit(bits_of(low <= vec4(least)) | (bits_of(high <= vec4(least)) << 4u));
            child = hierarchy[first + NODE_CHILDREN + slot / 4u][slot % 4u];
            left = (bits_of(low < vec4(RAY_BEYOND)) | (bits_of(high < vec4(RAY_BEYOND)) << 4u)) & ~(1u << slot);
            if left != 0u {
                stack[waiting] = (node << 8u) | left;
                waiting += 1u;
            }
        }
        if child < CHILD_LEAF {
            node = child;
            left = ALL_CHILDREN;
            continue;
        }
        if child != NO_CHILD {
            test_leaf(ray, child & ~CHILD_LEAF);
        }
        if waiting == 0u || (*ray).is_blocked {
            return;
        }
        waiting -= 1u;
        node = stack[waiting] >> 8u;
        left = stack[waiting] & ALL_CHILDREN;
    }
}

// Tests the triangles of a leaf, each of which is in no other one.
fn test_leaf(ray: ptr<function, TracedRay>, leaf: u32) {
    if RAY_COUNTS {
        (*ray).visits.y += 1u;
    }
    let end = leaf + 1u;
    for (var index = leaf & ~CHILD_IDS; index < end && !(*ray).is_blocked; index++) {
        ray_test(ray, hierarchy_ids[index]);
    }
}

@compute @workgroup_size(64)
fn by_hierarchy(at: Invocation) {
    let number = flat_index(at, RECORD_LANES);
    var ray: TracedRay;
    if number < ray_count() {
        ray = ray_at(number);
        if !ray_is_missed(&ray) {
            walk_hierarchy(&ray);
        }
        ray_finish(&ray);
    }
    ray_count_steps(at.lane, ray.visits);
}
