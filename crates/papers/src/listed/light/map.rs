use std::fmt::Debug;
use std::ops::Range as Ids;

use fearless_simd::{Simd, mask32x16};
use glam::Vec3;
use umbrage_rays::light_grid::survey::Survey;
use umbrage_rays::shot::SeenImage;
use umbrage_rays::simd::SimdLevel;
use umbrage_rays::{LightFace, LightSource, Triangles};

use super::ListedLightOptions;
use super::cells::Axis;
use super::list::{ListedRange, Listing};
use super::pass::LightPass;

/// The position of a point in a map.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// The coordinates of its column, and of its row.
    pub(super) at: [f32; 2],
    /// Distance from the light, in the map's own unit.
    pub(super) distance: f32,
    /// The distance plus its error bound.
    pub(super) farthest: f32,
}

/// A light's map of points and triangles: it assigns them to cells, and tests them against each other.
pub(super) trait LightMap: Default + Send + Sync {
    /// Up to 16 points in the form of a test.
    type Points: Copy + Debug + Send + Sync;
    /// 16 triangles after setup.
    type Batch: Default + Send + Sync;
    /// A triangle that is set up when it is listed instead of when it is tested.
    type Large: Copy + Send + Sync;

    /// Chooses the number of faces through which the light sees all points of the survey; `None` for a degenerate light.
    fn choose(&mut self, light: &LightSource, survey: &Survey, options: &ListedLightOptions) -> Option<usize>;

    /// Maps the points of one of its faces, and marks the lanes of each block that are on it. Points of the face that can't
    /// be mapped are outliers.
    fn map(&mut self, face: usize, image: &SeenImage<'_>, pass: &mut LightPass);

    /// Divides the face into columns and rows.
    fn divide(&mut self, pass: &LightPass, options: &ListedLightOptions) -> [Axis; 2];

    /// Projects all vertices to the face, each once.
    fn project(&mut self, positions: &[Vec3], level: SimdLevel);

    /// The position of the point at an index.
    fn place(&self, index: u32) -> Place;

    /// The points at up to 16 indices.
    fn gather(&self, indices: &[u32]) -> Self::Points;

    /// Lists triangles in the cells with points that they may shadow.
    fn list<S: Simd>(simd: S, listing: &Listing<'_, Self>, range: &mut ListedRange<Self>, ids: Ids<usize>);

    /// Sets up at most 16 triangles; returns the mask of those to test.
    fn set_up<S: Simd>(&self, simd: S, triangles: Triangles<'_>, ids: &[u32], batch: &mut Self::Batch) -> u64;

    /// The points that a triangle of a batch certainly shadows, and those that it possibly shadows, which include the
    /// former. Points on the triangle itself may be among the latter.
    fn test<S: Simd>(simd: S, batch: &Self::Batch, lane: usize, points: &Self::Points) -> (mask32x16<S>, mask32x16<S>);

    /// As [`test`](Self::test).
    fn test_large<S: Simd>(simd: S, large: &Self::Large, points: &Self::Points) -> (mask32x16<S>, mask32x16<S>);

    /// The face with this number of columns and rows, for pictures; its points are between these distances.
    fn light_face(&self, cells: [usize; 2], distances: [f32; 2]) -> LightFace;

    /// Bytes held.
    fn bytes(&self) -> usize;
}
