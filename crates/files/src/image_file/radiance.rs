//! Radiance's RGBE images (Ward, Real Pixels, Graphics Gems II, 1991): texels of four bytes, three mantissas and an exponent,
//! plain, in runs of equal texels, or in runs of equal bytes.

use super::{Check, Image, Samples, take, unusable};

/// Reads an image with rows from top to bottom and texels from left to right, as in nearly all files.
pub(super) fn decode(mut bytes: &[u8], check: Check<'_>) -> Result<Image, String> {
    let size = read_header(&mut bytes)?;
    check(size)?;
    let [width, height] = size.map(|side| side as usize);
    // A packed row takes at least a byte per 32 texels, so a short file can't request much memory.
    let texels = width.checked_mul(height).filter(|texels| texels / 32 <= bytes.len());
    let texels = texels.ok_or_else(|| unusable("it ends too early"))?;
    let mut floats = Vec::with_capacity(3 * texels);
    let mut row = vec![[0; 4]; width];
    for _ in 0..height {
        read_row(&mut bytes, &mut row)?;
        floats.extend(row.iter().flat_map(|&texel| radiance(texel)));
    }
    Ok(Image { size, channels: 3, samples: Samples::Floats(floats) })
}

/// Reads the size, which follows lines of text up to an empty one.
fn read_header(bytes: &mut &[u8]) -> Result<[u32; 2], String> {
    let mut line = || {
        let end = bytes.iter().position(|&byte| byte == b'\n').ok_or_else(|| unusable("its header has no end"))?;
        let line = take(bytes, end + 1)?;
        std::str::from_utf8(line).map(str::trim).map_err(|_| unusable("its header isn't text"))
    };
    while !line()?.is_empty() {}
    let words: Vec<_> = line()?.split_whitespace().collect();
    let size = match words.as_slice() {
        ["-Y", height, "+X", width] => width.parse().ok().zip(height.parse().ok()),
        _ => {
            return Err(unusable(format_args!("its rows don't go from top left to bottom right: {}", words.join(" "))));
        }
    };
    let (width, height) = size.ok_or_else(|| unusable("its size isn't two numbers"))?;
    if width == 0 || height == 0 {
        return Err(unusable("it has no texels"));
    }
    Ok([width, height])
}

fn read_row(bytes: &mut &[u8], row: &mut [[u8; 4]]) -> Result<(), String> {
    let width = row.len();
    // Two bytes that don't occur in texels, then the width.
    let packed = [2, 2, (width >> 8) as u8, width as u8];
    if (8..0x8000).contains(&width) && bytes.starts_with(&packed) {
        take(bytes, packed.len())?;
        return (0..4).try_for_each(|channel| read_channel(bytes, row, channel));
    }
    let (mut column, mut shift) = (0, 0);
    while column < width {
        let texel: [u8; 4] = take(bytes, 4)?.try_into().expect("it is four bytes");
        if let [1, 1, 1, count] = texel {
            let count = usize::from(count).checked_shl(shift).unwrap_or(usize::MAX);
            let before = column.checked_sub(1).ok_or_else(|| unusable("a run has no texel before it"))?;
            let end = column.saturating_add(count).min(width);
            let repeated = row[before];
            row[column..end].fill(repeated);
            // Each further count gives the next higher byte of a long run's length.
            (column, shift) = (end, shift + 8);
        } else {
            row[column] = texel;
            (column, shift) = (column + 1, 0);
        }
    }
    Ok(())
}

/// Reads one channel of a row: runs of equal bytes, and literal runs.
fn read_channel(bytes: &mut &[u8], row: &mut [[u8; 4]], channel: usize) -> Result<(), String> {
    let mut texels = row.iter_mut().map(|texel| &mut texel[channel]);
    while texels.len() > 0 {
        let count = take(bytes, 1)?[0];
        if count > 128 {
            let byte = take(bytes, 1)?[0];
            texels.by_ref().take(usize::from(count - 128)).for_each(|texel| *texel = byte);
        } else if count > 0 {
            let run = take(bytes, count.into())?;
            texels.by_ref().zip(run).for_each(|(texel, &byte)| *texel = byte);
        } else {
            return Err(unusable("a run has no bytes"));
        }
    }
    Ok(())
}

/// Decodes a texel: each mantissa counts 256ths of the power of two.
fn radiance([red, green, blue, exponent]: [u8; 4]) -> [f32; 3] {
    if exponent == 0 {
        return [0.0; 3];
    }
    let unit = libm::ldexp(1.0, i32::from(exponent) - 136) as f32;
    [red, green, blue].map(|mantissa| f32::from(mantissa) * unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn open(size: &str, rows: &[u8]) -> Result<Image, String> {
        let bytes = [b"#?RADIANCE\n# comment\nFORMAT=32-bit_rle_rgbe\n\n", size.as_bytes(), b"\n", rows].concat();
        decode(&bytes, &mut |_| Ok(()))
    }

    #[test]
    fn rows_are_read_in_all_three_forms() {
        // 128/256 · 2¹ = 1, and the smallest and the largest powers.
        let plain = open("-Y 1 +X 3", &[128, 64, 0, 129, 255, 0, 0, 1, 0, 255, 0, 255]).unwrap();
        let expected = [[1.0, 0.5, 0.0], [255.0 * 2f32.powi(-135), 0.0, 0.0], [0.0, 255.0 * 2f32.powi(119), 0.0]];
        assert_eq!((plain.size, plain.rgb(), plain.is_linear()), ([3, 1], expected.to_vec(), true));

        // A texel, repeated 2 + 256 times.
        let repeated =
            open("-Y 1 +X 260", &[&[128, 64, 0, 129, 1, 1, 1, 2, 1, 1, 1, 1][..], &[0; 4]].concat()).unwrap();
        let mut expected = vec![[1.0, 0.5, 0.0]; 259];
        expected.push([0.0; 3]);
        assert_eq!(repeated.rgb(), expected);

        let channels = [2, 2, 0, 8, 136, 128, 3, 64, 32, 16, 133, 8, 136, 0, 136, 129];
        let packed = open("-Y 1 +X 8", &channels).unwrap();
        let green = [0.5, 0.25, 0.125, 0.0625, 0.0625, 0.0625, 0.0625, 0.0625];
        assert_eq!(packed.rgb(), green.map(|green| [1.0, green, 0.0]).to_vec());
    }

    #[test]
    fn damaged_files_say_so() {
        for (size, rows, cause) in [
            ("-Y 1 +X 3", &[128, 64, 0, 129, 255][..], "it ends too early"),
            ("-Y 60000 +X 60000", &[0; 12][..], "it ends too early"),
            ("-Y 1 +X 3", &[1, 1, 1, 2, 0, 0, 0, 0][..], "a run has no texel before it"),
            ("-Y 1 +X 8", &[2, 2, 0, 8, 0, 1, 1, 1][..], "a run has no bytes"),
            ("+Y 1 +X 8", &[0; 32][..], "its rows don't go from top left to bottom right: +Y 1 +X 8"),
            ("-Y 1 +X x", &[0; 32][..], "its size isn't two numbers"),
            ("-Y 0 +X 1", &[0; 32][..], "it has no texels"),
        ] {
            assert_eq!(open(size, rows).unwrap_err(), format!("not a usable image: {cause}"));
        }
        let cause = decode(b"#?RADIANCE\nno end", &mut |_| Ok(())).unwrap_err();
        assert_eq!(cause, "not a usable image: its header has no end");
    }
}
