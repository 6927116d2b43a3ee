use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, f64x8, u32x16};
use glam::Vec3;
use umbrage_rays::{Hit, SeenPixels, predicate};
use umbrage_scene::Frame;

use super::lanes::{Each, LANES, Vectors, Wide, lanes_of};
use super::rays::{Block, BlockRays};
use super::triangles::BlockTriangles;

/// The hits of a block's rays.
#[derive(Clone, Copy)]
pub(crate) struct BlockHits<'a, S: Simd> {
    /// The lanes with a hit, the first in the lowest bit. Other lanes hold numbers without a meaning, and ids that exist.
    pub(crate) shown: u16,
    pub(crate) triangles: &'a BlockTriangles,
    /// Depth along the camera's forward axis, or along rays from mirrors.
    pub(crate) depth: f32x16<S>,
    /// World positions.
    pub(super) position: [Wide<S>; 2],
    /// Weights of the second and the third vertex.
    pub(super) barycentric: [f32x16<S>; 2],
    pub(super) corners: [Vectors<S>; 3],
}

/// The triangles that a block's rays are known to meet.
pub(crate) struct SeenTriangles {
    shown: u16,
    triangles: BlockTriangles,
}

impl SeenTriangles {
    /// Those of the pixels' ids; `None` where no pixel shows any.
    #[inline(always)]
    pub(crate) fn new<S: Simd>(simd: S, frame: &Frame, block: &Block<'_>, seen: &Each<u32>) -> Option<Self> {
        let shown = !u32x16::simd_from(simd, *seen).simd_eq(SeenPixels::NONE).to_bitmask() as u16 & block.pixels();
        let of_lanes = existing(shown, |lane| seen[lane])?;
        Some(Self { shown, triangles: BlockTriangles::new(simd, frame, of_lanes) })
    }

    /// Those of hits; `None` where there is none.
    #[inline(always)]
    pub(crate) fn of_found<S: Simd>(simd: S, frame: &Frame, found: &Each<Option<Hit>>) -> Option<Self> {
        let shown = found.iter().rev().fold(0, |bits, hit| bits << 1 | u16::from(hit.is_some()));
        let of_lanes = existing(shown, |lane| found[lane].map_or(SeenPixels::NONE, |hit| hit.triangle))?;
        Some(Self { shown, triangles: BlockTriangles::new(simd, frame, of_lanes) })
    }

    /// The different ones.
    pub(crate) fn ids(&self) -> impl Iterator<Item = u32> {
        self.triangles.with_lanes().map(|(id, _)| id)
    }
}

impl<'a, S: Simd> BlockHits<'a, S> {
    /// The hits of the rays with the triangles that their pixels are known to show.
    ///
    /// Errors of depths are far below f32's precision.
    #[inline(always)]
    pub(crate) fn of_seen(
        simd: S,
        frame: &Frame,
        block: &Block<'_>,
        rays: &BlockRays<S>,
        seen: &'a SeenTriangles,
    ) -> Self {
        let SeenTriangles { shown, ref triangles } = *seen;
        let corners = corner_vectors(simd, &frame.positions, triangles);
        let ([a0, a1], [b0, b1], [c0, c1]) = (corners[0].widen(), corners[1].widen(), corners[2].widen());
        let low = Meeting::new(rays.origin[0], rays.direction[0], [a0, b0, c0]);
        let high = Meeting::new(rays.origin[1], rays.direction[1], [a1, b1, c1]);
        let barycentric =
            [low.barycentric[0].narrow(high.barycentric[0]), low.barycentric[1].narrow(high.barycentric[1])];
        let known = Self::new(rays, shown, triangles, corners, [low.t, high.t], barycentric);
        let doubtful = shown & (low.doubtful | high.doubtful << (LANES / 2));
        if doubtful == 0 {
            return known;
        }
        let mut met = Met::of(&known, [low.t, high.t]);
        for lane in lanes_of(doubtful) {
            met.set(lane, predicate::hit(&block.ray(lane), frame.triangles(), triangles.of_lanes[lane]));
        }
        met.into_hits(simd, rays, triangles, corners)
    }

    /// Hits that were found by other queries, with their triangles.
    #[inline(always)]
    pub(crate) fn of_found(
        simd: S,
        frame: &Frame,
        rays: &BlockRays<S>,
        found: &Each<Option<Hit>>,
        SeenTriangles { triangles, .. }: &'a SeenTriangles,
    ) -> Self {
        let mut met = Met::default();
        for (lane, hit) in found.iter().enumerate() {
            met.set(lane, *hit);
        }
        met.into_hits(simd, rays, triangles, corner_vectors(simd, &frame.positions, triangles))
    }

    /// The corners' values, mixed by their weights.
    #[inline(always)]
    pub(super) fn interpolated(&self, [a, b, c]: [Vectors<S>; 3]) -> Vectors<S> {
        let [second, third] = self.barycentric;
        a.scaled(1.0 - second - third) + b.scaled(second) + c.scaled(third)
    }

    #[inline(always)]
    fn new(
        rays: &BlockRays<S>,
        shown: u16,
        triangles: &'a BlockTriangles,
        corners: [Vectors<S>; 3],
        [low, high]: [f64x8<S>; 2],
        barycentric: [f32x16<S>; 2],
    ) -> Self {
        let position =
            [rays.origin[0] + rays.direction[0].scaled(low), rays.origin[1] + rays.direction[1].scaled(high)];
        Self { shown, triangles, depth: low.narrow(high), position, barycentric, corners }
    }
}

/// Intersections of lines with triangles that they are known to meet: Möller and Trumbore, *Fast, Minimum Storage
/// Ray/Triangle Intersection*, 1997.
struct Meeting<S: Simd> {
    t: f64x8<S>,
    barycentric: [f64x8<S>; 2],
    /// The lanes in which cancellation leaves t too uncertain.
    doubtful: u16,
}

impl<S: Simd> Meeting<S> {
    /// The smallest share of the largest product that a determinant may have: its error is then at most 2⁻³¹, since six
    /// products lose up to eight roundings of 2⁻⁵³ each.
    const CANCELLATION: f64 = 1.0 / (1 << 16) as f64;

    #[inline(always)]
    fn new(origin: Wide<S>, direction: Wide<S>, [a, b, c]: [Wide<S>; 3]) -> Self {
        let (offset, to_second, to_third) = (origin - a, b - a, c - a);
        let across = direction.cross(to_third);
        let around = offset.cross(to_second);
        let determinant = to_second.dot(across);
        let height = to_third.dot(around);
        let area = to_second.reach() * to_third.reach() * Self::CANCELLATION;
        let known = determinant.abs().simd_gt(area * direction.reach()) & height.abs().simd_gt(area * offset.reach());
        let inverse = 1.0 / determinant;
        // The point is in the triangle, except for rounding.
        let second = (offset.dot(across) * inverse).max(0.0).min(1.0);
        let third = (direction.dot(around) * inverse).max(0.0).min(1.0);
        Self { t: height * inverse, barycentric: [second, third], doubtful: !(known.to_bitmask() as u16) & 0xff }
    }
}

/// Hits lane by lane.
#[derive(Default)]
struct Met {
    shown: u16,
    t: Each<f64>,
    barycentric: [Each<f32>; 2],
}

impl Met {
    #[inline(always)]
    fn of<S: Simd>(hits: &BlockHits<'_, S>, t: [f64x8<S>; 2]) -> Self {
        let [low, high]: [[f64; LANES / 2]; 2] = [t[0].into(), t[1].into()];
        let mut both = [0.0; LANES];
        both[..LANES / 2].copy_from_slice(&low);
        both[LANES / 2..].copy_from_slice(&high);
        let barycentric = [hits.barycentric[0].into(), hits.barycentric[1].into()];
        Self { shown: hits.shown, t: both, barycentric }
    }

    fn set(&mut self, lane: usize, hit: Option<Hit>) {
        self.shown &= !(1 << lane);
        if let Some(Hit { t, barycentric: [second, third], .. }) = hit {
            self.shown |= 1 << lane;
            (self.t[lane], self.barycentric[0][lane], self.barycentric[1][lane]) = (t, second, third);
        }
    }

    #[inline(always)]
    fn into_hits<'a, S: Simd>(
        self,
        simd: S,
        rays: &BlockRays<S>,
        triangles: &'a BlockTriangles,
        corners: [Vectors<S>; 3],
    ) -> BlockHits<'a, S> {
        let (low, high) = self.t.split_at(LANES / 2);
        let t = [f64x8::from_slice(simd, low), f64x8::from_slice(simd, high)];
        let [second, third] = &self.barycentric;
        let barycentric = [f32x16::from_slice(simd, second), f32x16::from_slice(simd, third)];
        BlockHits::new(rays, self.shown, triangles, corners, t, barycentric)
    }
}

/// The triangles of some lanes, with the first of them in the other lanes; `None` without a lane.
#[inline(always)]
fn existing(lanes: u16, triangle: impl Fn(usize) -> u32) -> Option<Each<u32>> {
    if lanes == 0 {
        return None;
    }
    let mut triangles = [triangle(lanes.trailing_zeros() as usize); LANES];
    for (lane, id) in triangles.iter_mut().enumerate() {
        if lanes >> lane & 1 == 1 {
            *id = triangle(lane);
        }
    }
    Some(triangles)
}

/// The values `of_vertices` of each lane's triangle, corner by corner.
#[inline(always)]
pub(super) fn corner_vectors<S: Simd>(simd: S, of_vertices: &[Vec3], triangles: &BlockTriangles) -> [Vectors<S>; 3] {
    let [a, b, c] = triangles.corners(
        simd,
        #[inline(always)]
        |vertex| of_vertices[vertex as usize].to_array(),
    );
    [Vectors::of_axes(a), Vectors::of_axes(b), Vectors::of_axes(c)]
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{UVec2, Vec3};
    use umbrage_rays::{Camera, View};
    use umbrage_rays::{SimdLevel, dispatch};
    use umbrage_scene::Mesh;

    use super::*;
    use crate::sampling::Sample;

    /// Depth and weights, for each lane of the block at (0, 0) that shows a triangle.
    fn shown(corners: [Vec3; 3], view: &View) -> Vec<(Option<Hit>, [f32; 3])> {
        let mesh = Mesh { triangles: vec![[0, 1, 2]], ..Mesh::default() };
        let frame = Frame { positions: corners.to_vec(), mesh: Arc::new(mesh), ..Frame::default() };
        let sample = Sample::all(1).next().unwrap();
        let block = Block { view, sample: &sample, corner: UVec2::ZERO };
        let truth: [Option<Hit>; LANES] =
            std::array::from_fn(|lane| predicate::hit(&block.ray(lane), frame.triangles(), 0));
        let seen = truth.map(|hit| hit.map_or(SeenPixels::NONE, |hit| hit.triangle));
        let hits: Vec<[f32; 3]> = dispatch!(SimdLevel::default(), simd => {
            let rays = BlockRays::new(simd, &block);
            let seen = SeenTriangles::new(simd, &frame, &block, &seen).expect("some pixel shows it");
            let hits = BlockHits::of_seen(simd, &frame, &block, &rays, &seen);
            assert!((0..LANES).all(|lane| (hits.shown >> lane & 1 == 1) == truth[lane].is_some()));
            let [second, third] = hits.barycentric;
            (0..LANES).map(|lane| [hits.depth[lane], second[lane], third[lane]]).collect()
        });
        truth.into_iter().zip(hits).collect()
    }

    #[test]
    fn hits_are_those_of_the_predicate() {
        let camera = Camera::look_at(Vec3::new(0.3, 0.2, 5.0), Vec3::ZERO, Vec3::Y, 0.5);
        let view = View { camera, width: 4, height: 4 };
        let facing = [Vec3::new(-3.0, -2.0, 0.1), Vec3::new(2.5, -1.8, -0.4), Vec3::new(0.1, 2.9, 0.3)];
        let floor = [Vec3::new(-900.0, -0.02, 400.0), Vec3::new(900.0, -0.02, 400.0), Vec3::new(0.0, -0.03, -3000.0)];
        // Seen almost from its edge, so that nearly everything cancels.
        let camera_height = camera.position.y;
        let edge = [
            Vec3::new(-900.0, camera_height - 1e-6, 3.0),
            Vec3::new(900.0, camera_height - 1e-6, 3.0),
            Vec3::new(0.0, camera_height + 3e-5, -2000.0),
        ];
        // Of five rows, the middle one looks straight ahead.
        let ahead = Camera { forward: Vec3::NEG_Z, right: Vec3::X, up: Vec3::Y, ..camera };
        let level = View { camera: ahead, width: 5, height: 5 };
        for (corners, view) in [(facing, view), (floor, view), (edge, level)] {
            let lanes = shown(corners, &view);
            assert!(lanes.iter().any(|(truth, _)| truth.is_some()));
            for (hit, [depth, second, third]) in lanes {
                let Some(hit) = hit else { continue };
                assert_eq!(depth, hit.t as f32);
                assert!((second - hit.barycentric[0]).abs() < 1e-6, "{second} {:?}", hit.barycentric);
                assert!((third - hit.barycentric[1]).abs() < 1e-6, "{third} {:?}", hit.barycentric);
            }
        }
    }
}
