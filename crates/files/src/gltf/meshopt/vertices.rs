//! Vertices: the differences between neighbours, byte by byte of an element (mode ATTRIBUTES).
//!
//! The formats are defined in `EXT_meshopt_compression`, appendix A.1 (version 0), and in `KHR_meshopt_compression` (version
//! 1, with channels and control bits).

use super::{Bytes, signed};

/// Maximum size of a block of elements, in bytes and in elements.
const BLOCK_BYTES: usize = 0x2000;
const BLOCK_ELEMENTS: usize = 256;
/// Number of elements of a group within a block.
const GROUP: usize = 16;

/// Bits per difference, by a group's two header bits.
const BITS_OF_VERSION_0: [u8; 4] = [0, 2, 4, 8];
const BITS_OF_CONTROL: [[u8; 4]; 2] = [[0, 1, 2, 4], [1, 2, 4, 8]];

/// Decodes `count` elements of `stride` bytes.
///
/// # Errors
/// A message about the broken bytes.
pub(super) fn vertices(bytes: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, String> {
    let (version, bytes) = match bytes.split_first() {
        Some((0xa0, rest)) => (0, rest),
        Some((0xa1, rest)) => (1, rest),
        _ => return Err("its bytes don't begin as compressed attributes do".to_owned()),
    };
    let tail_length = if version == 0 { stride } else { stride + stride / 4 };
    let padded_length = tail_length.max(if version == 0 { 32 } else { 24 });
    let split = bytes.len().checked_sub(padded_length).ok_or("its bytes end too early")?;
    let (data, tail) = bytes.split_at(split);
    let (first, channels) = tail[padded_length - tail_length..].split_at(stride);
    let mut decoder = Vertices {
        data: Bytes::new(data),
        version,
        channels: if version == 0 { vec![0; stride / 4] } else { channels.to_vec() },
        last: first.to_vec(),
        differences: vec![[0; BLOCK_ELEMENTS]; stride],
    };
    let per_block = (BLOCK_BYTES / stride / GROUP * GROUP).min(BLOCK_ELEMENTS);
    let mut elements = vec![0; count * stride];
    for block in elements.chunks_mut(per_block * stride) {
        decoder.block(block)?;
    }
    decoder.data.expect_end()?;
    Ok(elements)
}

struct Vertices<'a> {
    data: Bytes<'a>,
    version: u8,
    /// For each four bytes of an element, the kind of difference to the previous element.
    channels: Vec<u8>,
    /// The previous element.
    last: Vec<u8>,
    /// For each byte of an element, the differences of a block's elements.
    differences: Vec<[u8; BLOCK_ELEMENTS]>,
}

impl Vertices<'_> {
    fn block(&mut self, elements: &mut [u8]) -> Result<(), String> {
        let stride = self.last.len();
        let count = elements.len() / stride;
        let control = self.data.take(if self.version == 0 { 0 } else { stride / 4 })?;
        for (byte, differences) in self.differences.iter_mut().enumerate() {
            let differences = &mut differences[..count.next_multiple_of(GROUP)];
            match control.get(byte / 4).map(|control| control >> (2 * (byte % 4)) & 3) {
                Some(2) => differences.fill(0),
                Some(3) => differences[..count].copy_from_slice(self.data.take(count)?),
                Some(control) => read_groups(&mut self.data, BITS_OF_CONTROL[usize::from(control)], differences)?,
                None => read_groups(&mut self.data, BITS_OF_VERSION_0, differences)?,
            }
        }
        for (at, element) in elements.chunks_exact_mut(stride).enumerate() {
            let (fours, _) = self.last.as_chunks_mut::<4>();
            for ((channel, last), differences) in self.channels.iter().zip(fours).zip(self.differences.as_chunks().0) {
                let differences: &[[u8; BLOCK_ELEMENTS]; 4] = differences;
                *last = add(*channel, *last, differences.map(|of_byte| of_byte[at]))?;
            }
            element.copy_from_slice(&self.last);
        }
        Ok(())
    }
}

/// Reads the differences of one byte of a block's elements.
fn read_groups(data: &mut Bytes<'_>, bits_of_mode: [u8; 4], differences: &mut [u8]) -> Result<(), String> {
    let (groups, _) = differences.as_chunks_mut::<GROUP>();
    let header = data.take(groups.len().div_ceil(4))?;
    for (number, group) in groups.iter_mut().enumerate() {
        let mode = header[number / 4] >> (2 * (number % 4)) & 3;
        match bits_of_mode[usize::from(mode)] {
            0 => group.fill(0),
            8 => group.copy_from_slice(data.take(GROUP)?),
            bits => read_group(data, bits, group)?,
        }
    }
    Ok(())
}

/// Reads sixteen differences of `bits` bits. Differences that don't fit have all bits set and follow as bytes.
fn read_group(data: &mut Bytes<'_>, bits: u8, group: &mut [u8; GROUP]) -> Result<(), String> {
    let per_byte = 8 / usize::from(bits);
    let packed = data.take(GROUP / per_byte)?;
    let too_large = (1 << bits) - 1;
    for (number, difference) in group.iter_mut().enumerate() {
        let within = (number % per_byte) as u8 * bits;
        // One bit each is stored from the lowest on, several from the highest on.
        let shift = if bits == 1 { within } else { 8 - bits - within };
        let small = packed[number / per_byte] >> shift & too_large;
        *difference = if small == too_large { data.byte()? } else { small };
    }
    Ok(())
}

/// Decodes four bytes from their differences to the previous element's.
fn add(channel: u8, last: [u8; 4], differences: [u8; 4]) -> Result<[u8; 4], String> {
    match channel & 3 {
        0 => {
            let sum = |byte: usize| last[byte].wrapping_add(signed(differences[byte].into()) as u8);
            Ok(std::array::from_fn(sum))
        }
        1 => {
            let sum = |low: usize| {
                let pair = |bytes: [u8; 4]| u16::from_le_bytes([bytes[low], bytes[low + 1]]);
                pair(last).wrapping_add(signed(pair(differences).into()) as u16).to_le_bytes()
            };
            let [[a, b], [c, d]] = [sum(0), sum(2)];
            Ok([a, b, c, d])
        }
        2 => {
            let turned = u32::from_le_bytes(differences).rotate_right((channel >> 4).into());
            Ok((u32::from_le_bytes(last) ^ turned).to_le_bytes())
        }
        _ => Err("a channel's mode is none of 0, 1 and 2".to_owned()),
    }
}
