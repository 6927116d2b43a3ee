// A triangle as seen by a ray, its textures and normals: crates/umbrage/src/shade/surface.rs and paint.rs.

import package::shade::attributes::{tex_coords_of, vertex_normal_at, vertex_tangent_at};
import package::shade::hit::{Triangle, perp_dot};
import package::shade::tables::{shade_materials, shade_sample};
import package::shade::texture::{texture_at};

// A triangle as seen by a ray.
struct Facet {
    triangle: Triangle,
    // Of the three vertices.
    weights: vec3<f32>,
    // Towards the ray's origin.
    view: vec3<f32>,
    // On the side of `view`.
    geometric_normal: vec3<f32>,
    // 1 if the ray comes from the front of the triangle, −1 from its back.
    facing: f32,
    // Area of the ray's cone on the surface, in triangle areas.
    covered_triangles: f32,
}

// Minimum squared length of a vector that has a direction.
const LEAST_SQUARED: f32 = 1e-37;
// Stands for the cone's area in triangle areas, if the triangle has no area.
const COVERS_ALL: f32 = 1e30;

fn facet_of(triangle: Triangle, barycentric: vec2<f32>, view: vec3<f32>, depth: f32) -> Facet {
    let doubled_area = cross(triangle.to_second, triangle.to_third);
    let squared = dot(doubled_area, doubled_area);
    // A sliver whose area vanishes in f32 counts as seen from the front.
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

// Value of one of the material's textures here; one if it has none. Averages the texels that the pixel's cone covers on
// the surface.
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

// The vertices' interpolated normal, on the front of the surface.
fn smooth_normal(facet: Facet) -> vec3<f32> {
    let mean = vertex_normal_at(facet.triangle.vertices, facet.weights);
    let squared = dot(mean, mean);
    // Also for NaN.
    if !(squared > LEAST_SQUARED) {
        return facet.geometric_normal * facet.facing;
    }
    return mean * inverseSqrt(squared);
}

// A normal on the front of the surface, flipped to the ray's side.
fn on_the_side_of_the_ray(facet: Facet, smooth_normal: vec3<f32>, bent: vec3<f32>) -> vec3<f32> {
    // Normals define the front, also in files whose winding disagrees with them.
    return select(bent, -bent, dot(smooth_normal, facet.geometric_normal) < 0.0);
}

// `normal` bent by a normal texture in one of the material's slots, given its texel.
fn bent_by_texture(
    material: u32,
    slot: u32,
    scale: f32,
    facet: Facet,
    texel: vec4<f32>,
    normal: vec3<f32>,
) -> vec3<f32> {
    let texture = shade_materials[material].textures[slot];
    if texture.levels == 0u {
        return normal;
    }
    return bend(facet, texture.tex_coord_set, (texel.xyz * 2.0 - 1.0) * vec3<f32>(scale, scale, 1.0), normal);
}

// `normal` bent by a bump in the tangent frame of the file, or else of the texture coordinates.
fn bend(facet: Facet, tex_coord_set: u32, bump: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    var tangent = vertex_tangent_at(facet.triangle.vertices, facet.weights);
    if dot(tangent.xyz, tangent.xyz) <= LEAST_SQUARED {
        tangent = gradient_tangent(facet, tex_coord_set);
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
