//! The paper's own form of the light grid (Guntury and Narayanan 2010, §4): what the direct form is compared with.
//!
//! The light's faces and the points on them are found as in the direct form. Then points are sorted by cell, each
//! triangle is listed in the cells that it covers between the light and the cell's farthest point, pairs of a triangle
//! and a cell are sorted by cell, and each cell's points are tested against its triangles. A cell with R points makes
//! ⌈R/r⌉ blocks of work (§4.3); one with many triangles makes as many times more, which the paper leaves for later. The
//! same f32 test, f64 filter and predicate decide as in the direct form.

mod list;
mod locate;
mod points;
mod sort;
mod trace;
mod validate;

use crate::SimdLevel;
use crate::light_grid::cells::{Axis, Cells, Row};
use crate::light_grid::large::Plane;
use crate::{LightGrid, SeenImage};
use list::Range;
use points::PointRow;
use sort::{Bins, SortedRow};
use trace::Block;

/// Which points that the camera sees a light reaches, with triangles listed by cell, rebuilt for every frame and light.
///
/// Beside what a [`LightGrid`] takes to map points, 8 + 8 + 4 bytes for each point on its way to its cell, 20 or more
/// for each there, and as much as for a point for each pair of a triangle and a cell. Keep it and use it again: its
/// memory is reused.
#[derive(Default)]
pub struct ListedLightGrid {
    /// For the light's faces and the points on them.
    grid: LightGrid,
    options: ListedLightOptions,
    cells: Cells,
    /// How far a point may be from its cell.
    margin: f32,
    point_bins: Vec<Bins>,
    point_rows: Vec<PointRow>,
    ranges: Vec<Range>,
    triangle_rows: Vec<SortedRow>,
    /// Triangles that cover many cells or reach around the light, with their ids.
    large: Vec<(u32, Plane)>,
    blocks: Vec<Block>,
    counts: ListedLightCounts,
    seconds: ListedLightSeconds,
}

impl std::fmt::Debug for ListedLightGrid {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ListedLightGrid").field("options", &self.options).field("counts", &self.counts).finish()
    }
}

/// The parameters of a [`ListedLightGrid`]: they change how fast it is, and nothing that it finds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ListedLightOptions {
    side: u32,
    points: u32,
    triangles: u32,
}

impl Default for ListedLightOptions {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl ListedLightOptions {
    /// 192 × 192 cells, 256 points and 512 triangles to a block of work.
    pub const DEFAULT: Self = Self { side: 192, points: 256, triangles: 512 };
    /// The most cells a side.
    pub const MOST_CELLS: u32 = 2048;
    /// The most points, and the most triangles, of a block of work.
    pub const LARGEST_BLOCK: u32 = 4096;

    /// `cells` × `cells` cells (up to [`MOST_CELLS`](Self::MOST_CELLS)²) on each face of the light, and work in blocks
    /// of at most `points`, the paper's r, which is rounded up to a multiple of 16, times `triangles` (both up to
    /// [`LARGEST_BLOCK`](Self::LARGEST_BLOCK)).
    ///
    /// # Errors
    /// If a number is zero or too large.
    pub fn new(cells: u32, points: u32, triangles: u32) -> Result<Self, ImpossibleLightCells> {
        let sizes = 1..=Self::LARGEST_BLOCK;
        if (1..=Self::MOST_CELLS).contains(&cells) && sizes.contains(&points) && sizes.contains(&triangles) {
            Ok(Self { side: cells, points: points.next_multiple_of(crate::simd::lanes::LANES as u32), triangles })
        } else {
            Err(ImpossibleLightCells { cells, points, triangles })
        }
    }

    /// Cells a side of each face.
    #[must_use]
    pub fn cells(&self) -> u32 {
        self.side
    }

    /// The most points of a block of work: the paper's r.
    #[must_use]
    pub fn points(&self) -> u32 {
        self.points
    }

    /// The most triangles of a block of work.
    #[must_use]
    pub fn triangles(&self) -> u32 {
        self.triangles
    }
}

/// Numbers that no [`ListedLightOptions`] can have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImpossibleLightCells {
    /// Cells a side.
    pub cells: u32,
    /// Points of a block of work.
    pub points: u32,
    /// Triangles of a block of work.
    pub triangles: u32,
}

impl std::fmt::Display for ImpossibleLightCells {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { cells, points, triangles } = self;
        let (most, largest) = (ListedLightOptions::MOST_CELLS, ListedLightOptions::LARGEST_BLOCK);
        write!(
            f,
            "{cells} light cells a side, blocks of {points} points and {triangles} triangles: there are 1 to {most} \
             cells, and 1 to {largest} points and triangles"
        )
    }
}

impl std::error::Error for ImpossibleLightCells {}

/// What the last [`ListedLightGrid::shadow`] did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ListedLightCounts {
    /// Points that were tested, once for each face that they are on or beside.
    pub points: u64,
    /// Points that no face of the light could hold, tested against every triangle.
    pub outliers: u64,
    /// Faces of the light that see points.
    pub faces: u64,
    /// Cells with points.
    pub cells: u64,
    /// Pairs of a triangle and a cell.
    pub pairs: u64,
    /// Triangles that cover many cells or reach around the light.
    pub large_triangles: u64,
    /// Blocks of work.
    pub blocks: u64,
    /// Tests of a triangle against up to 16 points.
    pub tests: u64,
    /// Pairs of a triangle and a point that the fast test couldn't decide.
    pub undecided: u64,
    /// Pairs that the fast test decided in vain, because the triangle isn't opaque.
    pub masked: u64,
    /// Pairs that the predicate was asked about.
    pub asked: u64,
}

impl ListedLightCounts {
    /// Each count with its name.
    #[must_use]
    pub fn named(&self) -> [(&'static str, u64); 11] {
        let Self { points, outliers, faces, cells, pairs, large_triangles, .. } = *self;
        let Self { blocks, tests, undecided, masked, asked, .. } = *self;
        [
            ("points", points),
            ("outliers", outliers),
            ("faces", faces),
            ("cells", cells),
            ("pairs", pairs),
            ("large_triangles", large_triangles),
            ("blocks", blocks),
            ("tests", tests),
            ("undecided", undecided),
            ("masked", masked),
            ("asked", asked),
        ]
    }
}

/// Seconds that each stage of the last [`ListedLightGrid::survey`] and [`ListedLightGrid::shadow`] took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ListedLightSeconds {
    /// How far away the image's tiles are; once for all lights.
    pub survey: f64,
    /// The points to the light's faces.
    pub map: f64,
    /// Points sorted by cell, and gathered there.
    pub points: f64,
    /// The vertices to the light's faces.
    pub project: f64,
    /// Triangles listed.
    pub list: f64,
    /// Pairs sorted by cell, and split into blocks.
    pub sort: f64,
    /// Points against triangles.
    pub trace: f64,
    /// What the fast test left open, and the bits of all threads.
    pub decide: f64,
}

impl ListedLightSeconds {
    /// Each stage with its name.
    #[must_use]
    pub fn named(&self) -> [(&'static str, f64); 8] {
        let Self { survey, map, points, project, list, sort, trace, decide } = *self;
        [
            ("survey", survey),
            ("map", map),
            ("points", points),
            ("project", project),
            ("list", list),
            ("sort", sort),
            ("trace", trace),
            ("decide", decide),
        ]
    }
}

impl ListedLightGrid {
    /// An empty grid that uses the instructions of `level`.
    #[must_use]
    pub fn with_level(level: SimdLevel) -> Self {
        Self { grid: LightGrid::with_level(level), ..Self::default() }
    }

    /// How the light's faces are cut into cells, and cells into blocks, from now on.
    pub fn set_options(&mut self, options: ListedLightOptions) {
        self.options = options;
    }

    /// Finds out how far away each tile's points are; call it before [`shadow`](Self::shadow), once for all lights.
    ///
    /// # Panics
    /// If `image.seen` isn't of the size of `image.view`.
    pub fn survey(&mut self, image: &SeenImage<'_>) {
        self.grid.survey(image);
        self.seconds.survey = self.grid.seconds.survey;
    }

    /// What the last [`shadow`](Self::shadow) did.
    #[must_use]
    pub fn counts(&self) -> ListedLightCounts {
        self.counts
    }

    /// How long the stages of the last [`survey`](Self::survey) and [`shadow`](Self::shadow) took.
    #[must_use]
    pub fn seconds(&self) -> ListedLightSeconds {
        self.seconds
    }

    /// Bytes held.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.grid.bytes()
            + self.cells.bytes()
            + self.point_bins.iter().map(Bins::bytes).sum::<usize>()
            + self.point_rows.iter().map(PointRow::bytes).sum::<usize>()
            + self.ranges.iter().map(Range::bytes).sum::<usize>()
            + self.triangle_rows.iter().map(SortedRow::bytes).sum::<usize>()
            + self.large.capacity() * size_of::<(u32, Plane)>()
            + self.blocks.capacity() * size_of::<Block>()
    }

    /// Divides a face on which points are wrong by at most `error` evenly into cells.
    fn choose_cells(&mut self, error: f32) {
        const EVENLY: &[u32] = &[1; Axis::STRIPS];
        let side = self.options.side as usize;
        // With the rounding of sums with it.
        self.margin = error * 1.001 + 2.0 * f32::EPSILON;
        self.cells.across.choose(side, EVENLY);
        self.cells.down.choose(side, EVENLY);
        self.cells.all_rows.resize_with(side, Row::default);
        for row in 0..side {
            let [low, high] = self.cells.down.range(row);
            self.cells.all_rows[row].range = [low - self.margin, high + self.margin];
        }
    }
}
