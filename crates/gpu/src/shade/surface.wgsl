// A point of a surface with everything that shading needs: crates/umbrage/src/shade/surface.rs.

import package::shade::attributes::{material_of, tex_coords_of, vertex_color_at, vertex_normal_at, vertex_tangent_at};
import package::shade::brdf::{Reflectance, reflectance_of, reflectance_view};
import package::shade::hit::{Triangle, hit_of, perp_dot, ray_direction, triangle_of};
import package::shade::tables::{
    TEXTURES, TEXTURE_BASE_COLOR, TEXTURE_EMISSIVE, TEXTURE_METALLIC_ROUGHNESS, TEXTURE_NORMAL, TEXTURE_OCCLUSION,
    TEXTURE_TRANSMISSION, shade_materials, shade_sample,
};
import package::shade::texture::{texture_at};

struct Surface {
    // Where it is: a corner of its triangle, and from there.
    corner: vec3<f32>,
    from_corner: vec3<f32>,
    // Along the camera's forward axis.
    depth: f32,
    // Unit direction towards the ray's origin.
    view: vec3<f32>,
    // Unit normal of the triangle, on the side of `view`.
    geometric_normal: vec3<f32>,
    // Unit normal with the vertices' and the texture's bumps.
    normal: vec3<f32>,
    reflectance: Reflectance,
    base_color: vec3<f32>,
    // How much of what is behind the surface hides; 1 but for blended materials.
    opacity: f32,
    // What passes through of the light from behind, where the surface is opaque otherwise.
    transmitted: vec3<f32>,
    emitted: vec3<f32>,
    // How much of the light from all around arrives, 0 … 1.
    ambient_occlusion: f32,
    is_unlit: bool,
    // Whether only the shadows on it are seen.
    catches_shadows: bool,
}

// A triangle as the ray sees it.
struct Facet {
    triangle: Triangle,
    // Of the three vertices.
    weights: vec3<f32>,
    // Towards the ray's origin.
    view: vec3<f32>,
    // On the side of `view`.
    geometric_normal: vec3<f32>,
    // 1 where the ray comes from the front of the triangle, −1 from its back.
    facing: f32,
    // Area of the ray's cone on the surface, in triangle areas.
    covered_triangles: f32,
}

// The least squared length of a vector that has a direction.
const LEAST_SQUARED: f32 = 1e-37;
// Stands for the area of a cone on a triangle that has none.
const COVERS_ALL: f32 = 1e30;

// `across` is the ray's position in the image, as ray_across gives it.
fn surface_at(id: u32, across: vec2<f32>) -> Surface {
    let material = material_of(id);
    let triangle = triangle_of(id);
    let hit = hit_of(triangle, across);
    let facet = facet_of(triangle, hit.barycentric, -ray_direction(across), hit.depth);

    var texels: array<vec4<f32>, TEXTURES>;
    for (var slot = 0u; slot < TEXTURES; slot++) {
        texels[slot] = texel_at(material, slot, facet);
    }
    let base_color = shade_materials[material].base_color
        * vertex_color_at(triangle.vertices, facet.weights)
        * texels[TEXTURE_BASE_COLOR];
    let metallic = shade_materials[material].metallic * texels[TEXTURE_METALLIC_ROUGHNESS].z;
    let roughness = shade_materials[material].roughness * texels[TEXTURE_METALLIC_ROUGHNESS].y;
    let transmission = shade_materials[material].transmission * texels[TEXTURE_TRANSMISSION].x * (1.0 - metallic);
    let occlusion = texels[TEXTURE_OCCLUSION].x;

    var surface: Surface;
    surface.corner = triangle.corners[0];
    surface.from_corner = triangle.to_second * hit.barycentric.x + triangle.to_third * hit.barycentric.y;
    surface.depth = hit.depth;
    surface.view = facet.view;
    surface.geometric_normal = facet.geometric_normal;
    surface.normal = bent_normal(material, facet, texels[TEXTURE_NORMAL]);
    surface.reflectance =
        reflectance_of(base_color.xyz, metallic, roughness, shade_materials[material].ior, transmission);
    surface.base_color = base_color.xyz;
    surface.opacity = select(1.0, clamp(base_color.w, 0.0, 1.0), shade_materials[material].is_blended != 0u);
    surface.transmitted = base_color.xyz * transmission;
    if transmission > 0.0 {
        // What the surface mirrors doesn't pass.
        let seen = reflectance_view(surface.reflectance, max(dot(surface.normal, surface.view), 1e-4));
        surface.transmitted *= 1.0 - seen.specular;
    }
    surface.emitted = shade_materials[material].emissive * texels[TEXTURE_EMISSIVE].xyz;
    surface.ambient_occlusion = 1.0 + shade_materials[material].occlusion_strength * (occlusion - 1.0);
    surface.is_unlit = shade_materials[material].is_unlit != 0u;
    surface.catches_shadows = shade_materials[material].catches_shadows != 0u;
    return surface;
}

fn facet_of(triangle: Triangle, barycentric: vec2<f32>, view: vec3<f32>, depth: f32) -> Facet {
    let doubled_area = cross(triangle.to_second, triangle.to_third);
    let squared = dot(doubled_area, doubled_area);
    // A sliver whose area vanishes in f32 is seen as if from the front.
    var front = view;
    if squared > LEAST_SQUARED {
        front = doubled_area * inverseSqrt(squared);
    }
    let facing = select(1.0, -1.0, dot(front, view) < 0.0);
    let width = shade_sample.footprint + shade_sample.footprint_per_depth * depth;
    let cosine = max(dot(front * facing, view), 0.01);
    var covered_triangles = COVERS_ALL;
    if squared > LEAST_SQUARED {
        covered_triangles = 2.0 * width * width / (cosine * sqrt(squared));
    }
    let weights = vec3<f32>(1.0 - barycentric.x - barycentric.y, barycentric);
    return Facet(triangle, weights, view, front * facing, facing, covered_triangles);
}

// What a texture of the material says here; one where there is none. As many texels are averaged as the pixel's cone
// covers on the surface.
fn texel_at(material: u32, slot: u32, facet: Facet) -> vec4<f32> {
    let texture = shade_materials[material].textures[slot];
    if texture.levels == 0u {
        return vec4<f32>(1.0);
    }
    let corners = tex_coords_of(facet.triangle.vertices, texture.tex_coord_set);
    let matrix = mat2x2<f32>(texture.matrix.xy, texture.matrix.zw);
    let doubled_area = abs(perp_dot(matrix * (corners[1] - corners[0]), matrix * (corners[2] - corners[0])));
    let triangle_texels = 0.5 * doubled_area * f32(texture.size.x) * f32(texture.size.y);
    let coords = corners[0] * facet.weights.x + corners[1] * facet.weights.y + corners[2] * facet.weights.z;
    return texture_at(texture, matrix * coords + texture.translation, sqrt(triangle_texels * facet.covered_triangles));
}

// The shading normal: interpolated between the vertices, bent by the normal texture, and on the side of the ray.
fn bent_normal(material: u32, facet: Facet, texel: vec4<f32>) -> vec3<f32> {
    let mean = vertex_normal_at(facet.triangle.vertices, facet.weights);
    let squared = dot(mean, mean);
    // Also where it is no number.
    if !(squared > LEAST_SQUARED) {
        return bend(material, facet, texel, facet.geometric_normal * facet.facing) * facet.facing;
    }
    let smooth_normal = mean * inverseSqrt(squared);
    let bent = bend(material, facet, texel, smooth_normal);
    // Normals say which side is the front, also in files whose winding disagrees with them.
    return select(bent, -bent, dot(smooth_normal, facet.geometric_normal) < 0.0);
}

// `normal` bent by the normal texture in the tangent frame of the file, or else of the texture coordinates.
fn bend(material: u32, facet: Facet, texel: vec4<f32>, normal: vec3<f32>) -> vec3<f32> {
    let texture = shade_materials[material].textures[TEXTURE_NORMAL];
    if texture.levels == 0u {
        return normal;
    }
    var tangent = vertex_tangent_at(facet.triangle.vertices, facet.weights);
    if dot(tangent.xyz, tangent.xyz) <= LEAST_SQUARED {
        tangent = gradient_tangent(facet, texture.tex_coord_set);
    } else {
        tangent = vec4<f32>(tangent.xyz * inverseSqrt(dot(tangent.xyz, tangent.xyz)), tangent.w);
    }
    let along = tangent.xyz - normal * dot(tangent.xyz, normal);
    let squared = dot(along, along);
    if squared <= LEAST_SQUARED {
        return normal;
    }
    let right = along * inverseSqrt(squared);
    let up = cross(normal, right) * tangent.w;
    let scale = shade_materials[material].normal_scale;
    let bump = (texel.xyz * 2.0 - 1.0) * vec3<f32>(scale, scale, 1.0);
    let bent = right * bump.x + up * bump.y + normal * bump.z;
    let bent_squared = dot(bent, bent);
    if bent_squared <= LEAST_SQUARED {
        return normal;
    }
    return bent * inverseSqrt(bent_squared);
}

// The direction in which the texture's u grows across the triangle, of any length, and the sign of the bitangent; zero
// where the coordinates cover no area.
fn gradient_tangent(facet: Facet, tex_coord_set: u32) -> vec4<f32> {
    let corners = tex_coords_of(facet.triangle.vertices, tex_coord_set);
    let to_second = corners[1] - corners[0];
    let to_third = corners[2] - corners[0];
    let area = perp_dot(to_second, to_third);
    let tangent = (facet.triangle.to_second * to_third.y - facet.triangle.to_third * to_second.y) * sign(area);
    // v grows downwards in the image and the bitangent points up: an image that isn't mirrored has a negative area.
    return vec4<f32>(tangent, select(-1.0, 1.0, area < 0.0));
}
