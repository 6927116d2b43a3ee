//! Windows and OS/2 bitmaps: palettes, plain or run-length encoded, and colours in whole bytes or in bit fields.

use super::{Check, Image, Samples, bytes_of, take, unmask, unusable};

/// Reads a bitmap of 1, 4, 8, 16, 24 or 32 bits a texel.
pub(super) fn decode(bytes: &[u8], check: Check<'_>) -> Result<Image, String> {
    let header = Header::read(bytes)?;
    check(header.size)?;
    let rows = bytes.get(header.texels_at..).ok_or_else(|| unusable("it ends too early"))?;
    match header.coding {
        Coding::Plain if header.bits <= 8 => header.image_of(&header.unpacked(rows)?),
        Coding::Plain => header.colors(rows, header.plain_masks()),
        Coding::Masks(masks) => header.colors(rows, masks),
        Coding::Runs => header.image_of(&header.indices_of_runs(rows)?),
    }
}

struct Header<'a> {
    size: [u32; 2],
    from_top: bool,
    bits: u16,
    coding: Coding,
    /// Blue, green and red of each colour, and an unused byte except in OS/2's.
    palette: &'a [u8],
    entry_bytes: usize,
    texels_at: usize,
}

/// The encoding of texels.
#[derive(Clone, Copy)]
enum Coding {
    Plain,
    /// Run-length encoded: runs of equal indices, and literal runs.
    Runs,
    /// Bit masks of red, green, blue and opacity.
    Masks([u32; 4]),
}

impl<'a> Header<'a> {
    fn read(bytes: &'a [u8]) -> Result<Self, String> {
        let number = |at: usize, count: usize| {
            let bytes = bytes.get(at..at + count).ok_or_else(|| unusable("it ends too early"))?;
            Ok::<_, String>(bytes.iter().rev().fold(0, |number, &byte| number << 8 | u32::from(byte)))
        };
        let (texels_at, length) = (number(10, 4)? as usize, number(14, 4)? as usize);
        if length == 12 {
            let (size, bits) = ([number(18, 2)?, number(20, 2)?], number(24, 2)? as u16);
            let palette = bytes.get(26..texels_at).unwrap_or_default();
            return Self { size, from_top: false, bits, coding: Coding::Plain, palette, entry_bytes: 3, texels_at }
                .known();
        }
        if !(40..=1024).contains(&length) {
            return Err(unusable("its header is none that is known"));
        }
        let (width, height) = (number(18, 4)?, number(22, 4)? as i32);
        let (bits, compression) = (number(28, 2)? as u16, number(30, 4)?);
        // Masks follow the first 40 bytes, within the header or behind it.
        let masks = match compression {
            3 if length < 56 => 3,
            3 | 6 => 4,
            _ => 0,
        };
        let coding = match (compression, bits) {
            (0, _) => Coding::Plain,
            (1, 8) | (2, 4) => Coding::Runs,
            (3 | 6, 16 | 32) => {
                let mut bits = [0; 4];
                for (index, mask) in bits[..masks].iter_mut().enumerate() {
                    *mask = number(54 + 4 * index, 4)?;
                }
                Coding::Masks(bits)
            }
            _ => return Err(unusable(format_args!("compression {compression} of {bits} bits isn't read"))),
        };
        let palette = bytes.get(14 + length.max(40 + 4 * masks)..texels_at).unwrap_or_default();
        let size = [width, height.unsigned_abs()];
        Self { size, from_top: height < 0, bits, coding, palette, entry_bytes: 4, texels_at }.known()
    }

    fn known(self) -> Result<Self, String> {
        if self.size.contains(&0) || self.size[0] > i32::MAX as u32 {
            return Err(unusable("its size isn't that of an image"));
        }
        if !matches!(self.bits, 1 | 4 | 8 | 16 | 24 | 32) {
            return Err(unusable(format_args!("{} bits a texel aren't read", self.bits)));
        }
        Ok(self)
    }

    /// The rows of a file without runs, from top to bottom; each is padded to a multiple of four bytes.
    fn rows<'b>(&self, bytes: &'b [u8]) -> Result<impl Iterator<Item = &'b [u8]> + use<'b>, String> {
        let [width, height] = self.size.map(|side| side as usize);
        let stored = (width * usize::from(self.bits)).div_ceil(32) * 4;
        let used = (width * usize::from(self.bits)).div_ceil(8);
        // The last row may lack its padding.
        let length = stored.checked_mul(height).map(|length| length - stored + used);
        let bytes = length.and_then(|length| bytes.get(..length)).ok_or_else(|| unusable("it ends too early"))?;
        let from_top = self.from_top;
        Ok((0..height).map(move |row| {
            let row = if from_top { row } else { height - 1 - row };
            &bytes[row * stored..][..used]
        }))
    }

    /// Unpacks each texel's palette index.
    fn unpacked(&self, bytes: &[u8]) -> Result<Vec<u8>, String> {
        let width = self.size[0] as usize;
        let (per_byte, mask) = (8 / usize::from(self.bits), ((1_u16 << self.bits) - 1) as u8);
        let mut indices = Vec::with_capacity(bytes_of(self.size, 1, 1)?);
        for row in self.rows(bytes)? {
            let texel = |column: usize| {
                let shift = 8 - usize::from(self.bits) * (column % per_byte + 1);
                row[column / per_byte] >> shift & mask
            };
            indices.extend((0..width).map(texel));
        }
        Ok(indices)
    }

    /// As [`Header::unpacked`], from runs; texels outside of all runs have index 0.
    fn indices_of_runs(&self, mut bytes: &[u8]) -> Result<Vec<u8>, String> {
        let [width, height] = self.size.map(|side| side as usize);
        let mut indices = vec![0; bytes_of(self.size, 1, 1)?];
        let (mut column, mut row) = (0, 0);
        while row < height {
            let [count, second] = take(&mut bytes, 2)?.try_into().expect("it is two bytes");
            let (run, is_equal) = match (count, second) {
                (0, 0) => {
                    (column, row) = (0, row + 1);
                    continue;
                }
                (0, 1) => break,
                (0, 2) => {
                    let moved = take(&mut bytes, 2)?;
                    (column, row) = (column + usize::from(moved[0]), row + usize::from(moved[1]));
                    continue;
                }
                (0, count) => (usize::from(count), false),
                (count, _) => (usize::from(count), true),
            };
            // Literal runs are padded to pairs of bytes.
            let pair = [second; 1];
            let packed = if is_equal { &pair } else { take(&mut bytes, self.run_bytes(run).next_multiple_of(2))? };
            let to_row = &mut indices[if self.from_top { row } else { height - 1 - row } * width..][..width];
            for (step, index) in to_row.iter_mut().skip(column).take(run).enumerate() {
                *index = match (self.bits, is_equal) {
                    (8, true) => packed[0],
                    (8, false) => packed[step],
                    (_, true) => packed[0] >> (4 * (1 - step % 2)) & 15,
                    (_, false) => packed[step / 2] >> (4 * (1 - step % 2)) & 15,
                };
            }
            column += run;
        }
        Ok(indices)
    }

    fn run_bytes(&self, texels: usize) -> usize {
        (texels * usize::from(self.bits)).div_ceil(8)
    }

    fn image_of(&self, indices: &[u8]) -> Result<Image, String> {
        let mut samples = Vec::with_capacity(3 * indices.len());
        for &index in indices {
            let entry = self.palette.get(usize::from(index) * self.entry_bytes..).and_then(<[u8]>::first_chunk);
            let &[blue, green, red] = entry.ok_or_else(|| unusable("a texel names no color of its palette"))?;
            samples.extend([red, green, blue]);
        }
        Ok(Image { size: self.size, channels: 3, samples: Samples::Bytes(samples) })
    }

    fn plain_masks(&self) -> [u32; 4] {
        if self.bits == 16 { [31 << 10, 31 << 5, 31, 0] } else { [255 << 16, 255 << 8, 255, 0] }
    }

    /// Reads colours from bit fields; opaque without bits for opacity.
    fn colors(&self, bytes: &[u8], masks: [u32; 4]) -> Result<Image, String> {
        let channels = if masks[3] == 0 { 3 } else { 4 };
        let mut samples = Vec::with_capacity(bytes_of(self.size, channels, 1)?);
        for row in self.rows(bytes)? {
            for texel in row.chunks_exact(usize::from(self.bits / 8)) {
                unmask(texel, &masks[..channels], &mut samples);
            }
        }
        Ok(Image { size: self.size, channels, samples: Samples::Bytes(samples) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file with a header of 40 bytes, then `more` of it and the palette, then texels.
    fn file([width, height]: [i32; 2], bits: u8, compression: u8, more: &[u8], texels: &[u8]) -> Vec<u8> {
        let start = 54 + more.len() as u8;
        let [width, height] = [width, height].map(i32::to_le_bytes);
        let begin = [b"BM\0\0\0\0\0\0\0\0", &[start, 0, 0, 0, 40, 0, 0, 0][..], &width, &height].concat();
        let rest = [1, 0, bits, 0, compression, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0];
        [&begin, &rest[..], more, texels].concat()
    }

    const PALETTE: [u8; 8] = [10, 20, 30, 0, 200, 210, 220, 0];
    const DARK: [u8; 4] = [30, 20, 10, 255];
    const LIGHT: [u8; 4] = [220, 210, 200, 255];

    fn open(bytes: &[u8]) -> Result<Vec<[u8; 4]>, String> {
        decode(bytes, &mut |_| Ok(())).map(|image| image.rgba())
    }

    #[test]
    fn all_kinds_of_texels_are_read() {
        let masks = [[0, 248, 0, 0], [224, 7, 0, 0], [31, 0, 0, 0]].concat();
        for (bits, compression, more, texels, expected) in [
            (1, 0, &PALETTE[..], &[0b0100_0000][..], [DARK, LIGHT]),
            (4, 0, &PALETTE, &[0x10], [LIGHT, DARK]),
            (8, 0, &PALETTE, &[1, 0], [LIGHT, DARK]),
            (16, 0, &[], &[0b0000_0001, 0b0111_1110, 0, 0], [[255, 132, 8, 255], [0, 0, 0, 255]]),
            (16, 3, &masks, &[0b0000_0001, 0b1111_1100, 0, 0], [[255, 130, 8, 255], [0, 0, 0, 255]]),
            (24, 0, &[], &[3, 2, 1, 6, 5, 4], [[1, 2, 3, 255], [4, 5, 6, 255]]),
            (32, 0, &[], &[3, 2, 1, 9, 6, 5, 4, 8], [[1, 2, 3, 255], [4, 5, 6, 255]]),
        ] {
            let image = open(&file([2, 1], bits, compression, more, texels)).unwrap();
            assert_eq!(image, expected, "{bits} bits, {compression}");
        }
        // Opacity has its own mask.
        let masks = [[0, 0, 255, 0], [0, 255, 0, 0], [255, 0, 0, 0], [0, 0, 0, 255]].concat();
        let image = open(&file([1, 1], 32, 6, &masks, &[3, 2, 1, 9])).unwrap();
        assert_eq!(image, [[1, 2, 3, 9]]);
        // OS/2's headers and palettes are shorter.
        let os2 = [
            &b"BM\0\0\0\0\0\0\0\0\x20\0\0\0\x0c\0\0\0\x02\0\x01\0\x01\0\x08\0"[..],
            &[10, 20, 30, 200, 210, 220, 1, 0],
        ];
        assert_eq!(open(&os2.concat()).unwrap(), [LIGHT, DARK]);
    }

    #[test]
    fn rows_may_begin_above_or_below() {
        let texels = [0b0100_0000, 0, 0, 0, 0b1000_0000, 0, 0, 0];
        assert_eq!(open(&file([2, 2], 1, 0, &PALETTE, &texels)).unwrap(), [LIGHT, DARK, DARK, LIGHT]);
        assert_eq!(open(&file([2, -2], 1, 0, &PALETTE, &texels)).unwrap(), [DARK, LIGHT, LIGHT, DARK]);
    }

    #[test]
    fn runs_are_unpacked() {
        // Lower row: a run of one, then three literals and padding. Upper row: one texel skipped, then a run of two.
        let runs = [1, 1, 0, 3, 0, 1, 0, 9, 0, 0, 0, 2, 1, 0, 2, 1, 0, 1];
        let expected = [DARK, LIGHT, LIGHT, DARK, LIGHT, DARK, LIGHT, DARK];
        assert_eq!(open(&file([4, 2], 8, 1, &PALETTE, &runs)).unwrap(), expected);
        let runs = [1, 0x10, 0, 3, 0x01, 0, 0, 0, 0, 2, 1, 0, 2, 0x11, 0, 1];
        assert_eq!(open(&file([4, 2], 4, 2, &PALETTE, &runs)).unwrap(), expected);
    }

    #[test]
    fn damaged_files_say_so() {
        for (bytes, cause) in [
            (file([2, 1], 24, 0, &[], &[1, 2, 3, 4, 5]), "it ends too early"),
            (file([2, 2], 8, 1, &PALETTE, &[9, 1, 0]), "it ends too early"),
            (file([1, 1], 8, 0, &PALETTE, &[2, 0, 0, 0]), "a texel names no color of its palette"),
            (file([0, 1], 8, 0, &PALETTE, &[]), "its size isn't that of an image"),
            (file([1, 1], 7, 0, &PALETTE, &[]), "7 bits a texel aren't read"),
            (file([1, 1], 24, 4, &[], &[]), "compression 4 of 24 bits isn't read"),
            (b"BM".to_vec(), "it ends too early"),
        ] {
            assert_eq!(open(&bytes).unwrap_err(), format!("not a usable image: {cause}"));
        }
    }
}
