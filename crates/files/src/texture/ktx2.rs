//! KTX2 files of Basis Universal: ETC1S, and UASTC with or without Zstandard (`KHR_texture_basisu`).

use std::panic::catch_unwind;

use basisu::{DecodeFlags, TargetFormat, Transcoder};
use umbrage_scene::Texture;

use super::take;
use crate::memory::Budget;

const IDENTIFIER: [u8; 12] = *b"\xABKTX 20\xBB\r\n\x1A\n";

/// Whether bytes are a KTX2 file's.
pub(super) fn is_ktx2(bytes: &[u8]) -> bool {
    bytes.starts_with(&IDENTIFIER)
}

/// Width and height, at least 1, and the RGBA texels of the largest image, the upper row first.
///
/// # Errors
/// A message, where the file is broken, larger than [`Texture::MAX_SIDE`] or the budget, or isn't a picture that
/// glTF allows.
pub(super) fn decode(bytes: &[u8], budget: &Budget) -> Result<([u32; 2], Vec<[u8; 4]>), String> {
    let size = Header { bytes }.check().map_err(|cause| format!("not a usable image: KTX2: {cause}"))?;
    take(size, budget)?;
    let decoded = catch_unwind(|| Transcoder::new(bytes)?.transcode(0, TargetFormat::Rgba32, DecodeFlags::NONE));
    let Ok(Ok(texels)) = decoded else {
        return Err("not a usable image: KTX2: its compressed texels are broken".to_owned());
    };
    let (texels, _) = texels.as_chunks();
    Ok((size, texels.to_vec()))
}

/// A file's header, checked before it is used.
struct Header<'a> {
    bytes: &'a [u8],
}

/// Supercompression schemes.
const NONE: u32 = 0;
const BASIS_LZ: u32 = 1;
const ZSTANDARD: u32 = 2;

impl Header<'_> {
    /// Checks the header and returns the picture's size.
    ///
    /// # Errors
    /// A message why the picture can't be decoded.
    fn check(&self) -> Result<[u32; 2], String> {
        let [format, width, height, depth] = [self.word(12)?, self.word(20)?, self.word(24)?, self.word(28)?];
        let [layers, faces, levels, scheme] = [self.word(32)?, self.word(36)?, self.word(40)?, self.word(44)?];
        if format != 0 {
            return Err(format!("its texels are of Vulkan's format {format}, where glTF has Basis Universal"));
        }
        if width == 0 || height == 0 || depth != 0 || layers > 1 || faces != 1 {
            return Err("it is not one picture".to_owned());
        }
        if width.max(height) > Texture::MAX_SIDE {
            return Err(format!("{width}x{height} texels, where {0}x{0} are the most", Texture::MAX_SIDE));
        }
        if !(1..=16).contains(&levels) {
            return Err(format!("it says that it has {levels} levels"));
        }
        self.range(self.word(48)?.into(), self.word(52)?.into(), "the data format descriptor")?;
        self.range(self.word(56)?.into(), self.word(60)?.into(), "the key/value data")?;
        self.range(self.double(64)?, self.double(72)?, "the supercompression global data")?;
        let [first, length, inflated] = [self.double(80)?, self.double(88)?, self.double(96)?];
        self.range(first, length, "the first level")?;
        let model = self.word(self.word(48)? as usize + 12)? & 255;
        let blocks = u64::from(width.div_ceil(4)) * u64::from(height.div_ceil(4));
        const BYTES_OF_BLOCK: u64 = 16;
        match (model, scheme) {
            (ETC1S, BASIS_LZ) => {}
            (UASTC, NONE) if length == BYTES_OF_BLOCK * blocks => {}
            (UASTC, ZSTANDARD) if inflated == BYTES_OF_BLOCK * blocks => {}
            (UASTC, NONE | ZSTANDARD) => {
                return Err(format!("the first level has another number of bytes than {width}x{height} texels take"));
            }
            _ => {
                return Err(format!(
                    "colour model {model} with supercompression {scheme}, where glTF has ETC1S or UASTC"
                ));
            }
        }
        Ok([width, height])
    }

    fn word(&self, at: usize) -> Result<u32, String> {
        let bytes = self.bytes.get(at..).and_then(|bytes| bytes.first_chunk());
        bytes.map(|bytes| u32::from_le_bytes(*bytes)).ok_or_else(|| format!("it is cut off at byte {at}"))
    }

    fn double(&self, at: usize) -> Result<u64, String> {
        Ok(u64::from(self.word(at)?) | u64::from(self.word(at + 4)?) << 32)
    }

    fn range(&self, first: u64, length: u64, what: &str) -> Result<(), String> {
        match first.checked_add(length) {
            Some(end) if end <= self.bytes.len() as u64 => Ok(()),
            _ => Err(format!("{what}, {length} bytes from byte {first} on, is not all there")),
        }
    }
}

/// Colour models of the Khronos Data Format specification.
const ETC1S: u32 = 163;
const UASTC: u32 = 166;
