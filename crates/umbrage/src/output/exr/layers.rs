//! The channels of a film's layers.

use ::exr::prelude::FlatSamples;
use glam::Vec2;

use super::cryptomatte;
use crate::{Film, FilmLayers, LightLayer};

/// The names and samples of all layers of a film.
pub(super) fn channels(film: &Film) -> Vec<(String, FlatSamples)> {
    let FilmLayers { shadow, motion, barycentric, object, .. } = &film.layers;
    let mut channels: Vec<(String, FlatSamples)> = Vec::new();
    for (layer, name) in shadow.iter().zip(names_of_lights(shadow)) {
        channels.push((format!("shadow.{name}"), FlatSamples::F32(layer.lit.clone())));
    }
    for (vectors, names) in [(motion, ["motion.X", "motion.Y"]), (barycentric, ["barycentric.u", "barycentric.v"])] {
        let axes: [fn(&Vec2) -> f32; 2] = [|vector| vector.x, |vector| vector.y];
        for (name, axis) in names.into_iter().zip(axes).filter(|_| !vectors.is_empty()) {
            channels.push((name.to_owned(), FlatSamples::F32(vectors.iter().map(axis).collect())));
        }
    }
    if !object.is_empty() {
        channels.push(("ids.object".to_owned(), FlatSamples::U32(object.clone())));
        channels.push(("ids.triangle".to_owned(), FlatSamples::U32(film.triangle.clone())));
    }
    channels.extend(cryptomatte::channels(&film.layers));
    channels
}

/// The name of each light's channel: the light's, with `_` for every character but ASCII letters, digits, `-` and `_`. It is
/// the light's index from 0 where the name has no letter, is very long, or is another light's too.
fn names_of_lights(lights: &[LightLayer]) -> Vec<String> {
    const MOST_LETTERS: usize = 64;
    let is_plain = |letter: char| letter.is_ascii_alphanumeric() || letter == '-' || letter == '_';
    let plain = |light: &LightLayer| -> String {
        light.name.chars().map(|letter| if is_plain(letter) { letter } else { '_' }).collect()
    };
    let names: Vec<String> = lights.iter().map(plain).collect();
    let is_usable = |name: &String| {
        let is_name = name.chars().any(|letter| letter.is_ascii_alphabetic()) && name.len() <= MOST_LETTERS;
        is_name && names.iter().filter(|other| *other == name).count() == 1
    };
    names.iter().enumerate().map(|(n, name)| if is_usable(name) { name.clone() } else { n.to_string() }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lights_have_channels_of_their_own() {
        let names = ["key", "", "rim light.001", "7", "twin", "twin", "été", "日", &"x".repeat(99)];
        let lights = names.map(|name| LightLayer { name: name.into(), lit: Vec::new() });
        let expected = ["key", "1", "rim_light_001", "3", "4", "5", "_t_", "7", "8"];
        assert_eq!(names_of_lights(&lights), expected);
    }
}
