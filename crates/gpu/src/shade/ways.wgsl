// Directions from which light comes to a followed surface: crates/umbrage/src/cpu/met.rs and onward.rs.

import package::onward::media::{Media};
import package::onward::way::{
    ALL_WAYS, WAYS_OF_MIRRORS, WAY_ALL_COLORS, WAY_BEHIND, WAY_CROSSES, WAY_FRONT, WAY_MIRROR, WAY_RED,
};
import package::shade::brdf::{ReflectanceView, reflectance_of_facet, reflectance_view};
import package::shade::coat::{coat_albedo, coat_is_mirror};
import package::shade::drawn::{DRAWN_FACET, drawn_point};
import package::shade::glass::{media_disperse, media_ratio, reflected_part, refracted};
import package::shade::gloss::{
    facets_mean_width, facets_of, facets_round, facets_unshadowed, facets_unshadowed_behind, facets_visible,
};
import package::shade::layers::{LAYERS};
import package::shade::microfacet::{BRDF_SMOOTHEST};
import package::shade::surface::{Surface};
import package::shade::tables::{shade_film, shade_sample};

// Whether rough surfaces mirror as well: one direction of each highlight.
override GLOSS: bool = false;

struct Ways {
    // Sum of WAY_… bits.
    bits: u32,
    // Unit vector of the mirrored ray, and its throughput to the camera.
    direction: vec3<f32>,
    through: vec3<f32>,
    // Whether the mirrored ray replaces the surroundings' reflection in the surface, and in its coat.
    is_of_surface: bool,
    is_of_coat: bool,
    // Whether the surface is seen from inside of a volume, so that it has no other light.
    is_inside: bool,
    // Largest GGX width of rough surfaces along the ways.
    blur: f32,
    // Throughput of light from straight behind to the camera.
    passing: vec3<f32>,
    // Directions of refracted light, of red, green and blue, and its throughput to the camera.
    refracted: array<vec3<f32>, 3>,
    refracted_through: vec3<f32>,
}

// Straight transmittance of a surface.
fn passing_at(surface: Surface) -> vec3<f32> {
    var transmitted = surface.transmitted;
    if any(transmitted != vec3<f32>(0.0)) {
        // Mirrored light isn't transmitted.
        let n_v = max(dot(surface.normal, surface.view), 1e-4);
        transmitted *= reflectance_view(surface.reflectance, n_v, surface.layers).entering;
    }
    return mix(vec3<f32>(1.0), transmitted, surface.opacity);
}

// Path of light from a surface to the camera.
struct Route {
    // Throughput to the camera.
    through: vec3<f32>,
    // Number of mirrors and glass surfaces, and the largest GGX width of rough ones among them.
    bounces: u32,
    blur: f32,
    // The path's pixel.
    pixel: u32,
    // Media behind the surface.
    media: Media,
}

// Directions from which a surface gets its visible light.
fn ways_of(surface: Surface, route: Route) -> Ways {
    var ways: Ways;
    let through = route.through;
    let part = through * surface.opacity;
    ways.blur = route.blur;
    let is_followed = route.bounces < shade_sample.bounces && !surface.is_unlit && !surface.catches_shadows;
    let is_glass = is_followed && surface.is_volume && any(surface.transmitted != vec3<f32>(0.0));
    ways.passing = through * passing_at(surface);
    if is_glass {
        ways.passing = through * (1.0 - surface.opacity);
        ways.is_inside = !surface.is_front;
        go_through_glass(surface, part, route, &ways);
    } else if is_followed {
        go_by_mirror(surface, part, route, &ways);
    }
    if any(ways.passing > vec3<f32>(0.0)) {
        ways.bits |= WAY_BEHIND;
        if surface.is_volume && route.media.count > 0u {
            // Glass that isn't followed any further counts as a thin pane.
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

fn go_by_mirror(surface: Surface, part: vec3<f32>, route: Route, ways: ptr<function, Ways>) {
    let is_of_surface = surface.reflectance.roughness <= BRDF_SMOOTHEST;
    let has_coat = LAYERS && surface.layers.is_there && surface.layers.has_coat;
    let is_of_coat = has_coat && coat_is_mirror(surface.layers.coat);
    let n_v = max(dot(surface.normal, surface.view), 1e-4);
    let seen = reflectance_view(surface.reflectance, n_v, surface.layers);
    var direction = reflect(-surface.view, surface.normal);
    var through = part * seen.specular;
    var most = most_of(through);
    if has_coat {
        let of_coat = part * coat_albedo(surface.layers.coat);
        if is_of_coat {
            through = select(vec3<f32>(0.0), through, is_of_surface) + of_coat;
            most = most_of(through);
            // If both are mirrors, one direction serves both.
            if !is_of_surface {
                direction = reflect(-surface.view, surface.layers.coat.normal);
            }
        } else if GLOSS {
            most = max(most, most_of(of_coat));
        }
    }
    let is_mirror = is_of_surface || is_of_coat;
    // A bent normal may mirror rays into the triangle.
    let is_outside = dot(surface.geometric_normal, direction) > 0.0;
    if !(most > shade_sample.least_contribution) {
        return;
    }
    if GLOSS {
        if is_outside || !is_mirror {
            (*ways).is_of_surface = true;
            (*ways).is_of_coat = true;
            (*ways).direction = direction;
            (*ways).through = through;
            go_by_one_of_many(surface, part, route, seen, ways);
        }
    } else if is_mirror && is_outside {
        (*ways).bits |= WAY_MIRROR;
        (*ways).direction = direction;
        (*ways).through = through;
        (*ways).is_of_surface = is_of_surface;
        (*ways).is_of_coat = is_of_coat;
    }
}

// Chooses the coat of a surface or the layer below it, in proportion to their reflection, and one of its microfacets.
// `ways` has the smooth mirror on entry.
fn go_by_one_of_many(
    surface: Surface,
    part: vec3<f32>,
    route: Route,
    seen: ReflectanceView,
    ways: ptr<function, Ways>,
) {
    let is_smooth = surface.reflectance.roughness <= BRDF_SMOOTHEST;
    var point = drawn_point(route.pixel, route.bounces, DRAWN_FACET);
    var share = 1.0;
    var takes_mirror = is_smooth;
    var facets = facets_of(surface.normal, surface.reflectance.alpha, surface.layers);
    var takes_coat = false;
    if LAYERS && surface.layers.is_there && surface.layers.has_coat && surface.layers.coat.part > 0.0 {
        let coat = surface.layers.coat;
        if !(is_smooth && coat_is_mirror(coat)) {
            let of_coat = coat.part / (coat.part + most_of(seen.specular));
            takes_coat = point.x < of_coat;
            // The rest of the number is as evenly distributed.
            share = select(1.0 - of_coat, of_coat, takes_coat);
            point.x = select((point.x - of_coat) / (1.0 - of_coat), point.x / of_coat, takes_coat);
            if takes_coat {
                takes_mirror = coat_is_mirror(coat);
                // Its bumps may face away, and mirror as much then.
                let faces = dot(surface.view, coat.normal) >= 0.0;
                facets = facets_round(select(-coat.normal, coat.normal, faces), sqrt(coat.a2));
            }
        }
    }
    if takes_mirror {
        (*ways).bits |= WAY_MIRROR;
        (*ways).through /= share;
        return;
    }
    let facet = facets_visible(facets, surface.view, point);
    let cosine = dot(surface.view, facet);
    var direction = facet * (2.0 * cosine) - surface.view;
    if !(dot(direction, facets.normal) > 0.0) {
        return;
    }
    let kept = facets_unshadowed(facets, surface.view, direction);
    let height = dot(direction, surface.geometric_normal);
    if height <= 0.0 {
        // A bent normal mirrors it into the triangle: the direction above it stands in, or rims would be black.
        direction -= surface.geometric_normal * (2.0 * height);
    }
    var reflected = reflectance_of_facet(surface.reflectance, seen, cosine, surface.layers);
    if takes_coat {
        reflected = vec3<f32>(surface.layers.coat.part);
    }
    (*ways).bits |= WAY_MIRROR;
    (*ways).direction = direction;
    (*ways).through = part * reflected * (kept / share);
    (*ways).blur = max(route.blur, facets_mean_width(facets));
}

fn go_through_glass(surface: Surface, part: vec3<f32>, route: Route, ways: ptr<function, Ways>) {
    let media = route.media;
    let is_smooth = surface.reflectance.roughness <= BRDF_SMOOTHEST;
    let is_rough = GLOSS && !is_smooth;
    (*ways).is_of_surface = is_smooth || is_rough;
    let facets = facets_of(surface.normal, surface.reflectance.alpha, surface.layers);
    var normal = surface.normal;
    if is_rough {
        normal = facets_visible(facets, surface.view, drawn_point(route.pixel, route.bounces, DRAWN_FACET));
        (*ways).blur = max(route.blur, facets_mean_width(facets));
    }
    let cosine = clamp(dot(surface.view, normal), 0.0, 1.0);
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
            var direction = refracted(-surface.view, normal, ratio);
            if !(dot(direction, surface.geometric_normal) < 0.0) {
                // A bent normal may refract rays out of the triangle.
                direction = refracted(-surface.view, surface.geometric_normal, ratio);
            }
            if dot(direction, surface.geometric_normal) < 0.0 {
                (*ways).bits |= select(WAY_ALL_COLORS, WAY_RED << color, are_apart);
                (*ways).refracted[color] = direction;
                (*ways).refracted_through +=
                    through * select(1.0, facets_unshadowed_behind(facets, direction), is_rough);
            }
        }
    }
    let direction = normal * (2.0 * cosine) - surface.view;
    let is_outside = dot(direction, surface.geometric_normal) > 0.0;
    if (is_smooth || is_rough) && is_outside && most_of(mirrored) > shade_sample.least_contribution {
        (*ways).bits |= WAY_MIRROR;
        (*ways).direction = direction;
        (*ways).through = mirrored * select(1.0, facets_unshadowed_behind(facets, direction), is_rough);
    }
}

// Writes the ways of a surface at distance `travelled` from the camera, in planes of `stride` pixels or rays.
fn keep_ways(ways: Ways, material: u32, travelled: f32, index: u32, stride: u32) {
    var to = shade_sample.ways_plane + index;
    var bits = ways.bits;
    let has_all = shade_sample.ways_count >= ALL_WAYS;
    if !has_all {
        bits &= WAY_MIRROR;
    }
    shade_film[to] = vec4<f32>(ways.direction, travelled);
    shade_film[to + stride] = vec4<f32>(ways.through, f32(bits));
    if !has_all {
        return;
    }
    if shade_sample.ways_count > ALL_WAYS {
        shade_film[to + ALL_WAYS * stride] = vec4<f32>(ways.blur, 0.0, 0.0, 0.0);
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
