//! OpenEXR files: a film as numbers, with its layers and the camera.

mod cryptomatte;
mod header;

use std::io;
use std::path::Path;

use ::exr::prelude::{
    AnyChannel, AnyChannels, Compression, Encoding, FlatSamples, Image, Layer, SmallVec, WritableImage, f16,
};
use glam::{Vec2, Vec3, Vec4};

use super::partial_file::Look;
use super::{Error, FrameRate, partial_file};
use crate::{Film, FilmLayers, LightLayer};

/// The bits of colours in an EXR file; depths and normals always have 32.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FloatDepth {
    /// 16 bits: eleven of precision, up to 65,504; larger values are clamped to that.
    #[default]
    Half,
    /// 32 bits.
    Full,
}

/// Writes a film as one part: `R`, `G`, `B`, `A` (linear radiance and coverage), `Z` and `depth.Z` (the same depths),
/// `normal.X`, `normal.Y`, `normal.Z` and `id` (unsigned integers), and its layers. A film without first hits has only its
/// colours and layers. `rate` is that of the animation, if the film is a frame of one.
pub(crate) fn write(
    film: &Film,
    path: &Path,
    depth: FloatDepth,
    rate: Option<FrameRate>,
    look: Look<'_>,
) -> Result<(), Error> {
    let size = (film.width as usize, film.height as usize);
    // ZIP over 16 rows: lossless, and every reader knows it.
    let encoding = Encoding { compression: Compression::ZIP16, ..Encoding::SMALL_LOSSLESS };
    let attributes = header::attributes(film, rate);
    let layer = Layer::new(size, attributes, encoding, AnyChannels::sort(channels(film, depth)));
    partial_file::write(path, look, |file| {
        Image::from_layer(layer).write().to_buffered(file).map_err(|error| match error {
            ::exr::error::Error::Io(source) => source,
            other => io::Error::other(other),
        })
    })
}

fn channels(film: &Film, depth: FloatDepth) -> SmallVec<[AnyChannel<FlatSamples>; 4]> {
    let color = |axis: fn(&Vec4) -> f32| match depth {
        FloatDepth::Half => FlatSamples::F16(film.color.iter().map(|color| nearest_half(axis(color))).collect()),
        FloatDepth::Full => FlatSamples::F32(film.color.iter().map(axis).collect()),
    };
    let normal = |axis: fn(&Vec3) -> f32| FlatSamples::F32(film.normal.iter().map(axis).collect());
    let colors = [
        ("R", color(|color| color.x)),
        ("G", color(|color| color.y)),
        ("B", color(|color| color.z)),
        ("A", color(|color| color.w)),
    ];
    let hits = || {
        [
            // By the name that every compositing program knows, and as a layer.
            ("Z", FlatSamples::F32(film.depth.clone())),
            ("depth.Z", FlatSamples::F32(film.depth.clone())),
            ("normal.X", normal(|normal| normal.x)),
            ("normal.Y", normal(|normal| normal.y)),
            ("normal.Z", normal(|normal| normal.z)),
            ("id", FlatSamples::U32(film.triangle.clone())),
        ]
    };
    let hits = (!film.triangle.is_empty()).then(hits).into_iter().flatten();
    colors
        .into_iter()
        .chain(hits)
        .map(|(name, samples)| (name.to_owned(), samples))
        .chain(layer_channels(film))
        .map(|(name, samples)| AnyChannel::new(name.as_str(), samples))
        .collect()
}

/// The nearest half-precision value; the largest finite one for larger values.
fn nearest_half(value: f32) -> f16 {
    f16::from_f32(if value.is_finite() { value.clamp(f16::MIN.to_f32(), f16::MAX.to_f32()) } else { value })
}

/// The names and samples of all layers of a film.
fn layer_channels(film: &Film) -> Vec<(String, FlatSamples)> {
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
        if !film.triangle.is_empty() {
            channels.push(("ids.triangle".to_owned(), FlatSamples::U32(film.triangle.clone())));
        }
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
    use ::exr::prelude::read_all_flat_layers_from_file;

    use super::*;

    fn film() -> Film {
        let pixels = 0..5 * 3_u16;
        Film {
            width: 5,
            height: 3,
            color: pixels.clone().map(|pixel| Vec4::new(f32::from(pixel) * 0.37, 1e-3, 1e6, 0.5)).collect(),
            flat: Vec::new(),
            depth: pixels.clone().map(|pixel| 1.0 / f32::from(pixel)).collect(),
            normal: pixels.clone().map(|pixel| Vec3::new(0.1, f32::from(pixel), -0.3)).collect(),
            triangle: pixels.map(|pixel| if pixel == 3 { Film::NO_TRIANGLE } else { 1 << pixel }).collect(),
            ..Film::default()
        }
    }

    fn read(depth: FloatDepth) -> impl Fn(&str) -> FlatSamples {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        write(&film(), &path, depth, None, &mut |_| Ok(())).unwrap();
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
        let image = read_all_flat_layers_from_file(&path).unwrap();
        let layer = image.layer_data.into_iter().next().unwrap();
        assert_eq!((layer.size.0, layer.size.1), (5, 3));
        move |name| {
            let channel = layer.channel_data.list.iter().find(|channel| channel.name.to_string() == name);
            channel.unwrap_or_else(|| panic!("no channel {name}")).sample_data.clone()
        }
    }

    #[test]
    fn full_floats_come_back_exactly() {
        let channel = read(FloatDepth::Full);
        let film = film();
        assert_eq!(channel("R"), FlatSamples::F32(film.color.iter().map(|color| color.x).collect()));
        assert_eq!(channel("G"), FlatSamples::F32(vec![1e-3; 15]));
        assert_eq!(channel("B"), FlatSamples::F32(vec![1e6; 15]));
        assert_eq!(channel("A"), FlatSamples::F32(vec![0.5; 15]));
        assert_eq!(channel("Z"), channel("depth.Z"));
        assert_eq!(channel("depth.Z"), FlatSamples::F32(film.depth));
        assert_eq!(channel("normal.X"), FlatSamples::F32(vec![0.1; 15]));
        assert_eq!(channel("normal.Z"), FlatSamples::F32(vec![-0.3; 15]));
        assert_eq!(channel("normal.Y"), FlatSamples::F32(film.normal.iter().map(|normal| normal.y).collect()));
        assert_eq!(channel("id"), FlatSamples::U32(film.triangle));
    }

    #[test]
    fn a_film_without_first_hits_has_no_channels_of_them() {
        let bare = Film { depth: Vec::new(), normal: Vec::new(), triangle: Vec::new(), ..film() };
        let names = channels(&bare, FloatDepth::Half).into_iter().map(|channel| channel.name.to_string());
        assert_eq!(names.collect::<Vec<_>>(), ["R", "G", "B", "A"]);
    }

    #[test]
    fn halves_are_nearest_and_finite() {
        let channel = read(FloatDepth::Half);
        let FlatSamples::F16(red) = channel("R") else { panic!("R is not half") };
        for (half, color) in red.iter().zip(film().color) {
            assert!((half.to_f32() - color.x).abs() <= color.x / 2048.0);
        }
        assert_eq!(channel("B"), FlatSamples::F16(vec![f16::MAX; 15]));
        assert_eq!(channel("id"), FlatSamples::U32(film().triangle));
    }

    #[test]
    fn lights_have_channels_of_their_own() {
        let names = ["key", "", "rim light.001", "7", "twin", "twin", "été", "日", &"x".repeat(99)];
        let lights = names.map(|name| LightLayer { name: name.into(), lit: Vec::new() });
        let expected = ["key", "1", "rim_light_001", "3", "4", "5", "_t_", "7", "8"];
        assert_eq!(names_of_lights(&lights), expected);
    }
}
