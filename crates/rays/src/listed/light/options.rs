use std::fmt;
use std::str::FromStr;

use crate::choices;

/// The options of a [`ListedLightGrid`](super::ListedLightGrid). They change its speed only, not its answers.
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

/// A rectangle of angles α and β around a light, in degrees from −180 to 180.
///
/// Both are measured from the light's forward direction: a spot's own, or towards the middle of the camera's points. α is to
/// the right, along the image's rows, and β to the third side. The rectangle's border cells also hold everything outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightClamp {
    /// Lowest and highest α, lowest and highest β.
    degrees: [f32; 4],
}

impl LightClamp {
    /// A rectangle from the lowest and highest α, and the lowest and highest β; `None` for an empty range or angles beyond
    /// ±180.
    #[must_use]
    pub fn new(degrees: [f32; 4]) -> Option<Self> {
        let [left, right, low, high] = degrees;
        let is_range = |low: f32, high: f32| -180.0 <= low && low < high && high <= 180.0;
        (is_range(left, right) && is_range(low, high)).then_some(Self { degrees })
    }

    /// The angles, as for [`new`](Self::new).
    #[must_use]
    pub fn degrees(self) -> [f32; 4] {
        self.degrees
    }

    /// Lowest and highest α, and β, in radians.
    pub(super) fn radians(self) -> [[f32; 2]; 2] {
        let [left, right, low, high] = self.degrees.map(f32::to_radians);
        [[left, right], [low, high]]
    }
}

/// As `-30:30:-20:20`.
impl fmt::Display for LightClamp {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [left, right, low, high] = self.degrees;
        write!(f, "{left}:{right}:{low}:{high}")
    }
}

impl FromStr for LightClamp {
    type Err = NoLightClamp;

    fn from_str(text: &str) -> Result<Self, NoLightClamp> {
        let mut numbers = text.split(':').map(|number| number.parse().ok());
        let degrees = std::array::from_fn(|_| numbers.next().flatten().unwrap_or(f32::NAN));
        Self::new(degrees).filter(|_| numbers.next().is_none()).ok_or(NoLightClamp)
    }
}

/// The error for a text that is no [`LightClamp`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("give the lowest and highest α and β in degrees from -180 to 180, as -30:30:-20:20")]
pub struct NoLightClamp;

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
            let points = points.next_multiple_of(crate::simd::lanes::LANES as u32);
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
