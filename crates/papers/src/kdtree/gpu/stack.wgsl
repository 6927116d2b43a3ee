// Stages `nearest` and `blocked` with a stack of all waiting far children; each invocation has a ray.

import package::dispatch::{Invocation, flat_index};
import package::kdtree::node::{
    kd_children, kd_is_backward, kd_is_empty, kd_is_leaf, kd_leaf, kd_nodes, kd_start, kd_ways,
};
import package::rays::records::{RECORD_LANES};
import package::rays::tester::{RAY_COUNTS, TracedRay, ray_at, ray_count, ray_count_steps, ray_finish, ray_is_missed};

// Maximum number of inner nodes above a leaf.
const KD_DEPTH: u32 = 48u;

fn walk_with_stack(ray: ptr<function, TracedRay>) {
    // Nodes and intervals.
    var stack: array<vec3<u32>, KD_DEPTH>;
    kd_start();
    var waiting = 0u;
    var index = 0u;
    var enter = -(*ray).margin;
    var leave = (*ray).leave;
    loop {
        let node = kd_nodes[index];
        if !kd_is_leaf(node) {
            if RAY_COUNTS {
                (*ray).visits.x += 1u;
            }
            let children = kd_children(index, node);
            let ways = kd_ways(ray, node, enter, leave);
            let is_backward = kd_is_backward(ray, node.y & 3u);
            let near = select(ways.left, ways.right, is_backward);
            let far = select(ways.right, ways.left, is_backward);
            let far_node = select(children.y, children.x, is_backward);
            index = select(children.x, children.y, is_backward);
            if kd_is_empty(near) {
                index = far_node;
                enter = far.x;
                leave = far.y;
            } else {
                if !kd_is_empty(far) && waiting < KD_DEPTH {
                    stack[waiting] = vec3(far_node, bitcast<vec2<u32>>(far));
                    waiting += 1u;
                }
                enter = near.x;
                leave = near.y;
            }
            continue;
        }
        kd_leaf(ray, node);
        if (*ray).is_blocked {
            return;
        }
        loop {
            if waiting == 0u {
                return;
            }
            waiting -= 1u;
            enter = bitcast<f32>(stack[waiting].y);
            if enter <= (*ray).best {
                break;
            }
        }
        index = stack[waiting].x;
        leave = bitcast<f32>(stack[waiting].z);
    }
}

@compute @workgroup_size(64)
fn by_stack(at: Invocation) {
    let number = flat_index(at, RECORD_LANES);
    var ray: TracedRay;
    if number < ray_count() {
        ray = ray_at(number);
        if !ray_is_missed(&ray) {
            walk_with_stack(&ray);
        }
        ray_finish(&ray);
    }
    ray_count_steps(at.lane, ray.visits);
}
