//! Truevision TGA images: colours, greys and palettes, plain or run-length encoded (TGA File Format Specification
//! 2.0, 1991).

use super::{Check, Image, Samples, bytes_of, take, unmask, unusable};

/// Reads an image of 8, 15, 16, 24 or 32 bits a texel.
pub(super) fn decode(mut bytes: &[u8], check: Check<'_>) -> Result<Image, String> {
    let header = take(&mut bytes, 18)?;
    let word = |at: usize| u16::from_le_bytes([header[at], header[at + 1]]);
    let [id_length, has_palette, kind] = [header[0], header[1], header[2]];
    if has_palette > 1 || !matches!(kind, 1..=3 | 9..=11) {
        return Err(unusable("its format is none that is known"));
    }
    let size = [word(12), word(14)].map(u32::from);
    if size.contains(&0) {
        return Err(unusable("it has no texels"));
    }
    check(size)?;
    let (bits, descriptor) = (header[16], header[17]);
    take(&mut bytes, id_length.into())?;
    // Images of other kinds may have a palette too, which is ignored.
    let entry_bytes = usize::from(header[7]).div_ceil(8);
    let entries = take(&mut bytes, usize::from(has_palette) * usize::from(word(5)) * entry_bytes)?;

    let is_mapped = kind & 7 == 1;
    let masks = masks_of(kind & 7 == 3, if is_mapped { header[7] } else { bits }, descriptor & 15)?;
    if is_mapped && (!matches!(bits, 8 | 16) || has_palette == 0) {
        return Err(unusable("a palette's indices have 8 or 16 bits"));
    }
    let stored = usize::from(bits).div_ceil(8);
    let length = bytes_of(size, 1, stored)?;
    let unpacked;
    let texels = if kind >= 9 {
        unpacked = unpack(&mut bytes, stored, length)?;
        unpacked.as_slice()
    } else {
        take(&mut bytes, length)?
    };

    let mut samples = Vec::with_capacity(bytes_of(size, masks.len(), 1)?);
    let [width, height] = size.map(|side| side as usize);
    let [from_right, from_top] = [descriptor & 16 != 0, descriptor & 32 != 0];
    for row in 0..height {
        let row = if from_top { row } else { height - 1 - row };
        for column in 0..width {
            let column = if from_right { width - 1 - column } else { column };
            let texel = &texels[(row * width + column) * stored..][..stored];
            if !is_mapped {
                unmask(texel, masks, &mut samples);
                continue;
            }
            let index = texel.iter().rev().fold(0, |index, &byte| index << 8 | usize::from(byte));
            let entry =
                index.checked_sub(word(3).into()).and_then(|entry| entries.chunks_exact(entry_bytes).nth(entry));
            unmask(entry.ok_or_else(|| unusable("a texel names no color of its palette"))?, masks, &mut samples);
        }
    }
    Ok(Image { size, channels: masks.len(), samples: Samples::Bytes(samples) })
}

/// The bits of each sample of a texel.
fn masks_of(is_grey: bool, bits: u8, opacity_bits: u8) -> Result<&'static [u32], String> {
    match (is_grey, bits, opacity_bits) {
        (true, 8, 0 | 8) => Ok(&[0xff]),
        (true, 16, 8) => Ok(&[0xff, 0xff00]),
        // One bit isn't used.
        (false, 15 | 16, 0 | 1) => Ok(&[31 << 10, 31 << 5, 31]),
        (false, 24, 0) => Ok(&[0xff_0000, 0xff00, 0xff]),
        (false, 32, 0 | 8) => Ok(&[0xff_0000, 0xff00, 0xff, 0xff00_0000]),
        _ => Err(unusable(format_args!("texels of {bits} bits, {opacity_bits} of them opacity, aren't read"))),
    }
}

/// Decodes runs of equal texels and literal runs, up to `length` bytes.
fn unpack(bytes: &mut &[u8], stored: usize, length: usize) -> Result<Vec<u8>, String> {
    let mut texels = Vec::new();
    while texels.len() < length {
        let count = take(bytes, 1)?[0];
        let run = usize::from(count & 127) + 1;
        if count > 127 {
            let texel = take(bytes, stored)?;
            (0..run).for_each(|_| texels.extend(texel));
        } else {
            texels.extend(take(bytes, (run * stored).min(length - texels.len()))?);
        }
    }
    texels.truncate(length);
    Ok(texels)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A header with a palette of two colours where `kind` asks for one.
    fn file(kind: u8, [width, height]: [u8; 2], bits: u8, descriptor: u8, rest: &[u8]) -> Vec<u8> {
        let mapped = u8::from(kind & 7 == 1);
        let header =
            [3, mapped, kind, 5, 0, 2 * mapped, 0, 24 * mapped, 0, 0, 0, 0, width, 0, height, 0, bits, descriptor];
        [&header[..], b"id.", rest].concat()
    }

    fn open(bytes: &[u8]) -> Result<Vec<[u8; 4]>, String> {
        decode(bytes, &mut |_| Ok(())).map(|image| image.rgba())
    }

    #[test]
    fn all_kinds_of_texels_are_read() {
        const TOP: u8 = 32;
        let cases = [
            (3, 8, TOP, &[7, 9][..], [[7, 7, 7, 255], [9, 9, 9, 255]]),
            (3, 16, TOP | 8, &[7, 8, 9, 10], [[7, 7, 7, 8], [9, 9, 9, 10]]),
            (2, 16, TOP | 1, &[0b1110_0001, 0b1111_1101, 1, 0], [[255, 123, 8, 255], [0, 0, 8, 255]]),
            (2, 24, TOP, &[3, 2, 1, 6, 5, 4], [[1, 2, 3, 255], [4, 5, 6, 255]]),
            (2, 32, TOP | 8, &[3, 2, 1, 9, 6, 5, 4, 8], [[1, 2, 3, 9], [4, 5, 6, 8]]),
            (1, 8, TOP, &[3, 2, 1, 6, 5, 4, 6, 5], [[4, 5, 6, 255], [1, 2, 3, 255]]),
        ];
        for (kind, bits, descriptor, rest, expected) in cases {
            assert_eq!(open(&file(kind, [2, 1], bits, descriptor, rest)).unwrap(), expected, "{kind} {bits}");
        }
    }

    #[test]
    fn rows_may_begin_at_any_corner() {
        let texels = [1, 2, 3, 4];
        for (descriptor, expected) in [(32, [1, 2, 3, 4]), (0, [3, 4, 1, 2]), (48, [2, 1, 4, 3]), (16, [4, 3, 2, 1])] {
            let image = open(&file(3, [2, 2], 8, descriptor, &texels)).unwrap();
            assert_eq!(image.iter().map(|texel| texel[0]).collect::<Vec<_>>(), expected);
        }
    }

    #[test]
    fn runs_are_unpacked() {
        // Two texels, then a run of five, whose last is beyond the image.
        let image = open(&file(11, [3, 2], 8, 32, &[1, 1, 2, 132, 3])).unwrap();
        assert_eq!(image.iter().map(|texel| texel[0]).collect::<Vec<_>>(), [1, 2, 3, 3, 3, 3]);
    }

    #[test]
    fn damaged_files_say_so() {
        let large = file(10, [255, 255], 24, 0, &[255, 1, 2, 3]);
        for (bytes, cause) in [
            (&file(3, [2, 1], 8, 0, &[7])[..], "it ends too early"),
            (&large, "it ends too early"),
            (&file(1, [2, 1], 8, 0, &[3, 2, 1, 6, 5, 4, 6, 7]), "a texel names no color of its palette"),
            (&file(1, [2, 1], 8, 0, &[3, 2, 1, 6, 5, 4, 6, 4]), "a texel names no color of its palette"),
            (&file(3, [0, 1], 8, 0, &[]), "it has no texels"),
            (&file(2, [1, 1], 12, 0, &[0; 9]), "texels of 12 bits, 0 of them opacity, aren't read"),
            (b"nothing, and this at some length", "its format is none that is known"),
        ] {
            assert_eq!(open(bytes).unwrap_err(), format!("not a usable image: {cause}"));
        }
    }
}
