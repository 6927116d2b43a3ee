// The scene's surroundings: as seen, as light, and as mirrored: crates/umbrage/src/background.rs.

import package::shade::panorama::{panorama_radiance};
import package::shade::tables::{
    SURROUNDINGS_COLOR, SURROUNDINGS_IMAGE, SURROUNDINGS_TRANSPARENT, shade_scene,
};

// Whether pictures show the surroundings without exposure and tone mapping.
fn surroundings_are_flat() -> bool {
    return shade_scene.surroundings.kind == SURROUNDINGS_COLOR;
}

// Radiance seen in a unit direction.
fn surroundings_radiance(direction: vec3<f32>) -> vec3<f32> {
    if shade_scene.surroundings.kind == SURROUNDINGS_TRANSPARENT {
        return vec3<f32>(0.0);
    }
    return surroundings_mirrored(direction);
}

// Radiance seen by mirrors in a unit direction: only pictures have transparent backgrounds.
fn surroundings_mirrored(direction: vec3<f32>) -> vec3<f32> {
    return surroundings_around(direction, 0.05, 0.0);
}

// Mean radiance around a unit direction, over about the highlight of a perceptual roughness.
fn surroundings_blurred(direction: vec3<f32>, roughness: f32) -> vec3<f32> {
    return surroundings_around(direction, 0.05 + roughness * roughness, 0.5 * roughness * roughness);
}

// The sky with its horizon blurred over `softness`, or the panorama over `width` of its circumference.
fn surroundings_around(direction: vec3<f32>, softness: f32, width: f32) -> vec3<f32> {
    if shade_scene.surroundings.kind == SURROUNDINGS_COLOR {
        return shade_scene.surroundings.color;
    }
    if shade_scene.surroundings.kind == SURROUNDINGS_IMAGE {
        return panorama_radiance(direction, width);
    }
    return sky_radiance(direction.y, softness);
}

// Irradiance of a surface with a unit normal, from all of the background above it.
fn surroundings_irradiance(normal: vec3<f32>) -> vec3<f32> {
    let n = normal;
    var sum = shade_scene.surroundings.irradiance[0].xyz * 0.282095;
    sum += shade_scene.surroundings.irradiance[1].xyz * (0.488603 * n.y);
    sum += shade_scene.surroundings.irradiance[2].xyz * (0.488603 * n.z);
    sum += shade_scene.surroundings.irradiance[3].xyz * (0.488603 * n.x);
    sum += shade_scene.surroundings.irradiance[4].xyz * (1.092548 * n.x * n.y);
    sum += shade_scene.surroundings.irradiance[5].xyz * (1.092548 * n.y * n.z);
    sum += shade_scene.surroundings.irradiance[6].xyz * (0.315392 * (3.0 * n.z * n.z - 1.0));
    sum += shade_scene.surroundings.irradiance[7].xyz * (1.092548 * n.x * n.z);
    sum += shade_scene.surroundings.irradiance[8].xyz * (0.546274 * (n.x * n.x - n.y * n.y));
    return max(sum, vec3<f32>(0.0));
}

const SKY_ZENITH: vec3<f32> = vec3<f32>(0.20, 0.27, 0.40);
const SKY_HORIZON: vec3<f32> = vec3<f32>(0.58, 0.63, 0.68);
// Just below the horizon, where haze hides the ground, and straight down.
const SKY_HAZE: vec3<f32> = vec3<f32>(0.38, 0.385, 0.39);
const SKY_GROUND: vec3<f32> = vec3<f32>(0.28, 0.28, 0.28);

// The sky's radiance at a height between −1 and 1, its horizon blurred over `softness`.
fn sky_radiance(height: f32, softness: f32) -> vec3<f32> {
    let above = mix(SKY_HORIZON, SKY_ZENITH, sqrt(max(height, 0.0)));
    let below = mix(SKY_HAZE, SKY_GROUND, sqrt(max(-height, 0.0)));
    let part = clamp((height + softness) / (2.0 * softness), 0.0, 1.0);
    return mix(below, above, part * part * (3.0 - 2.0 * part));
}
