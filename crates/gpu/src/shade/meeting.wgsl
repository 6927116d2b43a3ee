// Reads the hits of secondary rays from `shade_seen`.

import package::shade::tables::{shade_seen};

fn meeting_number(word: u32) -> f32 {
    return bitcast<f32>(shade_seen[word]);
}

fn meeting_vector(word: u32) -> vec3<f32> {
    return vec3<f32>(meeting_number(word), meeting_number(word + 1u), meeting_number(word + 2u));
}
