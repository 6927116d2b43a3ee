use crate::shot::TileOrder;

/// The bin of one range of triangles in one tile.
#[derive(Clone, Debug, Default)]
pub(crate) struct Bin {
    /// Samples of tiny triangles. 16 bytes each.
    pub(crate) fragments: Vec<Fragment>,
    /// Patches. Eight bytes each, as in the other lists.
    pub(crate) patches: Vec<Listed>,
    /// Triangles for the fast path.
    pub(crate) ordinary: Vec<Listed>,
    /// Triangles for the general path.
    pub(crate) general: Vec<Listed>,
    /// Triangles for the fast path with a mask.
    pub(crate) masked: Vec<Listed>,
    /// Triangles for the general path with a mask.
    pub(crate) masked_general: Vec<Listed>,
}

/// A triangle, or a patch, that may be hit in a tile. 8 bytes.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Listed {
    /// The slot of a triangle (see [`Patches::triangle`](crate::Patches::triangle)), or a patch's number with the bit
    /// [`Listed::PATCH`].
    pub(crate) slot: u32,
    /// Upper bound of the inverse depth of all hits in the tile; infinite where there is none.
    pub(crate) nearest: f32,
}

impl Listed {
    /// The bit that marks patches.
    pub(crate) const PATCH: u32 = 1 << 31;
}

/// A sample that a tiny triangle hits or may hit. 16 bytes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fragment {
    /// The sample's index in the tile: see [`TileOrder`]. The highest bit, [`Fragment::UNDECIDED`], is set for cases that
    /// the predicate has to settle.
    pub(crate) index: u32,
    /// The triangle.
    pub(crate) triangle: u32,
    /// Lower bound of the inverse depth.
    pub(crate) low: f32,
    /// Upper bound of the inverse depth.
    pub(crate) high: f32,
}

impl Fragment {
    pub(crate) const UNDECIDED: u32 = 1 << 31;
}

/// Bytes of a slice's contents.
pub fn bytes_of<T>(list: &[T]) -> usize {
    size_of_val(list)
}

impl Bin {
    fn clear(&mut self) {
        let Self { fragments, patches, ordinary, general, masked, masked_general } = self;
        fragments.clear();
        for list in [patches, ordinary, general, masked, masked_general] {
            list.clear();
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.fragments.is_empty() && self.patches.is_empty() && self.lists().all(Vec::is_empty)
    }

    pub(crate) fn bytes(&self) -> usize {
        bytes_of(&self.fragments) + bytes_of(&self.patches) + self.lists().map(|list| bytes_of(list)).sum::<usize>()
    }

    /// The lists of triangles.
    pub(crate) fn lists(&self) -> impl Iterator<Item = &Vec<Listed>> {
        [&self.ordinary, &self.general, &self.masked, &self.masked_general].into_iter()
    }
}

/// The list of a bin that a triangle or patch goes to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Path {
    Patch,
    Ordinary,
    General,
    Masked,
    MaskedGeneral,
}

/// The bins of one range of triangles: one for each tile, row by row.
#[derive(Clone, Debug, Default)]
pub(crate) struct Bins {
    pub(crate) columns: i32,
    pub(crate) rows: i32,
    pub(crate) bins: Vec<Bin>,
}

impl Bins {
    /// Log₂ of the samples a side of a tile.
    pub(crate) const TILE_BITS: u32 = TileOrder::TILE_BITS;
    /// Samples a side of a tile.
    pub(crate) const TILE: u32 = TileOrder::TILE;

    /// Empties all bins and makes one for each of `columns` × `rows` tiles.
    pub(crate) fn reset(&mut self, columns: u32, rows: u32) {
        (self.columns, self.rows) = (columns as i32, rows as i32);
        self.bins.iter_mut().for_each(Bin::clear);
        self.bins.resize_with(columns as usize * rows as usize, Bin::default);
    }

    /// The bin of the tile with the pixel in column `x` and row `y`.
    #[inline(always)]
    pub(crate) fn bin_mut(&mut self, x: i32, y: i32) -> &mut Bin {
        let tile = (y >> Self::TILE_BITS) * self.columns + (x >> Self::TILE_BITS);
        &mut self.bins[tile as usize]
    }

    /// Lists a triangle in the tiles of `tiles` (columns, then rows) whose samples it may hit.
    pub(crate) fn list(&mut self, path: Path, listed: Listed, [x0, x1, y0, y1]: [i32; 4]) {
        for y in y0..=y1 {
            for x in x0..=x1 {
                self.push(path, listed, x, y);
            }
        }
    }

    pub(crate) fn push(&mut self, path: Path, listed: Listed, column: i32, row: i32) {
        let bin = &mut self.bins[(row * self.columns + column) as usize];
        let list = match path {
            Path::Patch => &mut bin.patches,
            Path::Ordinary => &mut bin.ordinary,
            Path::General => &mut bin.general,
            Path::Masked => &mut bin.masked,
            Path::MaskedGeneral => &mut bin.masked_general,
        };
        list.push(listed);
    }
}
