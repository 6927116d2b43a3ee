//! The textures of materials; each image is decoded once per combination of colour space, filter and wrap.

use std::collections::HashMap;

use gltf::json;
use gltf::json::texture::{MagFilter, MinFilter, Sampler, WrappingMode};
use gltf::json::validation::Checked;
use rayon::prelude::*;
use umbrage_scene::{ColorSpace, Error, Filter, Texture, Wrap};

use super::document::Document;
use super::extensions::AVIF;
use crate::texture::{READS_AVIF, decode_within};

/// An image with its colour space, filter and wrap modes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct TextureSource {
    image: usize,
    space: ColorSpace,
    filter: Filter,
    wrap: [Wrap; 2],
}

/// The textures requested by materials so far, not decoded yet.
#[derive(Debug, Default)]
pub(super) struct Textures {
    readings: Vec<TextureSource>,
    numbers: HashMap<TextureSource, u32>,
}

impl Textures {
    /// Returns the number of the file's texture `index` in `space`; `None`, with a warning, where it has no usable image.
    ///
    /// # Errors
    /// Where an index is out of range.
    pub(super) fn number(
        &mut self,
        document: &Document,
        index: usize,
        space: ColorSpace,
        location: &str,
        warnings: &mut Vec<String>,
    ) -> Result<Option<u32>, Error> {
        let json = document.element(&document.json.textures, "textures", index, format_args!("{location}.index"))?;
        let own_location = format_args!("textures[{index}]");
        let sampler = match json.sampler {
            Some(sampler) => {
                let location = format_args!("{own_location}.sampler");
                document.element(&document.json.samplers, "samplers", sampler.value(), location)?
            }
            None => &Sampler::default(),
        };
        let Some(image) = image(document, json, index)? else {
            warnings.push(format!("{own_location} was left out, as its image is in a format that is not read"));
            return Ok(None);
        };
        let reading =
            TextureSource { image, space, filter: filter(sampler), wrap: [wrap(sampler.wrap_s), wrap(sampler.wrap_t)] };
        let number = *self.numbers.entry(reading).or_insert_with(|| {
            self.readings.push(reading);
            self.readings.len() as u32 - 1
        });
        Ok(Some(number))
    }

    /// Decodes the images, and returns a texture or an error for each number. Runs in parallel, but serially where textures
    /// are kept on demand, so that only one image is in memory.
    pub(super) fn decode(self, document: &Document) -> Vec<Result<Texture, String>> {
        if document.budget.keeps_textures_on_demand() {
            return self.readings.iter().map(|reading| decode(document, reading)).collect();
        }
        self.readings.into_par_iter().map(|reading| decode(document, &reading)).collect()
    }
}

/// Chooses the image of texture `index`: one of a supported extension, else the plain one, else one of an unsupported
/// format, whose decoder reports the error.
///
/// # Errors
/// Where the image doesn't exist.
fn image(document: &Document, json: &json::Texture, index: usize) -> Result<Option<usize>, Error> {
    // The parsing library's marker of a texture without a plain image.
    const NO_SOURCE: usize = u32::MAX as usize;
    let in_extension = |name: &str| {
        let source = json.extensions.as_ref().and_then(|extensions| extensions.others.get(name)?.get("source"))?;
        let image = source.as_u64().and_then(|image| usize::try_from(image).ok()).unwrap_or(usize::MAX);
        Some((image, format!("textures[{index}].extensions.{name}.source")))
    };
    let plain =
        || (json.source.value() != NO_SOURCE).then(|| (json.source.value(), format!("textures[{index}].source")));
    let in_avif = || in_extension(AVIF);
    let read = ["KHR_texture_basisu", "EXT_texture_webp"].into_iter().find_map(in_extension);
    let read = read.or_else(|| in_avif().filter(|_| READS_AVIF));
    let Some((image, location)) = read.or_else(plain).or_else(in_avif) else {
        return Ok(None);
    };
    document.element(&document.json.images, "images", image, location)?;
    Ok(Some(image))
}

fn decode(document: &Document, reading: &TextureSource) -> Result<Texture, String> {
    // Longer image files are refused: their image would be too large anyway.
    const MAX_BYTES: u64 = 1 << 30;
    let number = reading.image;
    let json = &document.json.images[number];
    let location = format!("images[{number}]");
    let embedded = |uri: &str| uri.get(..5).is_some_and(|scheme| scheme.eq_ignore_ascii_case("data:"));
    let name = match (&json.name, &json.uri) {
        (Some(name), _) => name.clone(),
        (None, Some(uri)) if !embedded(uri) => uri.clone(),
        _ => location.clone(),
    };
    let budget = document.budget.in_passing();
    let mut fetched = Vec::new();
    let bytes = match (json.buffer_view, &json.uri) {
        (Some(view), _) => {
            let view = document.view(view.value(), format_args!("{location}.bufferView"));
            view.map_err(|error| error.to_string())?.0
        }
        (None, Some(uri)) => {
            document.fetch(uri, MAX_BYTES, &mut fetched, &budget).map_err(|cause| format!("{location}: {cause}"))?;
            &fetched
        }
        (None, None) => return Err(format!("{location}: it has neither a bufferView nor a uri")),
    };
    decode_within(&budget, name, bytes, reading.space, reading.filter, reading.wrap)
        .map_err(|cause| format!("{location}: {cause}"))
}

fn filter(sampler: &Sampler) -> Filter {
    match (sampler.mag_filter, sampler.min_filter) {
        (Some(Checked::Valid(MagFilter::Nearest)), _)
        | (None, Some(Checked::Valid(MinFilter::Nearest | MinFilter::NearestMipmapNearest))) => Filter::Nearest,
        _ => Filter::Linear,
    }
}

fn wrap(mode: Checked<WrappingMode>) -> Wrap {
    match mode {
        Checked::Valid(WrappingMode::ClampToEdge) => Wrap::ClampToEdge,
        Checked::Valid(WrappingMode::MirroredRepeat) => Wrap::MirroredRepeat,
        Checked::Valid(WrappingMode::Repeat) | Checked::Invalid => Wrap::Repeat,
    }
}
