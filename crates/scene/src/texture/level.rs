//! A mip level of a texture.

use std::borrow::Cow;
use std::sync::Arc;

use glam::Vec4;

use super::ColorSpace;
use super::pool::{LastSlot, SIDE, TEXELS, TilePool};

#[derive(Clone, Debug)]
pub(super) struct Level {
    pub(super) width: u32,
    pub(super) height: u32,
    texels: Texels,
}

#[derive(Clone, Debug)]
enum Texels {
    /// In rows, the upper row first.
    Held(Arc<[[u8; 4]]>),
    OnDemand(Arc<Tiles>),
}

/// The tiles of a level, each of 32×32 texels; tiles at the right and lower edges are padded with black.
#[derive(Debug)]
struct Tiles {
    pool: Arc<TilePool>,
    /// Number of the first tile in the pool's file.
    first: u64,
    /// Number of tiles per row.
    across: usize,
    /// Last slot of each tile, in rows.
    last_slots: Box<[LastSlot]>,
}

impl Level {
    pub(super) fn new([width, height]: [u32; 2], texels: Vec<[u8; 4]>) -> Self {
        Self { width, height, texels: Texels::Held(texels.into()) }
    }

    /// Moves the texels to a pool's file.
    ///
    /// # Errors
    /// A message why they can't be written.
    pub(super) fn on_demand(self, pool: &Arc<TilePool>) -> Result<Self, String> {
        let Texels::Held(texels) = &self.texels else { return Ok(self) };
        let tiles = Tiles::write(self.width as usize, texels, pool)?;
        Ok(Self { texels: Texels::OnDemand(Arc::new(tiles)), ..self })
    }

    /// The pool of its texels, unless they are all in memory.
    pub(super) fn pool(&self) -> Option<&Arc<TilePool>> {
        match &self.texels {
            Texels::Held(_) => None,
            Texels::OnDemand(tiles) => Some(&tiles.pool),
        }
    }

    /// Bytes in memory, without the pool's.
    pub(super) fn bytes(&self) -> usize {
        match &self.texels {
            Texels::Held(texels) => size_of_val(&**texels),
            Texels::OnDemand(tiles) => size_of_val(&*tiles.last_slots),
        }
    }

    /// All texels in rows, the upper row first.
    pub(super) fn rows(&self) -> Cow<'_, [[u8; 4]]> {
        match &self.texels {
            Texels::Held(texels) => Cow::Borrowed(&**texels),
            Texels::OnDemand(tiles) => tiles.rows([self.width, self.height].map(|side| side as usize)).into(),
        }
    }

    #[inline]
    pub(super) fn texel(&self, x: usize, y: usize) -> [u8; 4] {
        match &self.texels {
            Texels::Held(texels) => texels[y * self.width as usize + x],
            Texels::OnDemand(tiles) => tiles.texel(x, y),
        }
    }

    /// Applies `mix` to the texels in two columns and two rows.
    ///
    /// Takes a function instead of returning the texels, so that textures in memory are read straight into registers.
    #[inline]
    pub(super) fn mixed<R>(
        &self,
        [west, east]: [usize; 2],
        [north, south]: [usize; 2],
        mix: impl FnOnce([[[u8; 4]; 2]; 2]) -> R,
    ) -> R {
        match &self.texels {
            Texels::Held(texels) => {
                let [north, south] = [north, south].map(|y| y * self.width as usize);
                mix([[texels[north + west], texels[north + east]], [texels[south + west], texels[south + east]]])
            }
            Texels::OnDemand(tiles) => mix(tiles.four([west, east], [north, south])),
        }
    }

    /// The level of half the size, rounded down; `None` after a level of one texel.
    pub(super) fn halved(&self, space: ColorSpace) -> Option<Self> {
        if self.width == 1 && self.height == 1 {
            return None;
        }
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let texel = |x: u32, y: u32| {
            let (x, y) = (x.min(self.width - 1), y.min(self.height - 1));
            space.decode(self.texel(x as usize, y as usize))
        };
        let texels = (0..height)
            .flat_map(|y| (0..width).map(move |x| (2 * x, 2 * y)))
            .map(|(x, y)| {
                let four = [texel(x, y), texel(x + 1, y), texel(x, y + 1), texel(x + 1, y + 1)];
                // Colours are weighted by opacity, so that masked texels don't bleed into visible ones.
                let opacity: f32 = four.iter().map(|texel| texel.w).sum();
                let mean = four.iter().sum::<Vec4>() * 0.25;
                let weighted = four.iter().map(|texel| *texel * texel.w).sum::<Vec4>() / opacity;
                space.encode(if opacity > 0.0 && space == ColorSpace::Srgb { weighted.with_w(mean.w) } else { mean })
            })
            .collect();
        Some(Self::new([width, height], texels))
    }
}

impl Tiles {
    /// Writes an image as tiles, a row of tiles at a time.
    fn write(width: usize, texels: &[[u8; 4]], pool: &Arc<TilePool>) -> Result<Self, String> {
        let across = width.div_ceil(SIDE);
        let rows_of_tiles = texels.chunks(width * SIDE);
        let count = across * rows_of_tiles.len();
        let first = pool.reserve(count as u64);
        let mut row_of_tiles = vec![[0; 4]; across * TEXELS];
        for (down, rows) in rows_of_tiles.enumerate() {
            row_of_tiles.fill([0; 4]);
            for (y, row) in rows.chunks(width).enumerate() {
                for (part, tile) in row.chunks(SIDE).zip(row_of_tiles.chunks_mut(TEXELS)) {
                    tile[y * SIDE..][..part.len()].copy_from_slice(part);
                }
            }
            pool.write(first + (down * across) as u64, &row_of_tiles)?;
        }
        Ok(Self {
            pool: Arc::clone(pool),
            first,
            across,
            last_slots: (0..count).map(|_| LastSlot::default()).collect(),
        })
    }

    fn rows(&self, [width, height]: [usize; 2]) -> Vec<[u8; 4]> {
        let mut texels = Vec::with_capacity(width * height);
        let mut row_of_tiles = vec![[0; 4]; self.across * TEXELS];
        for down in 0..height.div_ceil(SIDE) {
            self.pool.read_past(self.first + (down * self.across) as u64, &mut row_of_tiles);
            for y in 0..SIDE.min(height - down * SIDE) {
                let row = row_of_tiles.chunks(TEXELS).flat_map(|tile| &tile[y * SIDE..][..SIDE]);
                texels.extend(row.take(width));
            }
        }
        texels
    }

    // Not inlined, so that the code for textures in memory stays short.
    #[inline(never)]
    fn texel(&self, x: usize, y: usize) -> [u8; 4] {
        self.read(self.tile(x, y), |texels| texels[in_tile(x, y)])
    }

    // Not inlined, like `texel`.
    #[inline(never)]
    fn four(&self, columns: [usize; 2], rows: [usize; 2]) -> [[[u8; 4]; 2]; 2] {
        let tile = self.tile(columns[0], rows[0]);
        if tile == self.tile(columns[1], rows[1]) {
            return self.read(tile, |texels| rows.map(|y| columns.map(|x| texels[in_tile(x, y)])));
        }
        rows.map(|y| columns.map(|x| self.texel(x, y)))
    }

    /// The index of a texel's tile.
    #[inline]
    fn tile(&self, x: usize, y: usize) -> usize {
        y / SIDE * self.across + x / SIDE
    }

    #[inline]
    fn read<R>(&self, tile: usize, get: impl FnOnce(&[[u8; 4]]) -> R) -> R {
        self.pool.read(self.first + tile as u64, &self.last_slots[tile], get)
    }
}

/// The index of a texel in its tile.
#[inline]
fn in_tile(x: usize, y: usize) -> usize {
    y % SIDE * SIDE + x % SIDE
}
