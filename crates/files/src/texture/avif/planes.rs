//! The decoder of AV1, a port of dav1d to Rust.

use std::panic::catch_unwind;

use re_rav1d::dav1d::{Decoder, Picture, PixelLayout, PlanarImageComponent, Settings};

use super::color::Coding;

/// A frame: luma, and two planes of chroma unless it is grey.
#[derive(Debug)]
pub(super) struct Planes {
    pub(super) size: [u32; 2],
    /// Bits of a value: 8, 10 or 12.
    pub(super) bits: u32,
    pub(super) luma: SamplePlane,
    pub(super) chroma: Option<[SamplePlane; 2]>,
    /// Colour coding, unless the container specifies another.
    pub(super) coding: Coding,
}

/// Values in rows.
#[derive(Debug)]
pub(super) struct SamplePlane {
    pub(super) width: usize,
    pub(super) values: Vec<u16>,
}

impl Planes {
    /// Decodes the frame in `data`, of at most `width · height` pixels.
    ///
    /// # Errors
    /// A message why it can't be decoded.
    pub(super) fn decode(data: &[u8], [width, height]: [u32; 2]) -> Result<Self, String> {
        let most = width.saturating_mul(height);
        let data = data.to_vec();
        let decoded = catch_unwind(move || Self::new(&picture(data, most)?));
        decoded.unwrap_or_else(|_| Err(BROKEN.to_owned()))
    }

    fn new(picture: &Picture) -> Result<Self, String> {
        let size @ [width, height] = [picture.width(), picture.height()];
        let bits = picture.bits_per_component().ok_or("values of a number of bits that AV1 doesn't have")?.0 as u32;
        let [across, down] = match picture.pixel_layout() {
            PixelLayout::I400 | PixelLayout::I444 => [1, 1],
            PixelLayout::I422 => [2, 1],
            PixelLayout::I420 => [2, 2],
        };
        let plane = |component, [across, down]: [u32; 2]| {
            let [width, height] = [width.div_ceil(across), height.div_ceil(down)].map(|side| side as usize);
            let bytes = picture.plane(component);
            let stride = picture.stride(component) as usize;
            let rows = bytes.chunks(stride.max(1)).take(height);
            let values = match bits {
                8 => rows.flat_map(|row| row.iter().take(width).map(|&byte| u16::from(byte))).collect(),
                _ => rows
                    .flat_map(|row| row.as_chunks().0.iter().take(width).map(|&pair| u16::from_ne_bytes(pair)))
                    .collect(),
            };
            SamplePlane { width, values }
        };
        let luma = plane(PlanarImageComponent::Y, [1, 1]);
        let chroma = (picture.pixel_layout() != PixelLayout::I400)
            .then(|| [PlanarImageComponent::U, PlanarImageComponent::V].map(|each| plane(each, [across, down])));
        Ok(Self { size, bits, luma, chroma, coding: Coding::of(picture) })
    }
}

const BROKEN: &str = "its compressed texels are broken";

fn picture(data: Vec<u8>, most_pixels: u32) -> Result<Picture, String> {
    let broken = |error| format!("{BROKEN}: {error}");
    let mut settings = Settings::new();
    // Pictures are decoded in parallel already.
    settings.set_n_threads(1);
    settings.set_max_frame_delay(1);
    settings.set_all_layers(false);
    settings.set_frame_size_limit(most_pixels);
    let mut decoder = Decoder::with_settings(&settings).map_err(broken)?;
    match decoder.send_data(data, None, None, None) {
        Err(error) if !error.is_again() => Err(broken(error)),
        _ => decoder.get_picture().map_err(broken),
    }
}
