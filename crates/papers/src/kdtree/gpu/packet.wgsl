// Stages `nearest` and `blocked` for packets: the rays of a workgroup go through the tree together, with one short
// stack and one trail (Horn et al. 2007, §3.1 and A.5). A node is visited if any ray meets it. Each ray keeps its own
// interval, which is empty in nodes that it doesn't meet.
//
// Rays needn't have directions of like signs: the first ray's signs choose the child that is visited first, and a ray
// with other signs is merely slower. `trail.wgsl` explains the way back. Whether both children are visited depends on
// the rays' lines alone, so a restart leads the same way.

import package::dispatch::{Invocation, flat_index};
import package::kdtree::levels::{has_level, highest_level, level_bit, levels_below};
import package::kdtree::node::{
    KdWays, kd_children, kd_is_empty, kd_is_leaf, kd_is_over, kd_leaf, kd_nodes, kd_start, kd_ways,
};
import package::rays::tester::{
    RAY_BEYOND, RAY_COUNTS, UNDECIDED_STEPS, TracedRay, ray_add, ray_at, ray_count, ray_finish, ray_is_missed,
};

override KD_PACKET: u32 = 64u;
override KD_ENTRIES: u32 = 4u;
override KD_PUSHES_DOWN: bool = true;

// Votes of the packet's rays: a ray meets the left child, a ray meets the right one, …
const WANTS_LEFT: u32 = 1u;
const WANTS_RIGHT: u32 = 2u;
// … a ray may still find a hit in this cell, a ray may find one in waiting cells.
const IS_ACTIVE: u32 = 4u;
const GOES_ON: u32 = 8u;

// The packet's next step.
const STEP_FINISHED: u32 = 0u;
const STEP_LEFT: u32 = 1u;
const STEP_RIGHT: u32 = 2u;
const STEP_POP: u32 = 3u;
const STEP_RESTART: u32 = 4u;
// Flag of a step to a child: the other child is pushed to the stack.
const STEP_PUSHES: u32 = 8u;
// Flag of any step: from now on this node is where the packet restarts.
const STEP_ROOT: u32 = 16u;

// State of the packet, which its first invocation updates.
struct Packet {
    index: u32,
    level: u32,
    root_node: u32,
    root_level: u32,
    trail: vec2<u32>,
    open: vec2<u32>,
    top: u32,
    held: u32,
    backward: u32,
}

var<workgroup> packet: Packet;
// A node and its level.
var<workgroup> packet_stack: array<vec2<u32>, max(KD_ENTRIES, 1u)>;
var<workgroup> packet_votes: atomic<u32>;
var<workgroup> packet_first: atomic<u32>;
var<workgroup> packet_node: u32;
var<workgroup> packet_step: u32;
// Each ray's intervals, for each entry of the stack.
var<workgroup> packet_ways: array<vec2<f32>, max(KD_ENTRIES, 1u) * KD_PACKET>;

// Gives a vote and returns all votes; the same for all invocations.
fn packet_vote(lane: u32, vote: u32) -> u32 {
    atomicOr(&packet_votes, vote);
    workgroupBarrier();
    if lane == 0u {
        packet_step = atomicExchange(&packet_votes, 0u);
    }
    return workgroupUniformLoad(&packet_step);
}

// Moves the packet on from its inner node, by its rays' votes. Only the first invocation calls it.
fn packet_descend(node: vec2<u32>, votes: u32) -> u32 {
    let children = kd_children(packet.index, node);
    let is_backward = (packet.backward & (1u << (node.y & 3u))) != 0u;
    let is_both = (votes & (WANTS_LEFT | WANTS_RIGHT)) == (WANTS_LEFT | WANTS_RIGHT);
    let is_far = is_both && has_level(packet.trail, packet.level);
    // The near child, or the far one if the trail says so, or the only one that a ray meets.
    let is_right = select((votes & WANTS_RIGHT) != 0u, is_backward != is_far, is_both);
    let bit = level_bit(packet.level);
    packet.level += 1u;
    packet.index = select(children.x, children.y, is_right);
    var step = select(STEP_LEFT, STEP_RIGHT, is_right);
    if is_both && !is_far {
        packet.open |= bit;
        if KD_ENTRIES > 0u {
            packet_stack[packet.top] = vec2(select(children.y, children.x, is_right), packet.level);
            step |= STEP_PUSHES;
        }
    }
    return step;
}

// Moves the packet to the next waiting node. Only the first invocation calls it.
fn packet_return(goes_on: bool) -> u32 {
    if all(packet.open == vec2(0u)) || !goes_on {
        return STEP_FINISHED;
    }
    let next = highest_level(packet.open);
    packet.open &= levels_below(next);
    packet.trail = (packet.trail & levels_below(next)) | level_bit(next);
    if packet.held > 0u {
        packet.held -= 1u;
        packet.top = select(packet.top, KD_ENTRIES, packet.top == 0u) - 1u;
        packet.index = packet_stack[packet.top].x;
        packet.level = packet_stack[packet.top].y;
        return STEP_POP;
    }
    packet.index = packet.root_node;
    packet.level = packet.root_level;
    packet.open = vec2(0u);
    return STEP_RESTART;
}

fn walk_in_packet(ray: ptr<function, TracedRay>, lane: u32, is_missed: bool) {
    // The packet's first ray is the first that doesn't miss the tree.
    if lane == 0u {
        atomicStore(&packet_first, KD_PACKET);
        atomicStore(&packet_votes, 0u);
    }
    workgroupBarrier();
    if !is_missed {
        atomicMin(&packet_first, lane);
    }
    workgroupBarrier();
    let backward = u32((*ray).inverse.x < 0.0) | (u32((*ray).inverse.y < 0.0) << 1u) | (u32((*ray).inverse.z < 0.0) << 2u);
    if lane == atomicLoad(&packet_first) {
        packet = Packet(0u, 0u, 0u, 0u, vec2(0u), vec2(0u), 0u, 0u, backward);
        packet_node = 0u;
    }
    if packet_vote(lane, u32(!is_missed)) == 0u {
        return;
    }
    // Whether the packet's order of children is this ray's own.
    let is_in_order = backward == packet.backward;
    let empty = vec2(RAY_BEYOND, -RAY_BEYOND);
    var root = select(vec2(-(*ray).margin, (*ray).leave), empty, is_missed);
    var way = root;
    // t where the ray left its last leaf, and whether no waiting cell can change its result.
    var reached = -RAY_BEYOND;
    var is_over = is_missed;
    kd_start();
    // Nodes and tests of the whole packet.
    var steps = 0u;
    loop {
        let index = workgroupUniformLoad(&packet_node);
        let node = kd_nodes[index];
        let is_inside = !kd_is_empty(way);
        let is_active = is_inside && way.x <= (*ray).best && !is_over;
        var ways = KdWays(empty, empty);
        var vote = 0u;
        steps += select(1u, node.y >> 2u, kd_is_leaf(node));
        if kd_is_leaf(node) {
            if is_active {
                kd_leaf(ray, node);
            }
        } else {
            if RAY_COUNTS && is_active {
                (*ray).visits.x += 1u;
            }
            if is_inside {
                ways = kd_ways(ray, node, way.x, way.y);
            }
            vote = select(0u, WANTS_LEFT, !kd_is_empty(ways.left)) | select(0u, WANTS_RIGHT, !kd_is_empty(ways.right));
        }
        if is_inside && kd_is_leaf(node) {
            reached = way.y;
        }
        is_over |= (*ray).is_blocked || (is_in_order && kd_is_over(ray, reached));
        vote |= select(0u, IS_ACTIVE, is_active) | select(GOES_ON, 0u, is_over);
        let votes = packet_vote(lane, vote);
        if lane == 0u {
            var step = 0u;
            if !kd_is_leaf(node) && (votes & IS_ACTIVE) != 0u && (votes & (WANTS_LEFT | WANTS_RIGHT)) != 0u {
                step = packet_descend(node, votes);
            } else {
                step = packet_return((votes & GOES_ON) != 0u);
            }
            if KD_PUSHES_DOWN && all(packet.open == vec2(0u)) && step != STEP_FINISHED {
                packet.root_node = packet.index;
                packet.root_level = packet.level;
                step |= STEP_ROOT;
            }
            packet_node = packet.index;
            packet_step = step;
        }
        let decided = workgroupUniformLoad(&packet_step);
        let step = decided & 7u;
        if step == STEP_FINISHED {
            if RAY_COUNTS && lane == 0u {
                ray_add(UNDECIDED_STEPS, KD_PACKET * steps);
            }
            break;
        }
        if step == STEP_LEFT || step == STEP_RIGHT {
            way = select(ways.left, ways.right, step == STEP_RIGHT);
            if (decided & STEP_PUSHES) != 0u {
                packet_ways[packet.top * KD_PACKET + lane] = select(ways.right, ways.left, step == STEP_RIGHT);
            }
        } else if step == STEP_POP {
            way = packet_ways[packet.top * KD_PACKET + lane];
        } else {
            way = root;
            if RAY_COUNTS && lane == 0u {
                (*ray).visits.w += 1u;
            }
        }
        if (decided & STEP_ROOT) != 0u {
            root = way;
        }
        workgroupBarrier();
        if lane == 0u && (decided & STEP_PUSHES) != 0u {
            packet.top = select(packet.top + 1u, 0u, packet.top + 1u >= KD_ENTRIES);
            packet.held = min(packet.held + 1u, KD_ENTRIES);
        }
    }
}

@compute @workgroup_size(KD_PACKET)
fn by_packet(at: Invocation) {
    let number = flat_index(at, KD_PACKET);
    var ray: TracedRay;
    ray.leave = -1.0;
    if number < ray_count() {
        ray = ray_at(number);
    }
    walk_in_packet(&ray, at.lane, ray_is_missed(&ray));
    if number < ray_count() {
        ray_finish(&ray);
    }
}
