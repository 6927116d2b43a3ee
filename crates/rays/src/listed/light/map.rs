use std::fmt::Debug;
use std::ops::Range as Ids;

use fearless_simd::{Simd, mask32x16};
use glam::Vec3;

use super::ListedLightOptions;
use super::cells::Axis;
use super::list::{Listing, Range};
use super::pass::LightPass;
use crate::light_grid::survey::Survey;
use crate::shot::SeenImage;
use crate::simd::SimdLevel;
use crate::{LightFace, LightSource, Triangles};

/// Where a point is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// What gives it its column, and its row.
    pub(super) at: [f32; 2],
    /// From the light, in a measure of the map's own.
    pub(super) distance: f32,
    /// The same with what it may be wrong by.
    pub(super) farthest: f32,
}

/// How a light sees points and triangles: in which cells they are, and how the ones are tested against the others.
pub(super) trait LightMap: Default + Send + Sync {
    /// Up to 16 points as a test takes them.
    type Points: Copy + Debug + Send + Sync;
    /// 16 triangles that are set up.
    type Batch: Default + Send + Sync;
    /// A triangle that is set up when it is listed rather than when it is tested.
    type Large: Copy + Send + Sync;

    /// Chooses through how many faces the light sees all points of the survey; `None` where it is no light at all.
    fn choose(&mut self, light: &LightSource, survey: &Survey, options: &ListedLightOptions) -> Option<usize>;

    /// Maps the points of one of its faces, and says which lanes of each block they are in; points of the face that it
    /// can't map are outliers.
    fn map(&mut self, face: usize, image: &SeenImage<'_>, pass: &mut LightPass);

    /// Divides the face into columns and rows.
    fn divide(&mut self, pass: &LightPass, options: &ListedLightOptions) -> [Axis; 2];

    /// Brings all vertices to the face, each once.
    fn project(&mut self, positions: &[Vec3], level: SimdLevel);

    /// Where the point at an index is.
    fn place(&self, index: u32) -> Place;

    /// The points at up to 16 indices.
    fn gather(&self, indices: &[u32]) -> Self::Points;

    /// Lists triangles in the cells that hold points which they may shadow.
    fn list<S: Simd>(simd: S, listing: &Listing<'_, Self>, range: &mut Range<Self>, ids: Ids<usize>);

    /// Sets up at most 16 triangles; which of them to test.
    fn set_up<S: Simd>(&self, simd: S, triangles: Triangles<'_>, ids: &[u32], batch: &mut Self::Batch) -> u64;

    /// Which points a triangle of a batch shadows for certain, and which possibly, among them all of the former. Points on
    /// the triangle itself may be among the latter.
    fn test<S: Simd>(simd: S, batch: &Self::Batch, lane: usize, points: &Self::Points) -> (mask32x16<S>, mask32x16<S>);

    /// As [`test`](Self::test).
    fn test_large<S: Simd>(simd: S, large: &Self::Large, points: &Self::Points) -> (mask32x16<S>, mask32x16<S>);

    /// The face with so many columns and rows, for pictures; its points are at these distances at least and at most.
    fn light_face(&self, cells: [usize; 2], distances: [f32; 2]) -> LightFace;

    /// Bytes held.
    fn bytes(&self) -> usize;
}
