//! Mattes of objects by their names, as in Friedman and Jones, *Cryptomatte Specification*, version 1.2.0, 2018: each pixel
//! has pairs of an object's id and its part of the pixel, the greatest first, in layers of two pairs.

use std::sync::Arc;

use ::exr::prelude::{FlatSamples, attribute::AttributeValue};

use super::header::{Attribute, ascii_json, text};
use crate::{Coverage, Covered, FilmLayers};

/// The mattes' name, in the name of every channel.
const LAYER: &str = "CryptoObject";

/// Ranks come in pairs.
const PAIR: usize = 2;

/// The channels of all ranks: `CryptoObject00.R` has the first ids, `.G` their parts, `.B` and `.A` the second ones; empty
/// where there are no mattes.
pub(super) fn channels(layers: &FilmLayers) -> Vec<(String, FlatSamples)> {
    let pixels = layers.coverage.pixels();
    if pixels.is_empty() {
        return Vec::new();
    }
    let ids: Vec<f32> = layers.objects.iter().map(|name| id(hash(name.as_bytes()))).collect();
    let id_of = |covered: &Covered| ids.get(covered.object as usize).copied().unwrap_or(0.0);
    let mut channels = Vec::new();
    for rank in 0..Coverage::RANKS {
        let (layer, [id, part]) = (rank / PAIR, if rank % PAIR == 0 { ["R", "G"] } else { ["B", "A"] });
        let ids = pixels.iter().map(|ranks| id_of(&ranks[rank])).collect();
        let parts = pixels.iter().map(|ranks| ranks[rank].part).collect();
        channels.push((format!("{LAYER}{layer:02}.{id}"), FlatSamples::F32(ids)));
        channels.push((format!("{LAYER}{layer:02}.{part}"), FlatSamples::F32(parts)));
    }
    channels
}

/// The attributes by which compositing programs find the mattes; empty where there are none.
pub(super) fn attributes(layers: &FilmLayers) -> Vec<Attribute> {
    if layers.coverage.pixels().is_empty() {
        return Vec::new();
    }
    let key = &format!("{:08x}", hash(LAYER.as_bytes()))[..7];
    let attribute =
        |name: &str, value: &str| (text(&format!("cryptomatte/{key}/{name}")), AttributeValue::Text(text(value)));
    vec![
        attribute("conversion", "uint32_to_float32"),
        attribute("hash", "MurmurHash3_32"),
        attribute("manifest", &manifest(&layers.objects)),
        attribute("name", LAYER),
    ]
}

/// A JSON object with each object's id, the bits of the float as hexadecimal digits, by its name.
fn manifest(names: &[Arc<str>]) -> String {
    let ids =
        names.iter().map(|name| (name.to_string(), format!("{:08x}", id(hash(name.as_bytes())).to_bits()).into()));
    ascii_json(&serde_json::Value::Object(ids.collect()))
}

/// The float with a hash's bits, except for its exponent: an id is no NaN, infinity, subnormal number or zero, since
/// programs don't pass these on bit for bit.
fn id(hash: u32) -> f32 {
    let exponent = hash >> 23 & 0xff;
    f32::from_bits(if exponent == 0 || exponent == 0xff { hash ^ 1 << 23 } else { hash })
}

/// Appleby's `MurmurHash3_x86_32` of 2011, with seed 0.
fn hash(bytes: &[u8]) -> u32 {
    let mixed = |word: u32| word.wrapping_mul(0xcc9e_2d51).rotate_left(15).wrapping_mul(0x1b87_3593);
    let (words, tail) = bytes.as_chunks::<4>();
    let mut hash = words.iter().fold(0_u32, |hash, word| {
        (hash ^ mixed(u32::from_le_bytes(*word))).rotate_left(13).wrapping_mul(5).wrapping_add(0xe654_6b64)
    });
    hash ^= mixed(tail.iter().rev().fold(0, |word, &byte| word << 8 | u32::from(byte)));
    hash ^= bytes.len() as u32;
    hash = (hash ^ hash >> 16).wrapping_mul(0x85eb_ca6b);
    hash = (hash ^ hash >> 13).wrapping_mul(0xc2b2_ae35);
    hash ^ hash >> 16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hashes_are_the_published_ones() {
        // From the reference implementation's tests, `cryptomatte_utilities_tests.py` of Psyop/Cryptomatte.
        for (name, expected) in [
            ("hello", 6.070_562_710_24e-17_f64),
            ("cube", -4.084_619_125_19e15),
            ("sphere", 2.790_186_043_83e15),
            ("plane", 3.665_576_175_93e-11),
            ("равнина", -1.319_263_121_24e-25),
            ("mädchen", 6.236_129_821_16e25),
        ] {
            let id = f64::from(id(hash(name.as_bytes())));
            assert!((id / expected - 1.0).abs() < 1e-7, "{name}: {id:e}");
        }
        assert_eq!(hash(b""), 0);
    }

    #[test]
    fn ids_are_plain_numbers() {
        for hash in [0, 1, 0x7f80_0000, 0xff80_0000, 0x7fff_ffff, u32::MAX, 0x8000_0001, 0x3f80_0000] {
            let id = id(hash);
            assert!(id.is_normal(), "{hash:08x} is {id}");
            assert!(id.to_bits() == hash || (id.to_bits() ^ hash) == 1 << 23);
        }
    }

    #[test]
    fn manifests_are_json_of_ascii_alone() {
        let names = ["cube", "with \"quotes\" and \\", "mädchen", "\u{1f600}"].map(Arc::from);
        let manifest = manifest(&names);
        assert!(manifest.is_ascii(), "{manifest}");
        let read: serde_json::Value = serde_json::from_str(&manifest).unwrap();
        let ids = read.as_object().unwrap();
        assert_eq!(ids.len(), names.len());
        for name in &names {
            let bits = u32::from_str_radix(ids[&**name].as_str().unwrap(), 16).unwrap();
            assert_eq!(f32::from_bits(bits), id(hash(name.as_bytes())));
        }
    }
}
