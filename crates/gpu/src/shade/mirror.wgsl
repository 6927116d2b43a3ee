// Where a surface mirrors what is followed: crates/umbrage/src/cpu/met.rs.

import package::shade::brdf::{reflectance_view};
import package::shade::coat::{coat_albedo, coat_is_mirror};
import package::shade::layers::{LAYERS};
import package::shade::microfacet::{BRDF_SMOOTHEST};
import package::shade::surface::{Surface};
import package::shade::tables::{shade_sample};

struct Mirror {
    // Unit vector towards what is seen in it.
    direction: vec3<f32>,
    // How much of that reaches the camera.
    through: vec3<f32>,
    // Whether the surface is followed, and whether its coat is.
    is_of_surface: bool,
    is_of_coat: bool,
}

// The mirror that a surface is, of what it sends so much reaching the camera; of nothing where it isn't followed.
fn mirror_of(surface: Surface, part: vec3<f32>) -> Mirror {
    var mirror: Mirror;
    if shade_sample.follows == 0u || surface.is_unlit || surface.catches_shadows {
        return mirror;
    }
    if surface.reflectance.roughness <= BRDF_SMOOTHEST {
        let n_v = max(dot(surface.normal, surface.view), 1e-4);
        let seen = reflectance_view(surface.reflectance, n_v, surface.layers);
        mirror = Mirror(reflect(-surface.view, surface.normal), part * seen.specular, true, false);
    }
    if LAYERS && surface.layers.is_there && surface.layers.has_coat && coat_is_mirror(surface.layers.coat) {
        mirror.is_of_coat = true;
        mirror.through += part * coat_albedo(surface.layers.coat);
        // Where both are mirrors, both are seen in one.
        if !mirror.is_of_surface {
            mirror.direction = reflect(-surface.view, surface.layers.coat.normal);
        }
    }
    let most = max(mirror.through.x, max(mirror.through.y, mirror.through.z));
    // A bent normal may mirror rays into the triangle.
    let is_outside = dot(surface.geometric_normal, mirror.direction) > 0.0;
    if !is_outside || !(most > shade_sample.least_contribution) {
        return Mirror();
    }
    return mirror;
}

// As the film keeps a mirror that is so far from the camera.
fn mirror_ways(mirror: Mirror, travelled: f32) -> array<vec4<f32>, 2> {
    let is_followed = f32(mirror.is_of_surface || mirror.is_of_coat);
    return array(vec4<f32>(mirror.direction, travelled), vec4<f32>(mirror.through, is_followed));
}
