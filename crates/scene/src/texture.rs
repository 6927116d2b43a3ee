use std::borrow::Cow;
use std::sync::{Arc, LazyLock, OnceLock};

use glam::{Vec2, Vec4};

use crate::image_file::{self, ImageFormat};
use crate::memory::Budget;
use level::Level;

#[cfg(all(feature = "avif", not(target_family = "wasm")))]
mod avif;
mod ktx2;
mod level;
mod opacity;
mod pool;
mod positioned;
mod wrap;

pub use pool::TextureTraffic;
pub(crate) use pool::TilePool;

/// An image with its smaller copies (mip levels), and how it is read between and beyond its texels.
///
/// Four bytes a texel, and a third more for the smaller copies: in memory, or where the scene was opened so
/// ([`OpenOptions::texture_memory`](crate::OpenOptions::texture_memory)), in a file from which tiles are read on demand.
/// Clones have the texels in common.
#[derive(Clone, Debug)]
pub struct Texture {
    /// Its name or path in the file; may be empty.
    pub name: String,
    space: ColorSpace,
    filter: Filter,
    wrap: [Wrap; 2],
    levels: Vec<Level>,
    /// Made when it is first asked for: the least and the greatest opacity of the texels that are mixed in each cell of
    /// the full image.
    opacities: Arc<OnceLock<Vec<[u8; 2]>>>,
}

/// How texels are read between their centres.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Filter {
    /// The nearest texel.
    Nearest,
    /// Mixed from the four nearest texels, and from the two nearest levels.
    Linear,
}

/// What lies beyond an edge of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Wrap {
    /// The image again.
    Repeat,
    /// The image mirrored, then the image again.
    MirroredRepeat,
    /// The edge's texels.
    ClampToEdge,
}

/// What an image's numbers mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ColorSpace {
    /// Colours, encoded by the sRGB transfer function; alpha is linear.
    Srgb,
    /// Quantities.
    Linear,
}

impl Texture {
    /// A texture from rows of RGBA texels, the upper row first.
    ///
    /// # Panics
    /// If a side is zero or `texels` isn't `width · height` long.
    #[must_use]
    pub fn new(
        name: impl Into<String>,
        [width, height]: [u32; 2],
        texels: Vec<[u8; 4]>,
        space: ColorSpace,
        filter: Filter,
        wrap: [Wrap; 2],
    ) -> Self {
        assert!(width > 0 && height > 0, "a texture has at least one texel");
        assert_eq!(texels.len() as u64, u64::from(width) * u64::from(height), "one value for each texel");
        let mut levels = vec![Level::new([width, height], texels)];
        while let Some(smaller) = levels.last().and_then(|level| level.halved(space)) {
            levels.push(smaller);
        }
        Self { name: name.into(), space, filter, wrap, levels, opacities: Arc::default() }
    }

    /// A texture from the bytes of an image file (PNG, JPEG, WebP, BMP, TGA or KTX2, and with the feature `avif` AVIF).
    ///
    /// # Errors
    /// Says in words why the bytes are no such image, or that it is larger than [`Texture::MAX_SIDE`].
    pub fn decode(
        name: impl Into<String>,
        bytes: &[u8],
        space: ColorSpace,
        filter: Filter,
        wrap: [Wrap; 2],
    ) -> Result<Self, String> {
        Self::decode_within(&Budget::default(), name, bytes, space, filter, wrap)
    }

    /// As [`Texture::decode`], within a budget of memory.
    ///
    /// # Errors
    /// As [`Texture::decode`], and where the budget is too small.
    pub(crate) fn decode_within(
        budget: &Budget,
        name: impl Into<String>,
        bytes: &[u8],
        space: ColorSpace,
        filter: Filter,
        wrap: [Wrap; 2],
    ) -> Result<Self, String> {
        let (size, texels) = Self::decode_texels(bytes, budget)?;
        Self::new(name, size, texels, space, filter, wrap).kept_by(budget)
    }

    /// The same texture with its texels where the budget has them kept.
    ///
    /// # Errors
    /// Says in words why they can't be kept there.
    pub(crate) fn kept_by(mut self, budget: &Budget) -> Result<Self, String> {
        let Some(pool) = budget.tile_pool()? else { return Ok(self) };
        let levels = self.levels.into_iter().map(|level| level.on_demand(pool));
        self.levels = levels.collect::<Result<_, _>>()?;
        budget.keep(self.bytes() as u64, "the tables of textures on demand")?;
        Ok(self)
    }

    /// Takes the memory of an image of a size: all of its levels, and what will be known of their opacity.
    ///
    /// # Errors
    /// Says in words that there isn't enough.
    pub(crate) fn take([width, height]: [u32; 2], budget: &Budget) -> Result<(), String> {
        const BYTES: u64 = 8;
        let bytes = BYTES.saturating_mul(u64::from(width)).saturating_mul(u64::from(height));
        budget.take(bytes, format_args!("an image of {width}x{height} texels"))
    }

    /// Width and height, at least 1, and the RGBA texels of an image file, the upper row first.
    ///
    /// # Errors
    /// As [`Texture::decode_within`].
    pub(crate) fn decode_texels(bytes: &[u8], budget: &Budget) -> Result<([u32; 2], Vec<[u8; 4]>), String> {
        if ktx2::is_ktx2(bytes) {
            return ktx2::decode(bytes, budget);
        }
        if is_avif(bytes) {
            #[cfg(all(feature = "avif", not(target_family = "wasm")))]
            return avif::decode(bytes, budget);
            #[cfg(not(any(feature = "avif", target_family = "wasm")))]
            return Err(AVIF_LEFT_OUT.to_owned());
            #[cfg(target_family = "wasm")]
            return Err(
                "AVIF images are not read in browsers; convert it to PNG, as with ImageMagick or GIMP".to_owned()
            );
        }
        // TGA is the one format that doesn't say in its first bytes what it is.
        let format = image_file::format(bytes).unwrap_or(ImageFormat::Tga);
        let image = image_file::decode(bytes, format, budget.all(), &mut |[width, height]| {
            if width == 0 || height == 0 {
                return Err("an image without texels".to_owned());
            }
            if width.max(height) > Self::MAX_SIDE {
                return Err(format!(
                    "not a usable image: a side of {width}x{height} texels is longer than {}",
                    Self::MAX_SIDE
                ));
            }
            Self::take([width, height], budget)
        })?;
        Ok((image.size, image.rgba()))
    }

    /// The longest side of an image that [`Texture::decode`] accepts, in texels.
    pub const MAX_SIDE: u32 = 16_384;

    /// Width and height of the full image, in texels.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        [self.levels[0].width, self.levels[0].height]
    }

    /// The image and its smaller copies, each half as wide and high as the one before, rounded down but at least 1: RGBA
    /// texels in rows, the upper row first.
    ///
    /// Those of a texture on demand are read from its file.
    pub fn levels(&self) -> impl ExactSizeIterator<Item = Cow<'_, [[u8; 4]]>> {
        self.levels.iter().map(Level::rows)
    }

    /// What its numbers mean.
    #[must_use]
    pub fn space(&self) -> ColorSpace {
        self.space
    }

    /// How it is read between its texels.
    #[must_use]
    pub fn filter(&self) -> Filter {
        self.filter
    }

    /// What lies beyond its edges in x and in y.
    #[must_use]
    pub fn wrap(&self) -> [Wrap; 2] {
        self.wrap
    }

    /// Bytes taken by the texels of all levels, and by what is known of their opacity; of a texture on demand by what says
    /// where its tiles are.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let opacities = self.opacities.get().map_or(0, |opacities| size_of_val(opacities.as_slice()));
        opacities + self.levels.iter().map(Level::bytes).sum::<usize>()
    }

    /// Where its texels are, unless they are all in memory.
    pub(crate) fn tile_pool(&self) -> Option<&Arc<TilePool>> {
        self.levels[0].pool()
    }

    /// The linear colour at `coords`, averaged over about `footprint_texels` texels of the full image.
    #[must_use]
    pub fn sample(&self, coords: Vec2, footprint_texels: f32) -> Vec4 {
        let last = (self.levels.len() - 1) as f32;
        // NaN footprints (a texture stretched to nothing) read the full image.
        let lod = libm::log2f(footprint_texels.max(1.0)).min(last);
        let fine = lod as usize;
        let part = lod - fine as f32;
        match self.filter {
            Filter::Nearest => self.nearest(&self.levels[lod.round() as usize], coords),
            Filter::Linear if part == 0.0 => self.mixed(&self.levels[fine], coords),
            Filter::Linear => {
                self.mixed(&self.levels[fine], coords).lerp(self.mixed(&self.levels[fine + 1], coords), part)
            }
        }
    }

    /// The texels in two columns of two rows of a level, for each of some `lanes`, the first in the lowest bit: those of the
    /// first row, then those of the second, red in the lowest byte. Zero in other lanes.
    ///
    /// # Panics
    /// If one of the lanes names a level, a column or a row that there isn't.
    #[must_use]
    pub fn fetch(
        &self,
        lanes: u16,
        levels: &[u32; 16],
        columns: [&[u32; 16]; 2],
        rows: [&[u32; 16]; 2],
    ) -> [[u32; 16]; 4] {
        let mut fetched = [[0; 16]; 4];
        for lane in (0..16).filter(|lane| lanes >> lane & 1 == 1) {
            let [columns, rows] = [columns, rows].map(|pair| pair.map(|texels| texels[lane] as usize));
            let [[a, b], [c, d]] = self.levels[levels[lane] as usize].mixed(columns, rows, |four| four);
            for (to, texel) in fetched.iter_mut().zip([a, b, c, d]) {
                to[lane] = u32::from_le_bytes(texel);
            }
        }
        fetched
    }

    fn nearest(&self, level: &Level, coords: Vec2) -> Vec4 {
        let x = self.wrap[0].nearest(coords.x * level.width as f32, level.width);
        let y = self.wrap[1].nearest(coords.y * level.height as f32, level.height);
        self.space.decode(level.texel(x, y))
    }

    /// Mixed from the four nearest texels.
    #[inline]
    fn mixed(&self, level: &Level, coords: Vec2) -> Vec4 {
        let (columns, right) = self.wrap[0].mixed(coords.x * level.width as f32, level.width);
        let (rows, down) = self.wrap[1].mixed(coords.y * level.height as f32, level.height);
        let colors = self.space.values();
        level.mixed(columns, rows, |four| {
            let [upper, lower] = four.map(|[west, east]| decode(colors, west).lerp(decode(colors, east), right));
            upper.lerp(lower, down)
        })
    }
}

/// Whether there is a decoder for AVIF.
pub(crate) const READS_AVIF: bool = cfg!(all(feature = "avif", not(target_family = "wasm")));

/// Part of every error and warning about an AVIF texture in a build without the feature `avif`.
///
/// A program can look for it in [`Error`](crate::Error)s and [`Scene::warnings`](crate::Scene::warnings), to add how its users
/// get the feature.
pub const AVIF_LEFT_OUT: &str = "AVIF textures need the feature `avif`, which this build leaves out";

/// Whether bytes are an AVIF file's: its first box names kinds of files, and that is one of them.
fn is_avif(bytes: &[u8]) -> bool {
    let Some((length, rest)) = bytes.split_first_chunk() else { return false };
    let length = (u32::from_be_bytes(*length) as usize).clamp(4, bytes.len()) - 4;
    let (names, _) = rest[..length].as_chunks();
    names.first() == Some(b"ftyp") && names.iter().any(|name| name == b"avif" || name == b"avis")
}

/// The linear value of each sRGB byte.
static LINEAR_FROM_SRGB: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|byte| linear_from_srgb(byte as f64 / 255.0) as f32));

/// The part of 255 that each byte is.
static QUANTITY: [f32; 256] = {
    let mut quantities = [0.0; 256];
    let mut byte = 0;
    while byte < quantities.len() {
        quantities[byte] = byte as f32 / 255.0;
        byte += 1;
    }
    quantities
};

/// A texel whose colour's bytes stand for `colors`.
#[inline]
fn decode(colors: &[f32; 256], texel: [u8; 4]) -> Vec4 {
    let [r, g, b, a] = texel.map(usize::from);
    Vec4::new(colors[r], colors[g], colors[b], QUANTITY[a])
}

/// The linear value of an sRGB-encoded one, both 0 … 1 (IEC 61966-2-1).
pub(crate) fn linear_from_srgb(encoded: f64) -> f64 {
    if encoded <= 0.04045 { encoded / 12.92 } else { libm::pow((encoded + 0.055) / 1.055, 2.4) }
}

impl ColorSpace {
    /// The linear value of each byte of a colour that is encoded by the sRGB transfer function.
    #[must_use]
    pub fn linear_from_srgb() -> &'static [f32; 256] {
        &LINEAR_FROM_SRGB
    }

    /// The linear value of each byte of a colour.
    #[inline]
    fn values(self) -> &'static [f32; 256] {
        match self {
            Self::Srgb => &LINEAR_FROM_SRGB,
            Self::Linear => &QUANTITY,
        }
    }

    /// The linear colour and the opacity, 0 … 1, of a texel.
    pub(crate) fn decode(self, texel: [u8; 4]) -> Vec4 {
        decode(self.values(), texel)
    }

    fn encode(self, linear: Vec4) -> [u8; 4] {
        let byte = |encoded: f32| (encoded * 255.0).round() as u8;
        let color = |linear: f32| match self {
            Self::Srgb if linear <= 0.003_130_8 => byte(12.92 * linear),
            Self::Srgb => byte(1.055 * libm::powf(linear, 1.0 / 2.4) - 0.055),
            Self::Linear => byte(linear),
        };
        [color(linear.x), color(linear.y), color(linear.z), byte(linear.w)]
    }
}
