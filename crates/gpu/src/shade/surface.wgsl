// A point of a surface with all inputs of shading: crates/umbrage/src/shade/surface.rs.

import package::shade::attributes::{material_of, vertex_color_at};
import package::shade::brdf::{Reflectance, reflectance_of};
import package::shade::facet::{bent_by_texture, facet_of, on_the_side_of_the_ray, smooth_normal, texel_at};
import package::shade::hit::{Triangle, hit_of, ray_direction, triangle_of};
import package::shade::layers::{LAYERS, Layers};
import package::shade::painted::{layers_at, specular_at};
import package::shade::tables::{
    TEXTURES, TEXTURE_BASE_COLOR, TEXTURE_EMISSIVE, TEXTURE_METALLIC_ROUGHNESS, TEXTURE_NORMAL, TEXTURE_OCCLUSION,
    TEXTURE_TRANSMISSION, shade_materials,
};

struct Surface {
    // Its position: a corner of its triangle, and the offset from there.
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
    // Fraction, 0 to 1, of the light from behind that the surface hides; 1 except for blended materials.
    opacity: f32,
    // Transmittance of the opaque part of the surface, before its mirroring is subtracted.
    transmitted: vec3<f32>,
    emitted: vec3<f32>,
    // Fraction of ambient light that arrives, 0 to 1.
    ambient_occlusion: f32,
    material: u32,
    // Whether it bounds a volume of glass, and whether the front of the triangle is seen.
    is_volume: bool,
    is_front: bool,
    is_unlit: bool,
    // Whether it is a shadow catcher.
    catches_shadows: bool,
    layers: Layers,
}

// `across` is the ray's position in the image, from `ray_across`.
fn surface_at(id: u32, across: vec2<f32>) -> Surface {
    let triangle = triangle_of(id);
    let hit = hit_of(triangle, across);
    return surface_of(id, triangle, hit.barycentric, hit.depth, -ray_direction(across));
}

// The surface at a point with these weights of the second and the third corner, `depth` away from the camera along the
// path of light, seen from a unit direction.
fn surface_of(id: u32, triangle: Triangle, barycentric: vec2<f32>, depth: f32, view: vec3<f32>) -> Surface {
    let material = material_of(id);
    let facet = facet_of(triangle, barycentric, view, depth);

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
    surface.from_corner = triangle.to_second * barycentric.x + triangle.to_third * barycentric.y;
    surface.depth = depth;
    surface.view = facet.view;
    surface.geometric_normal = facet.geometric_normal;
    let smooth_one = smooth_normal(facet);
    let scale = shade_materials[material].normal_scale;
    let bent = bent_by_texture(material, TEXTURE_NORMAL, scale, facet, texels[TEXTURE_NORMAL], smooth_one);
    surface.normal = on_the_side_of_the_ray(facet, smooth_one, bent);
    surface.reflectance =
        reflectance_of(base_color.xyz, metallic, roughness, shade_materials[material].ior, transmission);
    if LAYERS && shade_materials[material].layer_bits != 0u {
        surface.reflectance = specular_at(material, facet, surface.reflectance, base_color.xyz, metallic);
        surface.layers = layers_at(material, facet, smooth_one, surface.normal, surface.reflectance);
        surface.reflectance.roughness = surface.layers.roughness;
    }
    surface.base_color = base_color.xyz;
    surface.opacity = select(1.0, clamp(base_color.w, 0.0, 1.0), shade_materials[material].is_blended != 0u);
    surface.transmitted = base_color.xyz * transmission;
    surface.material = material;
    surface.is_volume = shade_materials[material].bounds_volume != 0u;
    surface.is_front = facet.facing > 0.0;
    surface.emitted = shade_materials[material].emissive * texels[TEXTURE_EMISSIVE].xyz;
    surface.ambient_occlusion = 1.0 + shade_materials[material].occlusion_strength * (occlusion - 1.0);
    surface.is_unlit = shade_materials[material].is_unlit != 0u;
    surface.catches_shadows = shade_materials[material].catches_shadows != 0u;
    return surface;
}
