//! AVIF pictures (made by `tools/test-files`) against their sources, and errors of broken ones.

use std::path::PathBuf;

use umbrage_scene::{ColorSpace, Filter, Texture, Wrap};

const SIZE: [u32; 2] = [21, 13];

fn file(name: &str) -> Vec<u8> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../verify/corpus/images");
    std::fs::read(folder.join(format!("{name}.avif"))).unwrap()
}

fn decode(bytes: &[u8]) -> Result<Texture, String> {
    umbrage_files::decode_texture("", bytes, ColorSpace::Srgb, Filter::Nearest, [Wrap::Repeat; 2])
}

/// The texels drawn by `tools/test-files/pictures.mjs`.
fn drawn([x, y]: [u32; 2]) -> [u8; 4] {
    [40 + 8 * x, 200 - 9 * y, 60 + 4 * x + 5 * y, 255 - 10 * y].map(|value| value as u8)
}

/// Maximum differences between a file's texels and the expected ones, per channel.
fn differences(name: &str, expected: fn([u32; 2]) -> [u8; 4]) -> [u8; 4] {
    let texture = decode(&file(name)).unwrap();
    assert_eq!(texture.size(), SIZE, "{name}");
    let mut most = [0; 4];
    for (at, texel) in texture.levels().next().unwrap().iter().enumerate() {
        let expected = expected([at as u32 % SIZE[0], at as u32 / SIZE[0]]);
        for ((most, found), expected) in most.iter_mut().zip(texel).zip(expected) {
            *most = found.abs_diff(expected).max(*most);
        }
    }
    most
}

fn opaque(at: [u32; 2]) -> [u8; 4] {
    let [r, g, b, _] = drawn(at);
    [r, g, b, 255]
}

fn gray(at: [u32; 2]) -> [u8; 4] {
    let [r, ..] = drawn(at);
    [r, r, r, 255]
}

/// Bounds: the errors of libavif's own decoder, plus one.
#[test]
fn every_depth_range_and_sampling_has_the_picture() {
    for (name, expected, most) in [
        ("420", drawn as fn([u32; 2]) -> [u8; 4], [6, 5, 8, 1]),
        ("420-12", opaque, [5, 4, 8, 0]),
        ("422-limited", opaque, [4, 3, 4, 0]),
        ("444-10", drawn, [3, 2, 3, 1]),
        ("gray", gray, [1, 1, 1, 0]),
        ("premultiplied", drawn, [4, 3, 4, 1]),
    ] {
        let found = differences(name, expected);
        assert!(found.iter().zip(most).all(|(&found, most)| found <= most), "{name}: {found:?}");
    }
}

/// A file with a byte string replaced by another of equal length.
fn replaced(name: &str, old: &[u8], new: &[u8]) -> Vec<u8> {
    let mut bytes = file(name);
    let found: Vec<_> = (0..bytes.len()).filter(|&at| bytes[at..].starts_with(old)).collect();
    assert!(!found.is_empty() && old.len() == new.len(), "{name}");
    for at in found {
        bytes[at..at + new.len()].copy_from_slice(new);
    }
    bytes
}

/// A file whose header claims another width.
pub(crate) fn of_width(width: u32) -> Vec<u8> {
    let size = |width: u32| [b"ispe\0\0\0\0".to_vec(), width.to_be_bytes().to_vec()].concat();
    replaced("420", &size(SIZE[0]), &size(width))
}

#[test]
fn broken_files_say_what_is_wrong() {
    let whole = file("420");
    let cut = whole[..whole.len() - 20].to_vec();
    for (bytes, cause) in [
        (cut, "its compressed texels are not all there"),
        (whole[..200].to_vec(), "the box `meta` is cut off"),
        (of_width(22), "its picture has 21x13 texels, where the file says 22x13"),
        (of_width(20), "its picture: its compressed texels are broken"),
        (of_width(16_385), "16385x13 texels, where 16384x16384 are the most"),
        (of_width(0), "it doesn't say its size"),
        (replaced("gray", b"av01", b"grid"), "it is a grid of pictures, which is not read"),
        (replaced("gray", b"av01", b"hvc1"), "it is of the kind `hvc1`, which is not read"),
        (replaced("gray", b"pixi", b"imir"), "it is to be mirrored, which is not read"),
        (replaced("gray", b"pixi", b"clap"), "it is to be cut out of a larger one, which is not read"),
        // The property's first byte, `n`, means a quarter turn or three.
        (replaced("gray", b"colrnclx", b"irotnclx"), "it is to be rotated, which is not read"),
        (replaced("gray", b"av1C", b"lsel"), "it has the property `lsel`, which is not read"),
        (replaced("gray", b"iloc", b"iLoc"), "it has no box `iloc`"),
        (replaced("gray", b"ispe", b"isPe"), "it doesn't say its size"),
        (replaced("gray", b"infe\x02\0\0\0\0\x01", b"infe\x02\0\0\0\0\x09"), "it says nothing of item 1"),
        (replaced("422-limited", b"nclx\0\x01\0\x0d\0\x06", b"nclx\0\x01\0\x0d\0\x08"), "by matrix 8 of H.273"),
        (replaced("422-limited", b"nclx\0\x01\0\x0d\0\x06", b"nclx\0\x01\0\x0d\0\0"), "but not of one size"),
    ] {
        let error = decode(&bytes).expect_err(cause);
        assert!(error.starts_with("not a usable image: AVIF: ") && error.contains(cause), "{cause}: {error}");
    }
}

#[test]
fn no_byte_brings_it_down() {
    for name in ["420", "444-10", "422-limited", "premultiplied"] {
        let bytes = file(name);
        for at in 0..bytes.len() {
            assert!(decode(&bytes[..at]).is_err(), "{name}, its first {at} bytes");
        }
        // Only some bytes, since decoding is slow without optimisation; the fuzzer covers more.
        for at in (0..bytes.len()).step_by(43) {
            let mut mutant = bytes.clone();
            mutant[at] ^= 0xA5;
            decode(&mutant).ok();
        }
    }
}
