//! Lights that see all around them by two angles (Guntury and Narayanan 2010, §4.1): one grid for a light anywhere.
//!
//! With v an offset from the light, and x, y and z its components along the light's axes right, up and forward, the angles
//! are α = atan2(x, z) and β = atan2(y, z). The points of one such angle are half a plane through the light, which ends at
//! the line along up or right, so cells are four-sided frusta. z is positive if both angles are less than a right angle, and
//! negative if both are more. All directions in the plane z = 0 are in the four corners where both are right angles: cells
//! there are long.

mod angles;
mod batch;
mod points;
mod vertices;

use std::ops::{Range as Ids, RangeInclusive};

use fearless_simd::prelude::*;
use fearless_simd::{Simd, mask32x16};
use glam::{DVec3, Vec3};
use umbrage::LightClamp;
use umbrage_rays::light_grid::choose::across;
use umbrage_rays::light_grid::survey::Survey;
use umbrage_rays::shot::{Cone, SeenImage};
use umbrage_rays::simd::SimdLevel;
use umbrage_rays::simd::lanes::{bits_of, max3, min3};
use umbrage_rays::simd::vectors::{LANES, splat};
use umbrage_rays::{LightFace, LightSource, Triangles};

use super::ListedLightOptions;
use super::cells::Axis;
use super::list::{ListedRange, Listing};
use super::map::{LightMap, Place};
use super::pass::LightPass;
use angles::Arc;
use batch::{Batch, Corners};
use points::{Offsets, Seen, SpherePoints};

/// The map of a light that sees all around it.
///
/// Positions are offsets from the light, times a power of two that scales the farthest point's to about one.
#[derive(Debug, Default)]
pub(super) struct Sphere {
    frame: Frame,
    cone: Option<Cone>,
    blocks: Vec<Offsets>,
    seen: Seen,
    vertices: vertices::Vertices,
}

/// The light's axes.
#[derive(Clone, Copy, Debug, Default)]
struct Frame {
    light: Vec3,
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    /// A power of two.
    scale: f64,
}

impl Frame {
    /// The frame of a light at `light` with the given `forward`, or else towards the middle of the seen points.
    fn new(light: Vec3, forward: Option<DVec3>, survey: &Survey) -> Self {
        let origin = light.as_dvec3();
        let filled = || survey.tiles.iter().filter(|tile| tile.points > 0);
        let towards = filled().map(|tile| (tile.corners.iter().sum::<DVec3>() * 0.125 - origin).normalize_or_zero());
        let forward = forward.or_else(|| towards.sum::<DVec3>().try_normalize()).unwrap_or(DVec3::Z);
        let (right, _) = across(forward, survey.rays.step_x);
        let corners = filled().flat_map(|tile| tile.corners);
        let farthest = corners.map(|corner| (corner - origin).abs().max_element()).fold(1e-30, f64::max);
        let exponent = farthest.log2().ceil().clamp(-126.0, 126.0);
        Self { light, right, up: right.cross(forward), forward, scale: (-exponent).exp2() }
    }
}

impl LightMap for Sphere {
    type Points = SpherePoints;
    type Batch = Batch;
    /// All triangles are set up when they are tested.
    type Large = ();

    fn choose(&mut self, light: &LightSource, survey: &Survey, _: &ListedLightOptions) -> Option<usize> {
        let (position, forward) = match *light {
            LightSource::Point { position } => (position, None),
            LightSource::Spot { position, direction, .. } => (position, direction.as_dvec3().try_normalize()),
            LightSource::Directional { .. } => return None,
        };
        self.cone = Cone::of(light);
        self.frame = Frame::new(position, forward.filter(|forward| forward.is_finite()), survey);
        position.is_finite().then_some(1)
    }

    fn map(&mut self, _: usize, image: &SeenImage<'_>, pass: &mut LightPass) {
        let Self { frame, cone, blocks, seen, .. } = self;
        *seen = points::map(frame, cone.as_ref(), image, blocks, pass);
    }

    fn divide(&mut self, _: &LightPass, options: &ListedLightOptions) -> [Axis; 2] {
        let ranges = options.clamp.map_or(self.seen.angles, LightClamp::radians);
        ranges.map(|range| Axis::new(range, options.cells() as usize))
    }

    fn project(&mut self, positions: &[Vec3], level: SimdLevel) {
        self.vertices.project(&self.frame, positions, level);
    }

    #[inline(always)]
    fn place(&self, index: u32) -> Place {
        self.blocks[index as usize / LANES].place(index as usize % LANES)
    }

    #[inline(always)]
    fn gather(&self, indices: &[u32]) -> SpherePoints {
        SpherePoints::gather(&self.blocks, indices)
    }

    #[inline(always)]
    fn list<S: Simd>(simd: S, listing: &Listing<'_, Self>, range: &mut ListedRange<Self>, ids: Ids<usize>) {
        let Self { frame, vertices, seen, .. } = listing.map;
        let margins = seen.margins();
        let farthest = splat(simd, seen.farthest);
        let end = ids.end;
        for first in ids.step_by(LANES) {
            let triangles = &listing.triangles.indices[first..end.min(first + LANES)];
            let mut padded = [[u32::MAX; 3]; LANES];
            padded[..triangles.len()].copy_from_slice(triangles);
            let nearest = Corners::load(simd, frame, vertices, &padded).nearest(simd);
            // Written so that NaN is near enough.
            let mut left = !nearest.simd_gt(farthest).to_bitmask() & ((1 << triangles.len()) - 1);
            let angles = vertices.angles(simd, &padded);
            for (of_corners, range) in angles.iter().zip(seen.angles) {
                left &= !outside(simd, of_corners, range).to_bitmask();
            }
            if left == 0 {
                continue;
            }
            let nearest: [f32; LANES] = nearest.into();
            let angles: [[[f32; LANES]; 3]; 2] = angles.map(|corners| corners.map(Into::into));
            for lane in bits_of(left) {
                let id = (first + lane) as u32;
                if listing.triangles.usable_corners(id).is_ok() && listing.opacity.is_there(id) {
                    let arcs = [0, 1].map(|plane| {
                        let of_corners = angles[plane].map(|lanes| lanes[lane]);
                        Arc::of(of_corners, margins[plane]).parts()
                    });
                    let columns = cells_of(arcs[0], seen.angles[0], listing.across);
                    let rows = cells_of(arcs[1], seen.angles[1], listing.down);
                    for columns in columns.into_iter().flatten() {
                        for rows in rows.iter().flatten() {
                            listing.list(&mut range.bins, &columns, rows.clone(), nearest[lane], id);
                        }
                    }
                }
            }
        }
    }

    #[inline(always)]
    fn set_up<S: Simd>(&self, simd: S, triangles: Triangles<'_>, ids: &[u32], batch: &mut Batch) -> u64 {
        let mut corners = [[u32::MAX; 3]; LANES];
        for (corners, &id) in corners.iter_mut().zip(ids) {
            if let Some(&of_triangle) = triangles.indices.get(id as usize) {
                *corners = of_triangle;
            }
        }
        batch.set_up(simd, &Corners::load(simd, &self.frame, &self.vertices, &corners));
        (1 << ids.len()) - 1
    }

    #[inline(always)]
    fn test<S: Simd>(simd: S, batch: &Batch, lane: usize, points: &SpherePoints) -> (mask32x16<S>, mask32x16<S>) {
        batch.test(simd, lane, points)
    }

    #[inline(always)]
    fn test_large<S: Simd>(simd: S, (): &(), _: &SpherePoints) -> (mask32x16<S>, mask32x16<S>) {
        let none = mask32x16::splat(simd, false);
        (none, none)
    }

    /// There is no rectangle: all corners are at the light.
    fn light_face(&self, [columns, rows]: [usize; 2], _: [f32; 2]) -> LightFace {
        let corners = [self.frame.light; 4];
        LightFace { columns: columns as u32, rows: rows as u32, near: corners, far: corners }
    }

    fn bytes(&self) -> usize {
        self.blocks.capacity() * size_of::<Offsets>() + self.vertices.bytes()
    }
}

/// The mask of triangles certainly outside of a range of angles, by their corners' angles: those that don't reach around the
/// light.
#[inline(always)]
fn outside<S: Simd>(simd: S, corners: &[fearless_simd::f32x16<S>; 3], [low, high]: [f32; 2]) -> mask32x16<S> {
    let least = min3(*corners);
    let most = max3(*corners);
    // Narrower than half a turn, and beyond the range, both by far more than any error. The rest is decided one by one.
    let margin = 1e-3 + 1e-3 * low.abs().max(high.abs());
    let sum = corners[0] + corners[1] + corners[2];
    let is_narrow = (most - least).simd_lt(splat(simd, 3.0)) & sum.simd_eq(sum);
    is_narrow & (least.simd_gt(splat(simd, high + margin)) | most.simd_lt(splat(simd, low - margin)))
}

/// The cells of an axis that the parts of an arc overlap, within the range of the points' angles.
fn cells_of(parts: [[f32; 2]; 2], [low, high]: [f32; 2], axis: Axis) -> [Option<RangeInclusive<usize>>; 2] {
    let of_part = |[start, end]: [f32; 2]| {
        let is_seen = start <= end && start <= high && end >= low;
        is_seen.then(|| axis.cell(start)..=axis.cell(end))
    };
    match parts.map(of_part) {
        // Joins overlapping ranges.
        [Some(a), Some(b)] if a.start() <= b.end() && b.start() <= a.end() => {
            [Some(*a.start().min(b.start())..=*a.end().max(b.end())), None]
        }
        apart => apart,
    }
}
