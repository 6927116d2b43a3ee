use std::borrow::Cow;
use std::sync::{Arc, LazyLock, OnceLock};

use glam::{Vec2, Vec4};

use level::Level;

mod level;
mod opacity;
mod pool;
mod wrap;

pub(crate) use opacity::TexelRanges;
pub use pool::{TextureTraffic, TilePool};

/// An image with its mip levels, filter and wrap modes.
///
/// Takes four bytes per texel, and a third more for mip levels: in memory, or [in a file](Texture::kept_in) whose tiles are
/// read on demand. Clones share the texels.
#[derive(Clone, Debug)]
pub struct Texture {
    /// Name or path in the file; may be empty.
    pub name: String,
    space: ColorSpace,
    filter: Filter,
    wrap: [Wrap; 2],
    levels: Vec<Level>,
    /// Minimum and maximum opacity of the texels that are mixed in each cell of the full image; computed at first use.
    opacities: Arc<OnceLock<Vec<[u8; 2]>>>,
}

/// Filtering between texel centres.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Filter {
    /// The nearest texel.
    Nearest,
    /// Trilinear: the four nearest texels in each of the two nearest mip levels.
    Linear,
}

/// Continuation of an image beyond its edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Wrap {
    /// The image repeats.
    Repeat,
    /// The image alternates with its mirror image.
    MirroredRepeat,
    /// The edge texels continue.
    ClampToEdge,
}

/// Encoding of an image's samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ColorSpace {
    /// Colours, encoded by the sRGB transfer function; alpha is linear.
    Srgb,
    /// Linear quantities.
    Linear,
}

impl Texture {
    /// Makes a texture from rows of RGBA texels, the upper row first.
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

    /// The same texture, with its texels in a pool's file instead of in memory.
    ///
    /// # Errors
    /// A message why they can't be written there.
    pub fn kept_in(mut self, pool: &Arc<TilePool>) -> Result<Self, String> {
        let levels = self.levels.into_iter().map(|level| level.on_demand(pool));
        self.levels = levels.collect::<Result<_, _>>()?;
        Ok(self)
    }

    /// Longest side that decoders of image files accept, in texels.
    pub const MAX_SIDE: u32 = 16_384;

    /// Width and height of the full image, in texels.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        [self.levels[0].width, self.levels[0].height]
    }

    /// The mip levels, from the full image on, each half as wide and high as the previous one, rounded down but at least 1.
    /// They are RGBA texels in rows, the upper row first.
    ///
    /// Levels of a texture on demand are read from its file.
    pub fn levels(&self) -> impl ExactSizeIterator<Item = Cow<'_, [[u8; 4]]>> {
        self.levels.iter().map(Level::rows)
    }

    /// Encoding of the samples.
    #[must_use]
    pub fn space(&self) -> ColorSpace {
        self.space
    }

    /// Filtering between texel centres.
    #[must_use]
    pub fn filter(&self) -> Filter {
        self.filter
    }

    /// Wrap modes in x and in y.
    #[must_use]
    pub fn wrap(&self) -> [Wrap; 2] {
        self.wrap
    }

    /// Bytes in memory: texels of all levels and opacity bounds; for a texture on demand, the table of its tiles.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let opacities = self.opacities.get().map_or(0, |opacities| size_of_val(opacities.as_slice()));
        opacities + self.levels.iter().map(Level::bytes).sum::<usize>()
    }

    /// The pool of its texels, unless they are all in memory.
    pub(crate) fn tile_pool(&self) -> Option<&Arc<TilePool>> {
        self.levels[0].pool()
    }

    /// Samples the linear colour at `coords`, averaged over about `footprint_texels` texels of the full image.
    #[must_use]
    pub fn sample(&self, coords: Vec2, footprint_texels: f32) -> Vec4 {
        let last = (self.levels.len() - 1) as f32;
        // NaN footprints, of degenerate coordinates, read the full image.
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

    /// Fetches, for each lane of the mask `lanes` (lane 0 in the lowest bit), the texels in two columns and two rows of a
    /// level: first row, then second, red in the lowest byte. Other lanes are zero.
    ///
    /// # Panics
    /// If the level, column or row of a lane is out of range.
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

    /// Bilinear mix of the four nearest texels.
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

/// The linear value of each sRGB byte.
static LINEAR_FROM_SRGB: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|byte| linear_from_srgb(byte as f64 / 255.0) as f32));

/// Each byte divided by 255.
static QUANTITY: [f32; 256] = {
    let mut quantities = [0.0; 256];
    let mut byte = 0;
    while byte < quantities.len() {
        quantities[byte] = byte as f32 / 255.0;
        byte += 1;
    }
    quantities
};

/// Decodes a texel by the table `colors`; alpha is linear.
#[inline]
fn decode(colors: &[f32; 256], texel: [u8; 4]) -> Vec4 {
    let [r, g, b, a] = texel.map(usize::from);
    Vec4::new(colors[r], colors[g], colors[b], QUANTITY[a])
}

/// Decodes an sRGB value; both are 0 … 1 (IEC 61966-2-1).
#[must_use]
pub fn linear_from_srgb(encoded: f64) -> f64 {
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
    #[must_use]
    pub fn decode(self, texel: [u8; 4]) -> Vec4 {
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
