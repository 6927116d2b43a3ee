// Light that arrives at a point: crates/umbrage/src/shade/irradiance.rs.

import package::shade::tables::{LIGHT_DIRECTIONAL, LIGHT_FLAT, LIGHT_SPOT, ShadeLight};

struct Arriving {
    // Unit direction towards the light.
    towards: vec3<f32>,
    // Irradiance of a surface that faces the light; zero outside its cone and range, and in the light itself.
    irradiance: vec3<f32>,
}

// Direction and irradiance of a light at a point, which is given as a corner of its triangle and an offset from there.
// So lights near a triangle far from the origin keep their direction.
fn arriving_light(light: ShadeLight, corner: vec3<f32>, from_corner: vec3<f32>) -> Arriving {
    if light.kind == LIGHT_DIRECTIONAL {
        return Arriving(-light.direction, light.emitted);
    }
    let offset = (light.position - corner) - from_corner;
    let squared = dot(offset, offset);
    if squared <= 0.0 {
        return Arriving(vec3<f32>(0.0), vec3<f32>(0.0));
    }
    let distance = sqrt(squared);
    let towards = offset / distance;
    var part = 1.0;
    if light.range > 0.0 {
        part = light_fade(distance / light.range);
    }
    if light.kind == LIGHT_SPOT {
        let cosine = dot(light.direction, -towards);
        let inside = clamp((cosine - light.outer_cosine) / light.cosine_span, 0.0, 1.0);
        part *= inside * inside;
    } else if light.kind == LIGHT_FLAT {
        part *= max(dot(light.direction, -towards), 0.0);
    }
    return Arriving(towards, light.emitted * (part / squared));
}

// Fraction of a light that remains at a distance, in units of its range (KHR_lights_punctual).
fn light_fade(distance: f32) -> f32 {
    let squared = distance * distance;
    return clamp(1.0 - squared * squared, 0.0, 1.0);
}
