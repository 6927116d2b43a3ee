//! AVIF files: one picture of the AV1 codec in a HEIF container, with an alpha plane beside it (`EXT_texture_avif`).
//!
//! Profiles, primaries and transfer functions are ignored, as glTF specifies for other pictures.

use umbrage_scene::Texture;

use super::take;
use crate::memory::Budget;
use container::{Item, Picture};
use planes::Planes;

mod color;
mod container;
mod planes;

/// Width and height, at least 1, and the RGBA texels, the upper row first.
///
/// # Errors
/// A message, where the file is broken, larger than [`Texture::MAX_SIDE`] or the budget, or isn't a single picture.
pub(super) fn decode(bytes: &[u8], budget: &Budget) -> Result<([u32; 2], Vec<[u8; 4]>), String> {
    let unusable = |cause| format!("not a usable image: AVIF: {cause}");
    let picture = Picture::read(bytes).map_err(unusable)?;
    let size @ [width, height] = picture.color.size;
    if width.max(height) > Texture::MAX_SIDE {
        return Err(unusable(format!("{width}x{height} texels, where {0}x{0} are the most", Texture::MAX_SIDE)));
    }
    take(size, budget)?;
    // Three planes of u16, twice where film grain is added to them.
    const BYTES_WHILE_DECODED: u64 = 12;
    let pixels = u64::from(width) * u64::from(height);
    let compressed =
        [Some(&picture.color), picture.alpha.as_ref()].into_iter().flatten().map(|item| item.data.len() as u64);
    let bytes = BYTES_WHILE_DECODED * pixels + compressed.sum::<u64>();
    budget.take(bytes, format_args!("decoding an AVIF image of {width}x{height} texels"))?;
    let texels = texels(&picture).map_err(unusable)?;
    Ok((size, texels))
}

fn texels(picture: &Picture<'_>) -> Result<Vec<[u8; 4]>, String> {
    let planes = decoded(&picture.color, "its picture")?;
    let mut texels = color::texels(&planes, picture.color.coding.unwrap_or(planes.coding))?;
    drop(planes);
    if let Some(item) = &picture.alpha {
        if item.size != picture.color.size {
            return Err("its alpha has another size than its picture".to_owned());
        }
        let planes = decoded(item, "its alpha")?;
        color::add_alpha(&mut texels, &planes, item.coding.unwrap_or(planes.coding), picture.is_premultiplied);
    }
    Ok(texels)
}

fn decoded(item: &Item<'_>, what: &str) -> Result<Planes, String> {
    let planes = Planes::decode(&item.data, item.size).map_err(|cause| format!("{what}: {cause}"))?;
    if planes.size != item.size {
        let ([width, height], [says_width, says_height]) = (planes.size, item.size);
        return Err(format!("{what} has {width}x{height} texels, where the file says {says_width}x{says_height}"));
    }
    Ok(planes)
}
