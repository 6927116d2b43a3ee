use umbrage::LightClamp;
use umbrage_rays::choices;
use umbrage_rays::simd::lanes::LANES;

/// The options of the lights' grid of [`ListedGrids`](crate::ListedGrids). They change its speed only, not its answers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ListedLightOptions {
    side: u32,
    points: u32,
    triangles: u32,
    slices: u32,
    /// The map of points and triangles, for lights with a position.
    pub map: LightMapping,
    /// The angles that a spherical map divides into cells; by default the range of the points' angles.
    pub clamp: Option<LightClamp>,
}

/// The map from a light's points and triangles to cells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LightMapping {
    /// One face if the light sees all points within a wide angle, else the sides of a cube, each with its own cells.
    #[default]
    Faces,
    /// One grid of two angles all around the light (§4.1). Suns have no angles, and use a face.
    Spherical,
}

choices! { LightMapping, "light map":
    "faces" => Faces, "a face of tangents, or the sides of a cube";
    "spherical" => Spherical, "the paper's: one grid of two angles around the light";
}

impl Default for ListedLightOptions {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl ListedLightOptions {
    /// 192 × 192 cells in one slice, 256 points and 512 triangles to a block of work, on faces.
    pub const DEFAULT: Self =
        Self { side: 192, points: 256, triangles: 512, slices: 1, map: LightMapping::Faces, clamp: None };
    /// The largest number of cells a side.
    pub const MOST_CELLS: u32 = 2048;
    /// The largest number of points, and of triangles, of a block of work.
    pub const LARGEST_BLOCK: u32 = 4096;
    /// The largest number of depth slices.
    pub const MOST_SLICES: u32 = 32;

    /// `cells` × `cells` cells (up to [`MOST_CELLS`](Self::MOST_CELLS)²) on each face of the light, and work in blocks
    /// of at most `points`, the paper's r, which is rounded up to a multiple of 16, times `triangles` (both up to
    /// [`LARGEST_BLOCK`](Self::LARGEST_BLOCK)).
    ///
    /// # Errors
    /// If a number is zero or too large.
    pub fn new(cells: u32, points: u32, triangles: u32) -> Result<Self, ImpossibleLightCells> {
        Self::DEFAULT.with_sizes(cells, points, triangles)
    }

    /// The same with other sizes, as [`new`](Self::new) takes them.
    ///
    /// # Errors
    /// If a number is zero or too large.
    pub fn with_sizes(self, cells: u32, points: u32, triangles: u32) -> Result<Self, ImpossibleLightCells> {
        let sizes = 1..=Self::LARGEST_BLOCK;
        if (1..=Self::MOST_CELLS).contains(&cells) && sizes.contains(&points) && sizes.contains(&triangles) {
            let points = points.next_multiple_of(LANES as u32);
            Ok(Self { side: cells, points, triangles, ..self })
        } else {
            Err(ImpossibleLightCells { cells, points, triangles })
        }
    }

    /// The same with another number of depth slices; `None` if it is zero or more than [`MOST_SLICES`](Self::MOST_SLICES).
    #[must_use]
    pub fn with_slices(self, slices: u32) -> Option<Self> {
        (1..=Self::MOST_SLICES).contains(&slices).then_some(Self { slices, ..self })
    }

    /// Cells a side of each face.
    #[must_use]
    pub fn cells(&self) -> u32 {
        self.side
    }

    /// The largest number of points of a block of work: the paper's r.
    #[must_use]
    pub fn points(&self) -> u32 {
        self.points
    }

    /// The largest number of triangles of a block of work.
    #[must_use]
    pub fn triangles(&self) -> u32 {
        self.triangles
    }

    /// Depth slices of a cell.
    #[must_use]
    pub fn slices(&self) -> u32 {
        self.slices
    }
}

/// Numbers that no [`ListedLightOptions`] can have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{cells} light cells a side, blocks of {points} points and {triangles} triangles: there are 1 to {} cells, and 1 to \
     {} points and triangles",
    ListedLightOptions::MOST_CELLS,
    ListedLightOptions::LARGEST_BLOCK
)]
pub struct ImpossibleLightCells {
    /// Cells a side.
    pub cells: u32,
    /// Points of a block of work.
    pub points: u32,
    /// Triangles of a block of work.
    pub triangles: u32,
}
