// Code shared by all walks: lines, and the tests of triangles. The bounds are derived in `mod.rs`. A walk declares its
// structure's nodes and ids at bindings 1 and 2.

import package::rays::records::{RECORD_LANES};
import package::rays::space::{RaySpace};
import package::mask::flags::{TRIANGLE_MASKED, TRIANGLE_ONE_SIDED, TRIANGLE_SHADOWLESS, TRIANGLE_SHADOW_MASKED};

@group(0) @binding(0) var<uniform> ray_space: RaySpace;
@group(0) @binding(3) var<storage, read> triangles: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read> positions: array<u32>;
@group(0) @binding(5) var<storage, read> lines: array<vec4<u32>>;
// For each ray: whether it is certainly shadowed, the first of its listed hits, and the t beyond which hits don't matter.
@group(0) @binding(6) var<storage, read_write> traced: array<vec4<u32>>;
@group(0) @binding(7) var<storage, read_write> undecided_hits: array<atomic<u32>>;

// Whether nodes, leaves, tests, restarts and steps are counted.
override RAY_COUNTS: bool = false;
// Whether rays look for any shadowing triangle; else, for the nearest hit.
override RAY_IS_SHADOW: bool = false;
// Whether shadow rays list all triangles that they meet, in a structure of surfaces that transmit light.
override RAY_IS_PASSED: bool = false;

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
// 2⁻²⁴: half the distance from one to the next f32.
const RAY_UNIT: f32 = 5.9604645e-8;
const RAY_BEYOND: f32 = 3.0e38;
// Above all that underflows of products of coordinates and of their errors.
const RAY_UNDERFLOW: f32 = 1.0e-36;

// State of a ray in a walk.
struct TracedRay {
    origin: vec3<f32>,
    blur: f32,
    inverse: vec3<f32>,
    heights: f32,
    slope: vec2<f32>,
    // The interval inside the bounds: from zero to `length`, or with an error of `margin` from −margin to `leave`.
    length: f32,
    leave: f32,
    most_doubt: f32,
    first: f32,
    last: f32,
    own: u32,
    axis: u32,
    // Whether the ray hits the backs of one-sided triangles instead of the fronts, as rays from points to a light do.
    meets_backs: bool,
    number: u32,
    // Error bound of a coordinate.
    margin: f32,
    // Largest magnitude of a coordinate of the origin.
    reach: f32,

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
    // Nodes, leaves, tests, restarts.
    visits: vec4<u32>,
}

fn ray_count() -> u32 {
    return lines[0].x;
}

fn ray_at(number: u32) -> TracedRay {
    let at = 1u + 4u * number;
    var ray: TracedRay;
    let first = bitcast<vec4<f32>>(lines[at]);
    let second = bitcast<vec4<f32>>(lines[at + 1u]);
    let third = bitcast<vec4<f32>>(lines[at + 2u]);
    let fourth = lines[at + 3u];
    ray.origin = first.xyz;
    ray.blur = first.w;
    ray.inverse = second.xyz;
    ray.heights = second.w;
    ray.slope = third.xy;
    ray.margin = 12.0 * RAY_UNIT + 2.0 * ray.blur;
    ray.length = third.z;
    ray.leave = third.z + ray.margin;
    ray.most_doubt = third.w;
    ray.first = bitcast<f32>(fourth.x);
    ray.last = bitcast<f32>(fourth.y);
    ray.own = fourth.z >> 2u;
    ray.axis = fourth.z & 3u;
    ray.meets_backs = fourth.w != 0u;
    ray.number = number;
    let size = abs(ray.origin);
    ray.reach = max(size.x, max(size.y, size.z));
    ray.held = NOTHING;
    ray.list = NOTHING;
    ray.listed = NOTHING;
    ray.best = RAY_BEYOND;
    if ray_space.continues != 0u {
        ray.list = traced[number].y;
        ray.is_blocked = traced[number].x != 0u;
    }
    return ray;
}

// Whether there is nothing to walk for: the ray misses the bounds, or is known to be blocked.
fn ray_is_missed(ray: ptr<function, TracedRay>) -> bool {
    return (*ray).leave < 0.0 || (*ray).is_blocked;
}

fn ray_component(vector: vec3<f32>, axis: u32) -> f32 {
    return select(select(vector.z, vector.y, axis == 1u), vector.x, axis == 0u);
}

fn ray_turned(vector: vec3<f32>, axis: u32) -> vec3<f32> {
    return select(select(vector, vector.zxy, axis == 1u), vector.yzx, axis == 0u);
}

fn ray_corner(vertex: u32) -> vec3<f32> {
    let bits = vec3(positions[3u * vertex], positions[3u * vertex + 1u], positions[3u * vertex + 2u]);
    return bitcast<vec3<f32>>(bits) * bitcast<f32>(ray_space.scale);
}

// A triangle that a line may meet.
struct RayMeeting {
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
    // Error bound of a corner's t.
    doubt: f32,
}

// Tests a triangle as Woop, Benthin and Wald do ("Watertight ray/triangle intersection", 2013): in a space sheared so
// that the line is an axis, where edge functions are two-dimensional.
fn ray_meet(ray: ptr<function, TracedRay>, id: u32) -> RayMeeting {
    let corners = triangles[id].xyz;
    let axis = (*ray).axis;
    let slope = (*ray).slope;
    let origin = ray_turned((*ray).origin, axis);
    let a = ray_turned(ray_corner(corners.x), axis) - origin;
    let b = ray_turned(ray_corner(corners.y), axis) - origin;
    let c = ray_turned(ray_corner(corners.z), axis) - origin;
    let p = a.xy - slope * a.z;
    let q = b.xy - slope * b.z;
    let r = c.xy - slope * c.z;
    let extent = max(max(abs(a), abs(b)), abs(c));
    let scale = max(extent.x, max(extent.y, extent.z)) + (*ray).reach;
    let error = 20.0 * RAY_UNIT * scale + 3.0 * (*ray).blur;
    let size = max(max(abs(p), abs(q)), abs(r));
    let reach = max(size.x, size.y);
    let bound = 5.0 * error * reach + 3.0 * error * error + 8.0 * RAY_UNIT * reach * reach + RAY_UNDERFLOW;
    let edges = vec3(q.x * r.y - r.x * q.y, r.x * p.y - p.x * r.y, p.x * q.y - q.x * p.y);
    let lowest = min(edges.x, min(edges.y, edges.z));
    let highest = max(edges.x, max(edges.y, edges.z));

    var inverse = ray_component((*ray).inverse, axis);
    if inverse == 0.0 {
        // For a line that tests everything.
        inverse = 1.0;
    }
    let t = vec3(a.z, b.z, c.z) * inverse;
    let t_error = 10.0 * RAY_UNIT * scale + 2.0 * (*ray).blur;
    let nearest = min(t.x, min(t.y, t.z));
    let farthest = max(t.x, max(t.y, t.z));
    var meeting = RayMeeting(false, false, nearest - t_error, farthest + t_error, 0.0, 0.0, t_error);
    if lowest > bound || highest < -bound {
        meeting.turn = lowest * inverse;
        let sum = edges.x + edges.y + edges.z;
        let steepness = abs(sum) - 5.0 * bound;
        if steepness > 0.0 {
            let across = farthest - nearest + 2.0 * t_error;
            let hit = t.x + (edges.y * (t.y - t.x) + edges.z * (t.z - t.x)) / sum;
            let off = 4.0 * t_error + (8.5 * bound / steepness + 32.0 * RAY_UNIT) * across
                + 4.0 * RAY_UNIT * abs(hit) + RAY_UNDERFLOW / steepness;
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
fn ray_list(ray: ptr<function, TracedRay>, id: u32, lower: f32) {
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
fn ray_is_clear(ray: ptr<function, TracedRay>, meeting: RayMeeting) -> bool {
    let from_end = min((*ray).last - meeting.upper, meeting.lower - (*ray).first) - meeting.doubt;
    // The direction's largest component is at least one, so the inverse's is at least one half.
    return from_end > 0.0 && 0.5 * meeting.steepness * from_end > (*ray).heights;
}

// Takes a triangle as a candidate for the nearest hit.
fn ray_note_nearest(ray: ptr<function, TracedRay>, id: u32, tested: RayMeeting) {
    var meeting = tested;
    if (*ray).heights > 0.0 && !ray_is_clear(ray, meeting) {
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
        ray_list(ray, id, meeting.lower);
    }
}

// Takes a triangle that may shadow the ray's point.
fn ray_note_shadow(ray: ptr<function, TracedRay>, id: u32, meeting: RayMeeting) {
    if meeting.is_certain && ray_is_clear(ray, meeting) {
        (*ray).is_blocked = true;
    } else if id != (*ray).listed {
        ray_list(ray, id, meeting.lower);
    }
}

// Tests a triangle.
fn ray_test(ray: ptr<function, TracedRay>, id: u32) {
    if (id & 0x3fffffffu) == (*ray).own {
        return;
    }
    if RAY_COUNTS {
        (*ray).visits.z += 1u;
    }
    let kind = triangles[id].w;
    if RAY_IS_SHADOW && !RAY_IS_PASSED && (kind & TRIANGLE_SHADOWLESS) != 0u {
        return;
    }
    var meeting = ray_meet(ray, id);
    let is_other_side = select(meeting.turn > 0.0, meeting.turn < 0.0, (*ray).meets_backs);
    if meeting.is_missed || ((kind & TRIANGLE_ONE_SIDED) != 0u && is_other_side) {
        return;
    }
    if (kind & select(TRIANGLE_MASKED, TRIANGLE_SHADOW_MASKED, RAY_IS_SHADOW)) != 0u {
        meeting.is_certain = false;
    }
    if RAY_IS_PASSED {
        if id != (*ray).listed {
            ray_list(ray, id, meeting.lower);
        }
    } else if RAY_IS_SHADOW {
        ray_note_shadow(ray, id, meeting);
    } else {
        ray_note_nearest(ray, id, meeting);
    }
}

fn ray_add(word: u32, count: u32) {
    if count > 0u {
        let before = atomicAdd(&undecided_hits[word], count);
        if before + count < before {
            atomicAdd(&undecided_hits[word + 1u], 1u);
        }
    }
}

// Writes a ray's results.
fn ray_finish(ray: ptr<function, TracedRay>) {
    if RAY_IS_SHADOW {
        traced[(*ray).number] = vec4(u32((*ray).is_blocked), (*ray).list, bitcast<u32>(RAY_BEYOND), 0u);
    } else {
        if (*ray).held != NOTHING {
            if (*ray).is_held_certain && (*ray).listed == NOTHING {
                atomicAdd(&undecided_hits[UNDECIDED_CERTAIN], 1u);
            }
            ray_list(ray, (*ray).held, (*ray).held_lower);
        }
        // The t of a structure's parts have different units.
        let best = select((*ray).best, RAY_BEYOND, ray_space.continues != 0u);
        traced[(*ray).number] = vec4(0u, (*ray).list, bitcast<u32>(best), 0u);
    }
    if RAY_COUNTS {
        for (var index = 0u; index < 4u; index++) {
            ray_add(UNDECIDED_VISITS + 2u * index, (*ray).visits[index]);
        }
    }
}

// Number of invocations that run in lockstep on most GPUs.
const RAY_LOCKSTEP: u32 = 32u;

var<workgroup> ray_most_steps: array<atomic<u32>, RECORD_LANES / RAY_LOCKSTEP>;

// Counts the steps (nodes and tests) of invocations in lockstep: each counts as many as the one with the most. All
// invocations of a workgroup must call it.
fn ray_count_steps(lane: u32, visits: vec4<u32>) {
    if RAY_COUNTS {
        let group = lane / RAY_LOCKSTEP;
        atomicMax(&ray_most_steps[group], visits.x + visits.z);
        workgroupBarrier();
        if lane % RAY_LOCKSTEP == 0u {
            ray_add(UNDECIDED_STEPS, RAY_LOCKSTEP * atomicLoad(&ray_most_steps[group]));
        }
    }
}
