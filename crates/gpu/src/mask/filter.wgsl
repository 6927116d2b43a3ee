// Filter for masked triangles: whether a point is there, from a rough position.

import package::grid::set_up::{U};
import package::mask::table::{MASKS_HAS_VERTEX_OPACITY, mask_bytes, mask_material, mask_texture_at, mask_vertices};
import package::wrap::{wrapped};
import stage::{masks};

const MASK_CUT: u32 = 0u;
const MASK_THERE: u32 = 1u;
const MASK_UNDECIDED: u32 = 2u;

// Weights of the second and third vertex, and the error bound of each.
struct RoughPoint {
    weights: vec2<f32>,
    error: f32,
}

fn mask_vertices_f32(triangle: vec4<u32>, word: u32) -> vec3<f32> {
    return bitcast<vec3<f32>>(mask_vertices(triangle, word));
}

// Bilinear opacity changes by at most one from texel to texel on each axis, and from an edge of the image to the next.
fn mask_filter(triangle: vec4<u32>, point: RoughPoint, is_shadow: bool) -> u32 {
    let material = mask_material(triangle.w);
    let weights = vec3<f32>(1.0 - point.weights.x - point.weights.y, point.weights);
    var opacity = bitcast<f32>(masks[material]);
    var error = 1e-5;
    if masks[MASKS_HAS_VERTEX_OPACITY] == 1u {
        let of_vertices = mask_vertices_f32(triangle, 4u);
        opacity *= dot(of_vertices, weights);
        error += 2.0 * point.error * (abs(of_vertices.y - of_vertices.x) + abs(of_vertices.z - of_vertices.x));
    }
    if masks[material + 3u] == 1u {
        let first = 2u * masks[material + 4u];
        let texture = mask_texture_at(material + 8u);
        let x_axis = bitcast<vec2<f32>>(texture.x_axis);
        let y_axis = bitcast<vec2<f32>>(texture.y_axis);
        let of_u = mask_vertices_f32(triangle, first);
        let of_v = mask_vertices_f32(triangle, first + 1u);
        let coords = vec2<f32>(dot(of_u, weights), dot(of_v, weights));
        let size = vec2<f32>(texture.size);
        let shift = bitcast<vec2<f32>>(texture.translation);
        let texel = (x_axis * coords.x + y_axis * coords.y + shift) * size;
        let steps = vec2<f32>(
            abs(of_u.y - of_u.x) + abs(of_u.z - of_u.x), abs(of_v.y - of_v.x) + abs(of_v.z - of_v.x));
        let largest = vec2<f32>(
            max(max(abs(of_u.x), abs(of_u.y)), abs(of_u.z)), max(max(abs(of_v.x), abs(of_v.y)), abs(of_v.z)));
        let coords_error = point.error * steps + 16.0 * U * largest;
        let texel_error = size * (abs(x_axis) * coords_error.x + abs(y_axis) * coords_error.y
            + 16.0 * U * (abs(x_axis) * largest.x + abs(y_axis) * largest.y + abs(shift))) + 16.0 * U * abs(texel);
        // Texels far from the first one, and NaN, are left to the exact answer.
        if !all(abs(texel) < vec2<f32>(1e6)) || !all(texel_error < vec2<f32>(0.25)) {
            return MASK_UNDECIDED;
        }
        var corner = floor(texel);
        var part = vec2<f32>(0.0);
        if texture.is_linear == 1u {
            corner = floor(texel - 0.5);
            part = texel - 0.5 - corner;
            error += 2.0 * (texel_error.x + texel_error.y);
        } else {
            let within = texel - corner;
            if any(min(within, 1.0 - within) < texel_error) {
                return MASK_UNDECIDED;
            }
        }
        let whole = vec2<i32>(corner);
        let low = vec2<u32>(wrapped(whole.x, texture.size.x, texture.wrap.x),
            wrapped(whole.y, texture.size.y, texture.wrap.y));
        let high = vec2<u32>(wrapped(whole.x + 1, texture.size.x, texture.wrap.x),
            wrapped(whole.y + 1, texture.size.y, texture.wrap.y));
        let upper = texture.first_texel + low.y * texture.size.x;
        let lower = texture.first_texel + high.y * texture.size.x;
        let bytes = vec4<f32>(
            mask_bytes(vec4<u32>(upper + low.x, upper + high.x, lower + low.x, lower + high.x))) / 255.0;
        opacity *= mix(mix(bytes.x, bytes.y, part.x), mix(bytes.z, bytes.w, part.x), part.y);
    }
    let cutoff = bitcast<f32>(masks[material + select(1u, 2u, is_shadow)]);
    let margin = error * max(bitcast<f32>(masks[material]), 1.0);
    if opacity > cutoff + margin {
        return MASK_THERE;
    }
    return select(MASK_UNDECIDED, MASK_CUT, opacity < cutoff - margin);
}
