// Stage `tint`: transmittance of triangles on the straight path of light to a point: crates/umbrage/src/cpu/tint.rs.
//
// `shade_seen` has the tracer's lists of the surfaces between each point and its light, and `shade_lit` the start of
// each point's list (`rays/settle.wgsl`). The transmittance replaces the first entry of a point's list.

import package::dispatch::{Invocation, flat_index};
import package::shade::attributes::{material_of, tex_coords_of, vertex_color_at};
import package::shade::glass::{attenuation};
import package::shade::tables::{
    LAYER_COAT, LAYER_SPECULAR, TEXTURE_BASE_COLOR, TEXTURE_COAT, TEXTURE_METALLIC_ROUGHNESS, TEXTURE_SPECULAR,
    TEXTURE_SPECULAR_COLOR, TEXTURE_TRANSMISSION, shade_lit, shade_materials, shade_sample, shade_seen, shade_triangles,
};
import package::shade::texture::{texture_at};

const LIST_FIRST: u32 = 16u;
const LIST_WORDS: u32 = 8u;
// With more nested bodies of glass than this, the last ones take no colour.
const MOST_BODIES: u32 = 8u;
const COAT_AHEAD: f32 = 0.04;

@compute @workgroup_size(64)
fn tint(at: Invocation) {
    let number = flat_index(at, 64u);
    if number >= shade_sample.points {
        return;
    }
    let room = (arrayLength(&shade_seen) - LIST_FIRST) / LIST_WORDS;
    let first = shade_lit[4u * number + 1u];
    if first >= room {
        return;
    }
    var left = vec3<f32>(1.0);
    var bodies: array<u32, MOST_BODIES>;
    var lengths: array<f32, MOST_BODIES>;
    var body_count = 0u;
    var next = first;
    while next < room {
        let base = LIST_FIRST + next * LIST_WORDS;
        next = shade_seen[base + 2u];
        if shade_seen[base + 4u] == 0u {
            continue;
        }
        let id = shade_seen[base];
        left *= passing_through(id, bitcast<vec2<f32>>(vec2<u32>(shade_seen[base + 6u], shade_seen[base + 7u])));
        let material = material_of(id);
        if shade_materials[material].bounds_volume != 0u {
            var body = 0u;
            while body < body_count && bodies[body] != material {
                body += 1u;
            }
            if body < MOST_BODIES {
                bodies[body] = material;
                lengths[body] += bitcast<f32>(shade_seen[base + 5u]);
                body_count = max(body_count, body + 1u);
            }
        }
    }
    for (var body = 0u; body < body_count; body++) {
        left *= attenuation(bodies[body], lengths[body]);
    }
    let base = LIST_FIRST + first * LIST_WORDS;
    shade_seen[base + 3u] = pack2x16unorm(left.xy);
    shade_seen[base + 5u] = pack2x16unorm(vec2<f32>(left.z, 0.0));
}

// Straight transmittance of a triangle at a point: crates/scene/src/opacity.rs.
fn passing_through(id: u32, barycentric: vec2<f32>) -> vec3<f32> {
    let material = material_of(id);
    let vertices = shade_triangles[id].xyz;
    let weights = vec3<f32>(1.0 - barycentric.x - barycentric.y, barycentric);
    let color = shade_materials[material].base_color
        * vertex_color_at(vertices, weights)
        * whole_texel(material, TEXTURE_BASE_COLOR, vertices, weights);
    var opacity = 1.0;
    if shade_materials[material].is_blended != 0u {
        opacity = clamp(color.w, 0.0, 1.0);
    } else if shade_materials[material].mask_cutoff > 0.0 {
        opacity = select(0.0, 1.0, color.w >= shade_materials[material].mask_cutoff);
    }
    let ior = shade_materials[material].ior;
    let ratio = (ior - 1.0) / (ior + 1.0);
    let ahead = ratio * ratio;
    let bits = shade_materials[material].layer_bits;
    var mirrored = ahead;
    if (bits & LAYER_SPECULAR) != 0u {
        let tinted = shade_materials[material].layers.specular_color
            * whole_texel(material, TEXTURE_SPECULAR_COLOR, vertices, weights).xyz;
        let strength = shade_materials[material].layers.specular * whole_texel(material, TEXTURE_SPECULAR, vertices, weights).w;
        mirrored = clamp(max(tinted.x, max(tinted.y, tinted.z)) * ahead, 0.0, 1.0) * clamp(strength, 0.0, 1.0);
    }
    var entering = 1.0 - mirrored;
    if (bits & LAYER_COAT) != 0u {
        let coat = shade_materials[material].layers.coat * whole_texel(material, TEXTURE_COAT, vertices, weights).x;
        entering *= 1.0 - COAT_AHEAD * clamp(coat, 0.0, 1.0);
    }
    let metallic =
        shade_materials[material].metallic * whole_texel(material, TEXTURE_METALLIC_ROUGHNESS, vertices, weights).z;
    let transmission = shade_materials[material].transmission
        * whole_texel(material, TEXTURE_TRANSMISSION, vertices, weights).x
        * (1.0 - metallic);
    return vec3<f32>(1.0 - opacity) + color.xyz * (opacity * transmission * entering);
}

// Value of a material's texture at a point, at full size; one if it has none.
fn whole_texel(material: u32, slot: u32, vertices: vec3<u32>, weights: vec3<f32>) -> vec4<f32> {
    let texture = shade_materials[material].textures[slot];
    if texture.levels == 0u {
        return vec4<f32>(1.0);
    }
    let corners = tex_coords_of(vertices, texture.tex_coord_set);
    let matrix = mat2x2<f32>(texture.matrix.xy, texture.matrix.zw);
    let coords = corners[0] * weights.x + corners[1] * weights.y + corners[2] * weights.z;
    return texture_at(texture, matrix * coords + texture.translation, 0.0);
}
