// Nodes of the kd-tree, and the tests of its leaves. The bounds are derived in `rays/mod.rs` and `mod.rs`.

import package::rays::tester::{RAY_BEYOND, RAY_COUNTS, TracedRay, ray_component, ray_space, ray_test};

@group(0) @binding(1) var<storage, read> kd_nodes: array<vec2<u32>>;
@group(0) @binding(2) var<storage, read> kd_ids: array<u32>;

const KD_LEAF: u32 = 3u;
const KD_MAILBOX: u32 = 8u;

// A few of Kirk and Arvo's ray tags: the triangles last tested, since leaves share triangles.
var<private> kd_mailbox: array<u32, KD_MAILBOX>;

fn kd_is_leaf(node: vec2<u32>) -> bool {
    return (node.y & 3u) == KD_LEAF;
}

// The indices of the left and the right child of the inner node at `index`.
fn kd_children(index: u32, node: vec2<u32>) -> vec2<u32> {
    let child = node.y >> 2u;
    let follows = ray_space.left_follows;
    return vec2(((index + 1u) & follows) | (child & ~follows), child + (~follows & 1u));
}

// Whether a ray meets the right child of a node with a plane across `axis` before the left one.
fn kd_is_backward(ray: ptr<function, TracedRay>, axis: u32) -> bool {
    return ray_component((*ray).inverse, axis) < 0.0;
}

// Intervals of t in which a ray may be in the left and the right child of an inner node, given its interval in the
// node. An interval is empty if it ends before it begins.
struct KdWays {
    left: vec2<f32>,
    right: vec2<f32>,
}

fn kd_ways(ray: ptr<function, TracedRay>, node: vec2<u32>, enter: f32, leave: f32) -> KdWays {
    let axis = node.y & 3u;
    let plane = bitcast<f32>(node.x) * bitcast<f32>(ray_space.scale);
    let inverse = ray_component((*ray).inverse, axis);
    let ahead = plane - ray_component((*ray).origin, axis);
    let whole = vec2(enter, leave);
    let empty = vec2(RAY_BEYOND, -RAY_BEYOND);
    if inverse == 0.0 {
        // Parallel to the plane: on one side, or near enough to be on both.
        let margin = (*ray).margin;
        return KdWays(select(whole, empty, ahead < -margin), select(whole, empty, ahead > margin));
    }
    let t = ahead * inverse;
    let doubt = (*ray).margin * abs(inverse);
    let before = vec2(enter, min(t + doubt, leave));
    let behind = vec2(max(t - doubt, enter), leave);
    return KdWays(select(before, behind, inverse < 0.0), select(behind, before, inverse < 0.0));
}

fn kd_is_empty(way: vec2<f32>) -> bool {
    return way.y < way.x;
}

// Whether no waiting cell can hold the nearest hit, for a ray that leaves its cell at `leave`: waiting cells begin
// where the nearer cell around this one ends, or up to twice the doubt before.
fn kd_is_over(ray: ptr<function, TracedRay>, leave: f32) -> bool {
    return leave - 2.0 * (*ray).most_doubt > (*ray).best;
}

// Empties the mailbox, before a walk.
fn kd_start() {
    for (var index = 0u; index < KD_MAILBOX; index++) {
        kd_mailbox[index] = 0xffffffffu;
    }
}

// Tests the triangles of a leaf.
fn kd_leaf(ray: ptr<function, TracedRay>, node: vec2<u32>) {
    if RAY_COUNTS {
        (*ray).visits.y += 1u;
    }
    let end = node.x + (node.y >> 2u);
    for (var index = node.x; index < end && !(*ray).is_blocked; index++) {
        let id = kd_ids[index];
        let slot = id % KD_MAILBOX;
        if kd_mailbox[slot] != id {
            kd_mailbox[slot] = id;
            ray_test(ray, id);
        }
    }
}
