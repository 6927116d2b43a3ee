// Code shared by all traversals: the tree, lines through it, and the tests of leaves. The bounds are derived in `mod.rs`.

import package::kdtree::records::{RECORD_LANES};
import package::kdtree::shape::{KdShape};
import package::mask::flags::{TRIANGLE_MASKED, TRIANGLE_ONE_SIDED, TRIANGLE_SHADOWLESS, TRIANGLE_SHADOW_MASKED};

@group(0) @binding(0) var<uniform> kd_shape: KdShape;
@group(0) @binding(1) var<storage, read> kd_nodes: array<vec2<u32>>;
@group(0) @binding(2) var<storage, read> kd_ids: array<u32>;
@group(0) @binding(3) var<storage, read> triangles: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read> positions: array<u32>;
@group(0) @binding(5) var<storage, read> lines: array<vec4<u32>>;
// For each ray: whether it is certainly shadowed, the first of its listed hits, and the t beyond which hits don't matter.
@group(0) @binding(6) var<storage, read_write> traced: array<vec4<u32>>;
@group(0) @binding(7) var<storage, read_write> undecided_hits: array<atomic<u32>>;

// Whether nodes, leaves, tests, restarts and steps are counted.
override KD_COUNTS: bool = false;
// Whether rays look for any shadowing triangle; else, for the nearest hit.
override KD_IS_SHADOW: bool = false;
// Whether shadow rays list all triangles that they meet, in a tree of surfaces that transmit light.
override KD_IS_PASSED: bool = false;

const UNDECIDED_COUNT: u32 = 0u;
// Number of certain ones among them: the predicate only has to find their t.
const UNDECIDED_CERTAIN: u32 = 4u;
// Pairs of words: low, high. Steps include those of invocations that wait for others.
const UNDECIDED_STEPS: u32 = 6u;
const UNDECIDED_VISITS: u32 = 8u;
const UNDECIDED_FIRST: u32 = 16u;
// Words of a hit: its triangle, its ray, the ray's next hit, a lower bound on t, and four words for the stage `settle`.
const UNDECIDED_WORDS: u32 = 8u;
const NOTHING: u32 = 0xffffffffu;
const KD_LEAF: u32 = 3u;
// 2⁻²⁴: half the distance from one to the next f32.
const KD_UNIT: f32 = 5.9604645e-8;
const KD_BEYOND: f32 = 3.0e38;
const KD_MAILBOX: u32 = 8u;

// State of a ray in a traversal.
struct KdRay {
    origin: vec3<f32>,
    blur: f32,
    inverse: vec3<f32>,
    heights: f32,
    slope: vec2<f32>,
    // The interval inside the bounds begins at zero, minus `margin`.
    leave: f32,
    most_doubt: f32,
    first: f32,
    last: f32,
    own: u32,
    axis: u32,
    // Whether the ray hits the backs of one-sided triangles instead of the fronts, as rays from points to a light do.
    meets_backs: bool,
    number: u32,
    // Error bound of t at planes across each axis.
    doubt: vec3<f32>,
    // Error bound of a coordinate.
    margin: f32,

    // The hit that isn't in the list yet; usually the only one.
    held: u32,
    held_lower: f32,
    held_upper: f32,
    is_held_certain: bool,
    // The list of all other candidates for the nearest hit, and the triangle last listed.
    list: u32,
    listed: u32,
    // Upper bound on the t of the nearest hit.
    best: f32,
    is_blocked: bool,
    mailbox: array<u32, KD_MAILBOX>,
    // Nodes, leaves, tests, restarts.
    visits: vec4<u32>,
}

fn kd_count() -> u32 {
    return lines[0].x;
}

fn kd_ray(number: u32) -> KdRay {
    let at = 1u + 4u * number;
    var ray: KdRay;
    let first = bitcast<vec4<f32>>(lines[at]);
    let second = bitcast<vec4<f32>>(lines[at + 1u]);
    let third = bitcast<vec4<f32>>(lines[at + 2u]);
    let fourth = lines[at + 3u];
    ray.origin = first.xyz;
    ray.blur = first.w;
    ray.inverse = second.xyz;
    ray.heights = second.w;
    ray.slope = third.xy;
    ray.margin = 12.0 * KD_UNIT + 2.0 * ray.blur;
    ray.leave = third.z + ray.margin;
    ray.most_doubt = third.w;
    ray.first = bitcast<f32>(fourth.x);
    ray.last = bitcast<f32>(fourth.y);
    ray.own = fourth.z >> 2u;
    ray.axis = fourth.z & 3u;
    ray.meets_backs = fourth.w != 0u;
    ray.number = number;
    ray.doubt = ray.margin * abs(ray.inverse);
    ray.held = NOTHING;
    ray.list = NOTHING;
    ray.listed = NOTHING;
    ray.best = KD_BEYOND;
    for (var index = 0u; index < KD_MAILBOX; index++) {
        ray.mailbox[index] = NOTHING;
    }
    return ray;
}

fn kd_is_missed(ray: ptr<function, KdRay>) -> bool {
    return (*ray).leave < 0.0;
}

fn kd_is_leaf(node: vec2<u32>) -> bool {
    return (node.y & 3u) == KD_LEAF;
}

// The indices of the left and the right child of the inner node at `index`.
fn kd_children(index: u32, node: vec2<u32>) -> vec2<u32> {
    let child = node.y >> 2u;
    let follows = kd_shape.left_follows;
    return vec2(((index + 1u) & follows) | (child & ~follows), child + (~follows & 1u));
}

fn kd_component(vector: vec3<f32>, axis: u32) -> f32 {
    return select(select(vector.z, vector.y, axis == 1u), vector.x, axis == 0u);
}

// Whether a ray meets the right child of a node with a plane across `axis` before the left one.
fn kd_is_backward(ray: ptr<function, KdRay>, axis: u32) -> bool {
    return kd_component((*ray).inverse, axis) < 0.0;
}

// Intervals of t in which a ray may be in the left and the right child of an inner node, given its interval in the
// node. An interval is empty if it ends before it begins.
struct KdWays {
    left: vec2<f32>,
    right: vec2<f32>,
}

fn kd_ways(ray: ptr<function, KdRay>, node: vec2<u32>, enter: f32, leave: f32) -> KdWays {
    let axis = node.y & 3u;
    let plane = bitcast<f32>(node.x) * bitcast<f32>(kd_shape.scale);
    let inverse = kd_component((*ray).inverse, axis);
    let ahead = plane - kd_component((*ray).origin, axis);
    let whole = vec2(enter, leave);
    let empty = vec2(KD_BEYOND, -KD_BEYOND);
    if inverse == 0.0 {
        // Parallel to the plane: on one side, or near enough to be on both.
        let margin = (*ray).margin;
        return KdWays(select(whole, empty, ahead < -margin), select(whole, empty, ahead > margin));
    }
    let t = ahead * inverse;
    let doubt = kd_component((*ray).doubt, axis);
    let before = vec2(enter, min(t + doubt, leave));
    let behind = vec2(max(t - doubt, enter), leave);
    return KdWays(select(before, behind, inverse < 0.0), select(behind, before, inverse < 0.0));
}

fn kd_is_empty(way: vec2<f32>) -> bool {
    return way.y < way.x;
}

// Whether no waiting cell can hold the nearest hit, for a ray that leaves its cell at `leave`: waiting cells begin
// where the nearer cell around this one ends, or up to twice the doubt before.
fn kd_is_over(ray: ptr<function, KdRay>, leave: f32) -> bool {
    return leave - 2.0 * (*ray).most_doubt > (*ray).best;
}

fn kd_turned(vector: vec3<f32>, axis: u32) -> vec3<f32> {
    return select(select(vector, vector.zxy, axis == 1u), vector.yzx, axis == 0u);
}

fn kd_corner(vertex: u32) -> vec3<f32> {
    let bits = vec3(positions[3u * vertex], positions[3u * vertex + 1u], positions[3u * vertex + 2u]);
    return bitcast<vec3<f32>>(bits) * bitcast<f32>(kd_shape.scale);
}

// A triangle that a line may meet.
struct KdMeeting {
    is_missed: bool,
    // Whether the line certainly meets it inside its interval.
    is_certain: bool,
    // Bounds on t of the meeting, if there is one.
    lower: f32,
    upper: f32,
    // Lower bound on the product of the line's direction and the triangle's unnormalised normal, in the sheared space.
    steepness: f32,
    // Positive if the line certainly comes from the back, negative if from the front.
    turn: f32,
}

// Tests a triangle as Woop, Benthin and Wald do ("Watertight ray/triangle intersection", 2013): in a space sheared so
// that the line is an axis, where edge functions are two-dimensional.
fn kd_meet(ray: ptr<function, KdRay>, id: u32) -> KdMeeting {
    let corners = triangles[id].xyz;
    let axis = (*ray).axis;
    let slope = (*ray).slope;
    let origin = kd_turned((*ray).origin, axis);
    let a = kd_turned(kd_corner(corners.x), axis) - origin;
    let b = kd_turned(kd_corner(corners.y), axis) - origin;
    let c = kd_turned(kd_corner(corners.z), axis) - origin;
    let p = a.xy - slope * a.z;
    let q = b.xy - slope * b.z;
    let r = c.xy - slope * c.z;
    let error = 20.0 * KD_UNIT + 3.0 * (*ray).blur;
    let size = max(max(abs(p), abs(q)), abs(r));
    let reach = max(size.x, size.y);
    let bound = 5.0 * error * reach + 3.0 * error * error + 8.0 * KD_UNIT * reach * reach;
    let edges = vec3(q.x * r.y - r.x * q.y, r.x * p.y - p.x * r.y, p.x * q.y - q.x * p.y);
    let lowest = min(edges.x, min(edges.y, edges.z));
    let highest = max(edges.x, max(edges.y, edges.z));

    var inverse = kd_component((*ray).inverse, axis);
    if inverse == 0.0 {
        // For a line that tests everything.
        inverse = 1.0;
    }
    let t = vec3(a.z, b.z, c.z) * inverse;
    let t_error = 10.0 * KD_UNIT + 2.0 * (*ray).blur;
    let nearest = min(t.x, min(t.y, t.z));
    let farthest = max(t.x, max(t.y, t.z));
    var meeting = KdMeeting(false, false, nearest - t_error, farthest + t_error, 0.0, 0.0);
    if lowest > bound || highest < -bound {
        meeting.turn = lowest * inverse;
        let sum = edges.x + edges.y + edges.z;
        let steepness = abs(sum) - 5.0 * bound;
        if steepness > 0.0 {
            let across = farthest - nearest + 2.0 * t_error;
            let hit = t.x + (edges.y * (t.y - t.x) + edges.z * (t.z - t.x)) / sum;
            let off = 4.0 * t_error + (8.5 * bound / steepness + 32.0 * KD_UNIT) * across + 4.0 * KD_UNIT * abs(hit);
            meeting.lower = max(hit - off, meeting.lower);
            meeting.upper = min(hit + off, meeting.upper);
            meeting.steepness = steepness;
        }
        meeting.is_certain =
            meeting.lower > (*ray).first + t_error && meeting.upper < (*ray).last - t_error;
    }
    meeting.is_missed = (lowest < -bound && highest > bound)
        || meeting.upper < (*ray).first - t_error || meeting.lower > (*ray).last + t_error;
    return meeting;
}

// Appends a hit to a ray's list.
fn kd_list(ray: ptr<function, KdRay>, id: u32, lower: f32) {
    let index = atomicAdd(&undecided_hits[UNDECIDED_COUNT], 1u);
    let base = UNDECIDED_FIRST + index * UNDECIDED_WORDS;
    // If there is no room, the count tells, and the whole submission is repeated.
    if index < arrayLength(&undecided_hits) / UNDECIDED_WORDS && base + UNDECIDED_WORDS <= arrayLength(&undecided_hits) {
        atomicStore(&undecided_hits[base], id);
        atomicStore(&undecided_hits[base + 1u], (*ray).number);
        atomicStore(&undecided_hits[base + 2u], (*ray).list);
        atomicStore(&undecided_hits[base + 3u], bitcast<u32>(lower));
        (*ray).list = index;
    }
    (*ray).listed = id;
}

// Whether the plane of the triangle is certainly off the points that the ray starts from and ends at.
fn kd_is_clear(ray: ptr<function, KdRay>, meeting: KdMeeting) -> bool {
    let from_end = min((*ray).last - meeting.upper, meeting.lower - (*ray).first) - 8.0 * KD_UNIT - 2.0 * (*ray).blur;
    // The direction's largest component is at least one, so the inverse's is at least one half.
    return from_end > 0.0 && 0.5 * meeting.steepness * from_end > (*ray).heights;
}

// Takes a triangle as a candidate for the nearest hit.
fn kd_note_nearest(ray: ptr<function, KdRay>, id: u32, tested: KdMeeting) {
    var meeting = tested;
    if (*ray).heights > 0.0 && !kd_is_clear(ray, meeting) {
        // The ray may start on the triangle.
        meeting.is_certain = false;
    }
    if meeting.lower > (*ray).best || id == (*ray).held || id == (*ray).listed {
        return;
    }
    let is_nearer = meeting.is_certain && meeting.upper < (*ray).held_lower;
    if meeting.is_certain {
        (*ray).best = min((*ray).best, meeting.upper);
    }
    if (*ray).held == NOTHING || is_nearer {
        (*ray).held = id;
        (*ray).held_lower = meeting.lower;
        (*ray).held_upper = meeting.upper;
        (*ray).is_held_certain = meeting.is_certain;
    } else {
        kd_list(ray, id, meeting.lower);
    }
}

// Takes a triangle that may shadow the ray's point.
fn kd_note_shadow(ray: ptr<function, KdRay>, id: u32, meeting: KdMeeting) {
    if meeting.is_certain && kd_is_clear(ray, meeting) {
        (*ray).is_blocked = true;
    } else if id != (*ray).listed {
        kd_list(ray, id, meeting.lower);
    }
}

// Tests the triangles of a leaf.
fn kd_leaf(ray: ptr<function, KdRay>, node: vec2<u32>) {
    if KD_COUNTS {
        (*ray).visits.y += 1u;
    }
    let end = node.x + (node.y >> 2u);
    for (var index = node.x; index < end; index++) {
        let id = kd_ids[index];
        // A few of Kirk and Arvo's ray tags.
        let slot = id % KD_MAILBOX;
        if (*ray).mailbox[slot] == id || (id & 0x3fffffffu) == (*ray).own {
            continue;
        }
        (*ray).mailbox[slot] = id;
        if KD_COUNTS {
            (*ray).visits.z += 1u;
        }
        let kind = triangles[id].w;
        if KD_IS_SHADOW && !KD_IS_PASSED && (kind & TRIANGLE_SHADOWLESS) != 0u {
            continue;
        }
        var meeting = kd_meet(ray, id);
        let is_other_side = select(meeting.turn > 0.0, meeting.turn < 0.0, (*ray).meets_backs);
        if meeting.is_missed || ((kind & TRIANGLE_ONE_SIDED) != 0u && is_other_side) {
            continue;
        }
        if (kind & select(TRIANGLE_MASKED, TRIANGLE_SHADOW_MASKED, KD_IS_SHADOW)) != 0u {
            meeting.is_certain = false;
        }
        if KD_IS_PASSED {
            if id != (*ray).listed {
                kd_list(ray, id, meeting.lower);
            }
        } else if KD_IS_SHADOW {
            kd_note_shadow(ray, id, meeting);
            if (*ray).is_blocked {
                return;
            }
        } else {
            kd_note_nearest(ray, id, meeting);
        }
    }
}

fn kd_add(word: u32, count: u32) {
    if count > 0u {
        let before = atomicAdd(&undecided_hits[word], count);
        if before + count < before {
            atomicAdd(&undecided_hits[word + 1u], 1u);
        }
    }
}

// Writes a ray's results.
fn kd_finish(ray: ptr<function, KdRay>) {
    if KD_IS_SHADOW {
        traced[(*ray).number] = vec4(u32((*ray).is_blocked), (*ray).list, bitcast<u32>(KD_BEYOND), 0u);
    } else {
        if (*ray).held != NOTHING {
            if (*ray).is_held_certain && (*ray).listed == NOTHING {
                atomicAdd(&undecided_hits[UNDECIDED_CERTAIN], 1u);
            }
            kd_list(ray, (*ray).held, (*ray).held_lower);
        }
        traced[(*ray).number] = vec4(0u, (*ray).list, bitcast<u32>((*ray).best), 0u);
    }
    if KD_COUNTS {
        for (var index = 0u; index < 4u; index++) {
            kd_add(UNDECIDED_VISITS + 2u * index, (*ray).visits[index]);
        }
    }
}

// Number of invocations that run in lockstep on most GPUs.
const KD_LOCKSTEP: u32 = 32u;

var<workgroup> kd_most_steps: array<atomic<u32>, RECORD_LANES / KD_LOCKSTEP>;

// Counts the steps (nodes and tests) of invocations in lockstep: each counts as many as the one with the most. All
// invocations of a workgroup must call it.
fn kd_count_steps(lane: u32, visits: vec4<u32>) {
    if KD_COUNTS {
        let group = lane / KD_LOCKSTEP;
        atomicMax(&kd_most_steps[group], visits.x + visits.z);
        workgroupBarrier();
        if lane % KD_LOCKSTEP == 0u {
            kd_add(UNDECIDED_STEPS, KD_LOCKSTEP * atomicLoad(&kd_most_steps[group]));
        }
    }
}
