// Shades what rays from mirrors have met: crates/umbrage/src/cpu/shade.rs. `shade_seen` has the meetings, and the film is
// that of the rays, with a colour and two planes for the mirrors that they meet.

import package::dispatch::{Invocation, flat_index};
import package::shade::hit::{triangle_of};
import package::shade::meeting::{
    MEETING_DEPTH, MEETING_THROUGH, MEETING_TRAVELLED, MEETING_VIEW, MEETING_WEIGHTS, MEETING_WORDS,
};
import package::shade::mirror::{Mirror, mirror_of, mirror_ways};
import package::shade::reflected::{caught_light, reflected};
import package::shade::surface::{surface_of};
import package::shade::surroundings::{surroundings_mirrored};
import package::shade::tables::{NO_TRIANGLE, shade_film, shade_sample, shade_seen};

@compute @workgroup_size(64)
fn onward(at: Invocation) {
    let number = flat_index(at, 64u);
    let count = shade_sample.size_pixels.x;
    if number >= count {
        return;
    }
    let word = number * MEETING_WORDS;
    let id = shade_seen[word];
    let view = vec3<f32>(
        meeting_number(word + MEETING_VIEW),
        meeting_number(word + MEETING_VIEW + 1u),
        meeting_number(word + MEETING_VIEW + 2u),
    );
    let through = vec3<f32>(
        meeting_number(word + MEETING_THROUGH),
        meeting_number(word + MEETING_THROUGH + 1u),
        meeting_number(word + MEETING_THROUGH + 2u),
    );
    var mirror: Mirror;
    var color: vec3<f32>;
    var travelled = meeting_number(word + MEETING_TRAVELLED);
    if id == NO_TRIANGLE {
        color = surroundings_mirrored(-view) * through;
    } else {
        let weights = vec2<f32>(meeting_number(word + MEETING_WEIGHTS), meeting_number(word + MEETING_WEIGHTS + 1u));
        travelled += meeting_number(word + MEETING_DEPTH);
        let surface = surface_of(id, triangle_of(id), weights, travelled, view);
        if surface.catches_shadows {
            color = surroundings_mirrored(-view) * through * caught_light(surface, number);
        } else {
            let part = through * surface.opacity;
            mirror = mirror_of(surface, part);
            color = reflected(surface, number, mirror) * part;
        }
    }
    // What is seen in mirrors hides nothing of the background.
    shade_film[number] = vec4<f32>(color, 0.0);
    let ways = mirror_ways(mirror, travelled);
    shade_film[shade_sample.ways_plane + number] = ways[0];
    shade_film[shade_sample.ways_plane + count + number] = ways[1];
}

fn meeting_number(word: u32) -> f32 {
    return bitcast<f32>(shade_seen[word]);
}
