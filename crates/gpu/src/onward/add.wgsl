// Stage `add`: adds the rays' colours to the film. Rays are in the order of their pixels; the first ray of a pixel adds the
// sum of all of them.

import package::dispatch::{Invocation, flat_index};
import package::onward::path::{OnwardPath};
import package::onward::step::{NOWHERE, OnwardStep};

@group(0) @binding(0) var<uniform> onward_step: OnwardStep;
@group(0) @binding(1) var<storage, read> planes: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> paths: array<OnwardPath>;
@group(0) @binding(3) var<storage, read_write> film: array<vec4<f32>>;

@compute @workgroup_size(64)
fn add(at: Invocation) {
    let first = flat_index(at, 64u);
    if first >= onward_step.count {
        return;
    }
    let pixel = paths[first].pixel;
    if first > 0u && paths[first - 1u].pixel == pixel {
        return;
    }
    let has_flat = onward_step.flat_plane != NOWHERE;
    var sum = vec4<f32>(0.0);
    var flat_sum = vec4<f32>(0.0);
    for (var number = first; number < onward_step.count && paths[number].pixel == pixel; number++) {
        sum += planes[number];
        if has_flat {
            flat_sum += planes[onward_step.flat_plane + number];
        }
    }
    film[pixel] += sum;
    if has_flat {
        film[onward_step.flat_plane_of_film + pixel] += flat_sum;
    }
}
