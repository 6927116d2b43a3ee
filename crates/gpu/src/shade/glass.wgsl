// Light at smooth surfaces between two media, and inside these media: crates/umbrage/src/shade/glass.rs, which has the
// sources.

import package::onward::media::{Media, OPEN_AIR, media_across, media_innermost};
import package::shade::tables::{shade_materials};

// Stands for an infinite ratio of indices.
const ALL_IS_REFLECTED: f32 = 1e30;

// Fresnel reflectance, 0 to 1, for light at this cosine of incidence from a medium whose index is `ratio` times that of
// the medium behind the surface. One beyond the critical angle.
fn reflected_part(cosine: f32, ratio: f32) -> f32 {
    let squared = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
    if !(squared > 0.0) {
        return 1.0;
    }
    let behind = sqrt(squared);
    let across = (ratio * cosine - behind) / (ratio * cosine + behind);
    let along = (cosine - ratio * behind) / (cosine + ratio * behind);
    return clamp(0.5 * (across * across + along * along), 0.0, 1.0);
}

// Direction of refracted light behind a surface; `normal` is on the side from which the unit `direction` comes. Zero
// beyond the critical angle.
fn refracted(direction: vec3<f32>, normal: vec3<f32>, ratio: f32) -> vec3<f32> {
    let cosine = -dot(direction, normal);
    let behind = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
    if !(behind > 0.0) {
        return vec3<f32>(0.0);
    }
    return normalize(direction * ratio + normal * (ratio * cosine - sqrt(behind)));
}

// Whether a surface of this material disperses colours.
fn media_disperse(media: Media, material: u32) -> bool {
    let around = media_innermost(media);
    var is_apart = shade_materials[material].dispersion != 0.0;
    if around != OPEN_AIR {
        is_apart = is_apart || shade_materials[around].dispersion != 0.0;
    }
    return is_apart;
}

// Ratio of the indices of refraction before and behind a surface of this material, for red, green or blue light as −1,
// 0 and 1.
fn media_ratio(media: Media, material: u32, from_front: bool, color: f32) -> f32 {
    let own = index_of(material, color);
    var before = own;
    var behind = own;
    if from_front {
        before = index_of(media_innermost(media), color);
    } else {
        behind = index_of(media_innermost(media_across(media, material, false)), color);
    }
    if before > 0.0 && behind > 0.0 {
        return before / behind;
    }
    return ALL_IS_REFLECTED;
}

fn index_of(material: u32, color: f32) -> f32 {
    if material == OPEN_AIR {
        return 1.0;
    }
    let ior = shade_materials[material].ior;
    return ior + (ior - 1.0) * 0.025 * shade_materials[material].dispersion * color;
}

// Transmittance of a distance in a material.
fn attenuation(material: u32, distance: f32) -> vec3<f32> {
    let after = shade_materials[material].attenuation_distance;
    if after == 0.0 {
        return vec3<f32>(1.0);
    }
    let part = max(distance, 0.0) / after;
    if part == 0.0 {
        return vec3<f32>(1.0);
    }
    let left = max(shade_materials[material].attenuation_color, vec3<f32>(0.0));
    // `pow` of zero isn't zero on some devices.
    let powers = select(vec3<f32>(0.0), pow(max(left, vec3<f32>(1e-37)), vec3<f32>(part)), left > vec3<f32>(0.0));
    return min(powers, vec3<f32>(1.0));
}
