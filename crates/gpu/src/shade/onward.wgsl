// Shades the hits of secondary rays: crates/umbrage/src/cpu/shade.rs. `shade_seen` has the hits, and the film is that
// of the rays: a colour and planes of ways for each hit.

import package::dispatch::{Invocation, flat_index};
import package::onward::media::{Media, OPEN_AIR, media_innermost};
import package::shade::glass::{attenuation};
import package::shade::hit::{triangle_of};
import package::shade::meeting::{meeting_number, meeting_vector};
import package::shade::meeting_words::{
    MEETING_BLUR, MEETING_BOUNCES, MEETING_DEPTH, MEETING_INSIDE, MEETING_MEDIA, MEETING_MEDIA_COUNT, MEETING_PIXEL,
    MEETING_THROUGH, MEETING_TRAVELLED, MEETING_VIEW, MEETING_WEIGHTS, MEETING_WORDS,
};
import package::shade::reflected::{caught_light, reflected};
import package::shade::surface::{surface_of};
import package::shade::surroundings::{surroundings_are_flat, surroundings_mirrored, surroundings_radiance};
import package::shade::tables::{NO_TRIANGLE, NO_WORD, shade_film, shade_sample, shade_seen};
import package::shade::ways::{Route, Ways, keep_ways, ways_of};

@compute @workgroup_size(64)
fn onward(at: Invocation) {
    let number = flat_index(at, 64u);
    let count = shade_sample.size_pixels.x;
    if number >= count {
        return;
    }
    let word = number * MEETING_WORDS;
    let id = shade_seen[word];
    let view = meeting_vector(word + MEETING_VIEW);
    let bounces = shade_seen[word + MEETING_BOUNCES];
    // Reflections in mirrors hide nothing of the background.
    let is_straight = bounces == 0u;
    var through = meeting_vector(word + MEETING_THROUGH);
    var travelled = meeting_number(word + MEETING_TRAVELLED);
    var around = surroundings_mirrored(-view);
    if is_straight {
        around = surroundings_radiance(-view);
    }
    var ways: Ways;
    var material = 0u;
    var color = around * through;
    var coverage = 0.0;
    // Fraction of the pixel that is shown without tone mapping.
    var flat_part = 0.0;
    if id == NO_TRIANGLE {
        flat_part = select(0.0, mean_of(through), surroundings_are_flat());
    } else {
        let media = meeting_media(word);
        let medium = media_innermost(media);
        if medium != OPEN_AIR {
            through *= attenuation(medium, meeting_number(word + MEETING_INSIDE));
        }
        let weights = vec2<f32>(meeting_number(word + MEETING_WEIGHTS), meeting_number(word + MEETING_WEIGHTS + 1u));
        travelled += meeting_number(word + MEETING_DEPTH);
        var surface = surface_of(id, triangle_of(id), weights, travelled, view);
        if surface.catches_shadows {
            let bare = through * caught_light(surface, number);
            color = around * bare;
            coverage = mean_of(through - bare);
            flat_part = select(0.0, mean_of(bare), surroundings_are_flat());
        } else {
            let part = through * surface.opacity;
            let blur = meeting_number(word + MEETING_BLUR);
            ways = ways_of(surface, Route(through, bounces, blur, shade_seen[word + MEETING_PIXEL], media));
            material = surface.material;
            // Few paths would find the light of narrower highlights, which makes bright specks.
            surface.reflectance.alpha = max(surface.reflectance.alpha, blur);
            color = reflected(surface, number, ways) * part;
            coverage = mean_of(through - ways.passing);
            flat_part = select(0.0, mean_of(part), surface.is_unlit);
        }
    }
    shade_film[number] = vec4<f32>(color, select(0.0, coverage, is_straight));
    if shade_sample.flat_plane != NO_WORD {
        let is_flat = is_straight && flat_part > 0.0;
        shade_film[shade_sample.flat_plane + number] =
            select(vec4<f32>(0.0), vec4<f32>(color, flat_part), is_flat);
    }
    keep_ways(ways, material, travelled, number, count);
}

fn mean_of(color: vec3<f32>) -> f32 {
    return (color.x + color.y + color.z) / 3.0;
}

fn meeting_media(word: u32) -> Media {
    let first = word + MEETING_MEDIA;
    let materials = vec4<u32>(shade_seen[first], shade_seen[first + 1u], shade_seen[first + 2u], shade_seen[first + 3u]);
    return Media(materials, shade_seen[word + MEETING_MEDIA_COUNT]);
}
