//! Textures of image files.

use umbrage_scene::{ColorSpace, Filter, Texture, Wrap};

use crate::image_file::{self, ImageFormat};
use crate::memory::Budget;

#[cfg(all(feature = "avif", not(target_family = "wasm")))]
mod avif;
mod ktx2;

/// Decodes an image file (PNG, JPEG, WebP, BMP, TGA or KTX2, and with the feature `avif` AVIF).
///
/// # Errors
/// A message, where the bytes aren't such an image or it is larger than [`Texture::MAX_SIDE`].
pub fn decode_texture(
    name: impl Into<String>,
    bytes: &[u8],
    space: ColorSpace,
    filter: Filter,
    wrap: [Wrap; 2],
) -> Result<Texture, String> {
    decode_within(&Budget::default(), name, bytes, space, filter, wrap)
}

/// As [`decode_texture`], within a budget of memory.
///
/// # Errors
/// As [`decode_texture`], and where the budget is too small.
pub(crate) fn decode_within(
    budget: &Budget,
    name: impl Into<String>,
    bytes: &[u8],
    space: ColorSpace,
    filter: Filter,
    wrap: [Wrap; 2],
) -> Result<Texture, String> {
    let (size, texels) = decode_texels(bytes, budget)?;
    kept_by(Texture::new(name, size, texels, space, filter, wrap), budget)
}

/// Moves a texture's texels to the budget's pool, if it has one.
///
/// # Errors
/// A message why they can't be kept there.
pub(crate) fn kept_by(texture: Texture, budget: &Budget) -> Result<Texture, String> {
    let Some(pool) = budget.tile_pool()? else { return Ok(texture) };
    let texture = texture.kept_in(pool)?;
    budget.keep(texture.bytes() as u64, "the tables of textures on demand")?;
    Ok(texture)
}

/// Takes memory for an image of this size: its mip levels and its opacity bounds.
///
/// # Errors
/// A message, where too little is left.
pub(crate) fn take([width, height]: [u32; 2], budget: &Budget) -> Result<(), String> {
    const BYTES: u64 = 8;
    let bytes = BYTES.saturating_mul(u64::from(width)).saturating_mul(u64::from(height));
    budget.take(bytes, format_args!("an image of {width}x{height} texels"))
}

/// Width and height, at least 1, and the RGBA texels of an image file, the upper row first.
///
/// # Errors
/// As [`decode_within`].
pub(crate) fn decode_texels(bytes: &[u8], budget: &Budget) -> Result<([u32; 2], Vec<[u8; 4]>), String> {
    if ktx2::is_ktx2(bytes) {
        return ktx2::decode(bytes, budget);
    }
    if is_avif(bytes) {
        #[cfg(all(feature = "avif", not(target_family = "wasm")))]
        return avif::decode(bytes, budget);
        #[cfg(not(any(feature = "avif", target_family = "wasm")))]
        return Err(AVIF_LEFT_OUT.to_owned());
        #[cfg(target_family = "wasm")]
        return Err("AVIF images are not read in browsers; convert it to PNG, as with ImageMagick or GIMP".to_owned());
    }
    // TGA is the only format without a signature.
    let format = image_file::format(bytes).unwrap_or(ImageFormat::Tga);
    let image = image_file::decode(bytes, format, budget.all(), &mut |[width, height]| {
        if width == 0 || height == 0 {
            return Err("an image without texels".to_owned());
        }
        if width.max(height) > Texture::MAX_SIDE {
            return Err(format!(
                "not a usable image: a side of {width}x{height} texels is longer than {}",
                Texture::MAX_SIDE
            ));
        }
        take([width, height], budget)
    })?;
    Ok((image.size, image.rgba()))
}

/// Whether there is a decoder for AVIF.
pub(crate) const READS_AVIF: bool = cfg!(all(feature = "avif", not(target_family = "wasm")));

/// Part of every error and warning about an AVIF texture in a build without the feature `avif`.
///
/// A program can search [`Error`](umbrage_scene::Error)s and [`Scene::warnings`](umbrage_scene::Scene::warnings) for it, to tell its users
/// how to get the feature.
pub const AVIF_LEFT_OUT: &str = "AVIF textures need the feature `avif`, which this build leaves out";

/// Whether this is an AVIF file: its first box lists file types, including AVIF.
fn is_avif(bytes: &[u8]) -> bool {
    let Some((length, rest)) = bytes.split_first_chunk() else { return false };
    let length = (u32::from_be_bytes(*length) as usize).clamp(4, bytes.len()) - 4;
    let (names, _) = rest[..length].as_chunks();
    names.first() == Some(b"ftyp") && names.iter().any(|name| name == b"avif" || name == b"avis")
}
