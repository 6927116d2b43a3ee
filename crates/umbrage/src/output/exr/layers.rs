//! The channels of a film's layers.

use ::exr::prelude::FlatSamples;
use glam::Vec2;

use super::cryptomatte;
use crate::{Film, FilmLayers, LightLayer};

/// The names and samples of all layers that there are.
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

/// What each light's channel is called: as the light, with `_` for what isn't a letter, a digit, `-` or `_` of ASCII, or else by its
/// number from 0: where it has no name, one of digits alone, a very long one, or the name of another light.
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
