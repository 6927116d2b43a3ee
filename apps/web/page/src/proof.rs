use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use umbrage::{Film, LightMask};

/// Hashes (SHA-256, in hexadecimal digits) of a picture's intermediate results, equal on every machine.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct Proof {
    /// Hash of the triangle's number at each pixel.
    pub triangles: String,
    /// Hash of the bits of each pixel's depth.
    pub depths: String,
    /// Hash of each light's mask of lit pixels.
    pub masks: String,
    /// Hash of the bits of each pixel's linear colour.
    pub radiance: String,
    /// Hash of the picture's bytes.
    pub picture: String,
}

impl Proof {
    pub(crate) fn new(film: &Film, masks: &[LightMask], picture: &[u8]) -> Self {
        let lit = masks.iter().flat_map(|mask| {
            let pixels = (0..film.height).flat_map(|y| (0..film.width).map(move |x| (x, y)));
            pixels.map(|(x, y)| [u8::from(mask.is_lit(x, y))])
        });
        Self {
            triangles: hash(film.triangle.iter().map(|triangle| triangle.to_le_bytes())),
            depths: hash(film.depth.iter().map(|depth| depth.to_le_bytes())),
            masks: hash(lit),
            radiance: hash(film.color.iter().flat_map(|color| color.to_array().map(f32::to_le_bytes))),
            picture: hash(picture.iter().map(|&byte| [byte])),
        }
    }
}

fn hash<const N: usize>(parts: impl Iterator<Item = [u8; N]>) -> String {
    let mut bytes = Vec::new();
    parts.for_each(|part| bytes.extend(part));
    Sha256::digest(&bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}
