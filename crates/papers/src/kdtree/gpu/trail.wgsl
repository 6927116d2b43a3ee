// Stages `nearest` and `blocked` with a stack of the last few waiting far children, or with none: restart, push-down
// and short stack; each invocation has a ray. If the stack has lost the next node, the ray starts again from above.
//
// The paper finds the way back by moving the ray's start to the point where it left the last leaf. Intervals of
// neighbours overlap here, so that could lead to the same leaf again, or past one. Instead a bit for each level says
// whether the ray is in the farther one of two children that it meets (Laine, "Restart trail for stackless BVH
// traversal", 2010), as in the Rust crate's `trail`.

import package::dispatch::{Invocation, flat_index};
import package::kdtree::levels::{has_level, highest_level, level_bit, levels_below};
import package::kdtree::node::{
    kd_children, kd_is_backward, kd_is_empty, kd_is_leaf, kd_is_over, kd_leaf, kd_nodes, kd_start, kd_ways,
};
import package::rays::records::{RECORD_LANES};
import package::rays::tester::{RAY_COUNTS, TracedRay, ray_at, ray_count, ray_count_steps, ray_finish, ray_is_missed};

// Entries of the stack, and whether restarts push down.
override KD_ENTRIES: u32 = 4u;
override KD_PUSHES_DOWN: bool = true;

// A node, its level and the interval.
var<workgroup> short_stack: array<vec4<u32>, max(KD_ENTRIES, 1u) * RECORD_LANES>;

fn walk_on_trail(ray: ptr<function, TracedRay>, lane: u32) {
    kd_start();
    // The node of the next restart: no node above it waits.
    var root_node = 0u;
    var root_level = 0u;
    var root = vec2(-(*ray).margin, (*ray).leave);
    var index = 0u;
    var level = 0u;
    var way = root;
    // By level, whether the ray is in the farther child of a node both of whose children it meets, …
    var trail = vec2(0u);
    // … and whether that child still waits.
    var open = vec2(0u);
    // Of the stack: index of the next entry, and number of entries.
    var top = 0u;
    var held = 0u;
    loop {
        let node = kd_nodes[index];
        // Whether all of the node has been visited.
        var is_done = kd_is_leaf(node);
        if is_done {
            kd_leaf(ray, node);
            if (*ray).is_blocked {
                return;
            }
        } else {
            if RAY_COUNTS {
                (*ray).visits.x += 1u;
            }
            let children = kd_children(index, node);
            let ways = kd_ways(ray, node, way.x, way.y);
            let is_backward = kd_is_backward(ray, node.y & 3u);
            let near = select(ways.left, ways.right, is_backward);
            let far = select(ways.right, ways.left, is_backward);
            let near_node = select(children.x, children.y, is_backward);
            let far_node = select(children.y, children.x, is_backward);
            let is_both = !kd_is_empty(near) && !kd_is_empty(far);
            let is_far = kd_is_empty(near) || (is_both && has_level(trail, level));
            let bit = level_bit(level);
            level += 1u;
            if is_both && !is_far {
                open |= bit;
                if KD_ENTRIES > 0u {
                    short_stack[top * RECORD_LANES + lane] = vec4(far_node, level, bitcast<vec2<u32>>(far));
                    top = select(top + 1u, 0u, top + 1u >= KD_ENTRIES);
                    held = min(held + 1u, KD_ENTRIES);
                }
            }
            index = select(near_node, far_node, is_far);
            way = select(near, far, is_far);
            is_done = is_both && is_far && way.x > (*ray).best;
        }
        while is_done {
            if all(open == vec2(0u)) || kd_is_over(ray, way.y) {
                return;
            }
            let next = highest_level(open);
            open &= levels_below(next);
            trail = (trail & levels_below(next)) | level_bit(next);
            if held > 0u {
                held -= 1u;
                top = select(top, KD_ENTRIES, top == 0u) - 1u;
                let entry = short_stack[top * RECORD_LANES + lane];
                index = entry.x;
                level = entry.y;
                way = bitcast<vec2<f32>>(entry.zw);
                is_done = way.x > (*ray).best;
            } else {
                if RAY_COUNTS {
                    (*ray).visits.w += 1u;
                }
                index = root_node;
                level = root_level;
                way = root;
                open = vec2(0u);
                is_done = false;
            }
        }
        if KD_PUSHES_DOWN && all(open == vec2(0u)) {
            root_node = index;
            root_level = level;
            root = way;
        }
    }
}

@compute @workgroup_size(64)
fn by_trail(at: Invocation) {
    let number = flat_index(at, RECORD_LANES);
    var ray: TracedRay;
    if number < ray_count() {
        ray = ray_at(number);
        if !ray_is_missed(&ray) {
            walk_on_trail(&ray, at.lane);
        }
        ray_finish(&ray);
    }
    ray_count_steps(at.lane, ray.visits);
}
