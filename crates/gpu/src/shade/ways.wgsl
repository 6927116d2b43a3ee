// From where light comes to a surface that is followed: crates/umbrage/src/cpu/met.rs and onward.rs.

import package::onward::media::{Media};
import package::onward::way::{
    ALL_WAYS, WAYS_OF_MIRRORS, WAY_ALL_COLORS, WAY_BEHIND, WAY_CROSSES, WAY_FRONT, WAY_MIRROR, WAY_RED,
};
import package::shade::brdf::{reflectance_view};
import package::shade::coat::{coat_albedo, coat_is_mirror};
import package::shade::glass::{media_disperse, media_ratio, reflected_part, refracted};
import package::shade::layers::{LAYERS};
import package::shade::microfacet::{BRDF_SMOOTHEST};
import package::shade::surface::{Surface};
import package::shade::tables::{shade_film, shade_sample};

struct Ways {
    // WAY_… added up.
    bits: u32,
    // Unit vector towards what is seen in a mirror, and how much of that reaches the camera.
    direction: vec3<f32>,
    through: vec3<f32>,
    // Whether that is in place of what is around the surface, and of what is around its coat.
    is_of_surface: bool,
    is_of_coat: bool,
    // Whether light comes only from where it is followed to.
    is_inside: bool,
    // How much of what is straight behind reaches the camera.
    passing: vec3<f32>,
    // Where light is refracted to, of red, green and blue, and how much of it reaches the camera.
    refracted: array<vec3<f32>, 3>,
    refracted_through: vec3<f32>,
}

// How much of what is straight behind a surface it shows.
fn passing_at(surface: Surface) -> vec3<f32> {
    var transmitted = surface.transmitted;
    if any(transmitted != vec3<f32>(0.0)) {
        // What the surface mirrors doesn't pass.
        let n_v = max(dot(surface.normal, surface.view), 1e-4);
        transmitted *= reflectance_view(surface.reflectance, n_v, surface.layers).entering;
    }
    return mix(vec3<f32>(1.0), transmitted, surface.opacity);
}

// Where what a surface shows comes from. So much of that reaches the camera, by so many bounces and through such media.
fn ways_of(surface: Surface, through: vec3<f32>, bounces: u32, media: Media) -> Ways {
    var ways: Ways;
    let part = through * surface.opacity;
    let is_followed = bounces < shade_sample.bounces && !surface.is_unlit && !surface.catches_shadows;
    let is_glass = is_followed && surface.is_volume && any(surface.transmitted != vec3<f32>(0.0));
    ways.passing = through * passing_at(surface);
    if is_glass {
        ways.passing = through * (1.0 - surface.opacity);
        ways.is_inside = !surface.is_front;
        go_through_glass(surface, part, media, &ways);
    } else if is_followed {
        go_by_mirror(surface, part, &ways);
    }
    if any(ways.passing > vec3<f32>(0.0)) {
        ways.bits |= WAY_BEHIND;
        if surface.is_volume && media.count > 0u {
            // Where glass isn't followed any further, it is as thin as a pane.
            ways.bits |= WAY_CROSSES;
        }
    }
    if surface.is_front {
        ways.bits |= WAY_FRONT;
    }
    return ways;
}

fn most_of(color: vec3<f32>) -> f32 {
    return max(color.x, max(color.y, color.z));
}

fn go_by_mirror(surface: Surface, part: vec3<f32>, ways: ptr<function, Ways>) {
    let is_of_surface = surface.reflectance.roughness <= BRDF_SMOOTHEST;
    var is_of_coat = false;
    var direction = reflect(-surface.view, surface.normal);
    var through = vec3<f32>(0.0);
    if is_of_surface {
        let n_v = max(dot(surface.normal, surface.view), 1e-4);
        through = part * reflectance_view(surface.reflectance, n_v, surface.layers).specular;
    }
    if LAYERS && surface.layers.is_there && surface.layers.has_coat && coat_is_mirror(surface.layers.coat) {
        is_of_coat = true;
        through += part * coat_albedo(surface.layers.coat);
        // Where both are mirrors, both are seen in one.
        if !is_of_surface {
            direction = reflect(-surface.view, surface.layers.coat.normal);
        }
    }
    // A bent normal may mirror rays into the triangle.
    let is_outside = dot(surface.geometric_normal, direction) > 0.0;
    if (is_of_surface || is_of_coat) && is_outside && most_of(through) > shade_sample.least_contribution {
        (*ways).bits |= WAY_MIRROR;
        (*ways).direction = direction;
        (*ways).through = through;
        (*ways).is_of_surface = is_of_surface;
        (*ways).is_of_coat = is_of_coat;
    }
}

fn go_through_glass(surface: Surface, part: vec3<f32>, media: Media, ways: ptr<function, Ways>) {
    let is_smooth = surface.reflectance.roughness <= BRDF_SMOOTHEST;
    (*ways).is_of_surface = is_smooth;
    let cosine = clamp(dot(surface.view, surface.normal), 0.0, 1.0);
    let are_apart = media_disperse(media, surface.material);
    var mirrored = vec3<f32>(0.0);
    for (var color = 0u; color < 3u; color++) {
        var channels = vec3<f32>(1.0);
        if are_apart {
            channels = vec3<f32>(0.0);
            channels[color] = 1.0;
        } else if color > 0u {
            break;
        }
        let ratio = media_ratio(media, surface.material, surface.is_front, select(0.0, f32(color) - 1.0, are_apart));
        let reflected = reflected_part(cosine, ratio);
        mirrored += part * channels * reflected;
        let through = part * channels * surface.transmitted * (1.0 - reflected);
        if most_of(through) > shade_sample.least_contribution {
            var direction = refracted(-surface.view, surface.normal, ratio);
            if !(dot(direction, surface.geometric_normal) < 0.0) {
                // A bent normal may refract rays out of the triangle.
                direction = refracted(-surface.view, surface.geometric_normal, ratio);
            }
            if dot(direction, surface.geometric_normal) < 0.0 {
                (*ways).bits |= select(WAY_ALL_COLORS, WAY_RED << color, are_apart);
                (*ways).refracted[color] = direction;
                (*ways).refracted_through += through;
            }
        }
    }
    let direction = surface.normal * (2.0 * cosine) - surface.view;
    let is_outside = dot(direction, surface.geometric_normal) > 0.0;
    if is_smooth && is_outside && most_of(mirrored) > shade_sample.least_contribution {
        (*ways).bits |= WAY_MIRROR;
        (*ways).direction = direction;
        (*ways).through = mirrored;
    }
}

// Keeps ways of a surface that is so far from the camera, in planes of so many pixels or rays.
fn keep_ways(ways: Ways, material: u32, travelled: f32, index: u32, stride: u32) {
    var to = shade_sample.ways_plane + index;
    var bits = ways.bits;
    let has_all = shade_sample.ways_count == ALL_WAYS;
    if !has_all {
        bits &= WAY_MIRROR;
    }
    shade_film[to] = vec4<f32>(ways.direction, travelled);
    shade_film[to + stride] = vec4<f32>(ways.through, f32(bits));
    if !has_all {
        return;
    }
    to += WAYS_OF_MIRRORS * stride;
    shade_film[to] = vec4<f32>(ways.passing, f32(material));
    if (bits & WAY_ALL_COLORS) != 0u {
        shade_film[to + stride] = vec4<f32>(ways.refracted[0], 0.0);
        shade_film[to + 2u * stride] = vec4<f32>(ways.refracted_through, 0.0);
        return;
    }
    for (var color = 0u; color < 3u; color++) {
        shade_film[to + (1u + color) * stride] = vec4<f32>(ways.refracted[color], ways.refracted_through[color]);
    }
}
