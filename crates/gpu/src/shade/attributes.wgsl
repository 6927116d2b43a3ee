// Attributes of vertices and triangles: crates/scene/src/frame.rs.

import package::shade::tables::{NO_WORD, shade_attributes, shade_scene};

fn material_of(triangle: u32) -> u32 {
    return shade_attributes[shade_scene.material_word + triangle];
}

// Set 0 or set 1 of the texture coordinates of three vertices; zero for a set that the scene doesn't have.
fn tex_coords_of(vertices: vec3<u32>, set_of_two: u32) -> array<vec2<f32>, 3> {
    let first = shade_scene.tex_coord_words[set_of_two];
    if first == NO_WORD {
        return array<vec2<f32>, 3>();
    }
    return array<vec2<f32>, 3>(
        attribute_pair(first + 2u * vertices.x),
        attribute_pair(first + 2u * vertices.y),
        attribute_pair(first + 2u * vertices.z),
    );
}

// The vertices' own colour and opacity at a point of a triangle; white if the scene has none.
fn vertex_color_at(vertices: vec3<u32>, weights: vec3<f32>) -> vec4<f32> {
    let first = shade_scene.color_word;
    if first == NO_WORD {
        return vec4<f32>(1.0);
    }
    return attribute_four(first + 4u * vertices.x) * weights.x
        + attribute_four(first + 4u * vertices.y) * weights.y
        + attribute_four(first + 4u * vertices.z) * weights.z;
}

// The vertices' normals at a point of a triangle, of any length; zero where the surface is flat.
fn vertex_normal_at(vertices: vec3<u32>, weights: vec3<f32>) -> vec3<f32> {
    let first = shade_scene.normal_word;
    if first == NO_WORD {
        return vec3<f32>(0.0);
    }
    return attribute_three(first + 3u * vertices.x) * weights.x
        + attribute_three(first + 3u * vertices.y) * weights.y
        + attribute_three(first + 3u * vertices.z) * weights.z;
}

// The vertices' tangents at a point of a triangle, of any length, and the sign of the bitangent; zero if there is none.
fn vertex_tangent_at(vertices: vec3<u32>, weights: vec3<f32>) -> vec4<f32> {
    let first = shade_scene.tangent_word;
    if first == NO_WORD {
        return vec4<f32>(0.0);
    }
    let of_first = attribute_four(first + 4u * vertices.x);
    let tangent = of_first.xyz * weights.x
        + attribute_four(first + 4u * vertices.y).xyz * weights.y
        + attribute_four(first + 4u * vertices.z).xyz * weights.z;
    return vec4<f32>(tangent, select(1.0, -1.0, of_first.w < 0.0));
}

fn attribute_pair(word: u32) -> vec2<f32> {
    return bitcast<vec2<f32>>(vec2<u32>(shade_attributes[word], shade_attributes[word + 1u]));
}

fn attribute_three(word: u32) -> vec3<f32> {
    return vec3<f32>(attribute_pair(word), bitcast<f32>(shade_attributes[word + 2u]));
}

fn attribute_four(word: u32) -> vec4<f32> {
    return vec4<f32>(attribute_pair(word), attribute_pair(word + 2u));
}
