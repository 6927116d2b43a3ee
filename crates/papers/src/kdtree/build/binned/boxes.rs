use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8};

use glam::Vec3;
use rayon::prelude::*;
use umbrage_rays::parallel::Parallel;

use super::Arena;
use super::clip::clip;
use crate::kdtree::build::sah::SplitCandidate;
use crate::kdtree::extent::{Extent, Plane, Reference};
use umbrage_rays::Triangles;
use umbrage_rays::vectorized;

/// A triangle's box in a cell, and its id. 32 bytes: the lower faces, the id's bits, the negated upper faces, and 4 unused
/// bytes.
///
/// All six numbers grow as the box shrinks, so the box around two boxes is the minimum of each number.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(32))]
pub(super) struct Boxed(pub(super) [f32; 8]);

impl Boxed {
    pub(super) fn around(corners: [Vec3; 3], id: u32) -> Self {
        let [a, b, c] = corners;
        let (low, high) = (a.min(b).min(c) + 0.0, a.max(b).max(c) + 0.0);
        Self([low.x, low.y, low.z, f32::from_bits(id), -high.x, -high.y, -high.z, 0.0])
    }

    pub(super) fn reference(&self) -> Reference {
        let (min, max) = ([0, 1, 2].map(|axis| self.low(axis) + 0.0), [0, 1, 2].map(|axis| self.high(axis) + 0.0));
        Reference { extent: Extent { min, max }, id: self.id() }
    }

    pub(super) fn id(&self) -> u32 {
        self.0[3].to_bits()
    }

    /// Intersects the box with the box of these faces. Infinite faces leave it empty.
    #[inline(always)]
    pub(super) fn shrink<S: Simd>(&mut self, simd: S, faces: f32x8<S>) {
        let id = self.0[3];
        let both = f32x8::from_slice(simd, &self.0).max(faces);
        both.store_slice(&mut self.0);
        self.0[3] = id;
    }

    /// Whether a lower face is above its upper face.
    #[inline(always)]
    pub(super) fn is_empty(&self) -> bool {
        (self.low(0) > self.high(0)) | (self.low(1) > self.high(1)) | (self.low(2) > self.high(2))
    }

    #[inline(always)]
    pub(super) fn low(&self, axis: usize) -> f32 {
        self.0[axis]
    }

    #[inline(always)]
    pub(super) fn high(&self, axis: usize) -> f32 {
        -self.0[4 + axis]
    }
}

impl From<&Reference> for Boxed {
    fn from(Reference { extent: Extent { min, max }, id }: &Reference) -> Self {
        Self([min[0], min[1], min[2], f32::from_bits(*id), -max[0], -max[1], -max[2], 0.0])
    }
}

/// The bounds of boxes, in the numbers of a [`Boxed`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Around([f32; 8]);

impl Around {
    const NOTHING: Self = Self([f32::INFINITY; 8]);

    /// Returns the bounds of the boxes of all chunks.
    pub(super) fn chunks<S: Simd>(simd: S, chunks: &[Arena]) -> Self {
        let around = chunks.par_iter().map(|chunk| vectorized!(simd => Self::all(simd, &chunk.boxes)));
        around.merge(Self::both).unwrap_or(Self::NOTHING)
    }

    #[inline(always)]
    pub(super) fn all<S: Simd>(simd: S, boxes: &[Boxed]) -> Self {
        let start = f32x8::splat(simd, f32::INFINITY);
        let mut least = start;
        for boxed in boxes {
            least = least.min(f32x8::from_slice(simd, &boxed.0));
        }
        let mut around = Self::NOTHING;
        least.store_slice(&mut around.0);
        around
    }

    /// Sets the lower and the upper face along an axis.
    pub(super) fn set(&mut self, axis: usize, [low, high]: [f32; 2]) {
        (self.0[axis], self.0[4 + axis]) = (low, -high);
    }

    fn both(self, other: Self) -> Self {
        Self(std::array::from_fn(|index| self.0[index].min(other.0[index])))
    }

    pub(super) fn corners(&self) -> [[f32; 3]; 2] {
        let Self(faces) = self;
        [[faces[0], faces[1], faces[2]], [-faces[4], -faces[5], -faces[6]]]
    }

    pub(super) fn extent(&self) -> Extent {
        let [min, max] = self.corners().map(|corner| corner.map(|coordinate| coordinate + 0.0));
        Extent { min, max }
    }
}

/// Parts boxes: those of the left child go to `left`, which has room for all; those of the right child stay, in front.
/// Returns the number of each, and the number of boxes that the plane cuts, whose indices in both lists go to `cut`.
///
/// Each box is written to both lists, and counted where it belongs: a branch would be mispredicted half of the time.
#[inline(always)]
pub(super) fn part<S: Simd>(
    simd: S,
    boxes: &mut [Boxed],
    best: &SplitCandidate,
    left: &mut [Boxed],
    cut: &mut [[u32; 2]],
) -> ([usize; 2], usize) {
    let (axis, at, planar_left) = (best.plane.axis & 3, best.plane.at, best.planar_left);
    let left = &mut left[..boxes.len()];
    // The plane as a face of the boxes on either side. −∞ keeps the other faces, and the id.
    let mut faces = [[f32::NEG_INFINITY; 8]; 2];
    faces[0][4 + axis] = -at;
    faces[1][axis] = at;
    let faces = faces.map(|faces| f32x8::from_slice(simd, &faces));
    let (mut left_count, mut right_count, mut cut_count) = (0, 0, 0);
    for index in 0..boxes.len() {
        let boxed = &boxes[index];
        let (low, high) = (boxed.low(axis), boxed.high(axis));
        let is_left = (low < at) | (planar_left & (high <= at));
        let is_right = (high > at) | (!planar_left & (low >= at));
        let both = f32x8::from_slice(simd, &boxed.0);
        cut[cut_count] = [left_count as u32, right_count as u32];
        cut_count += usize::from(is_left & is_right);
        both.max(faces[0]).store_slice(&mut left[left_count].0);
        left_count += usize::from(is_left);
        both.max(faces[1]).store_slice(&mut boxes[right_count].0);
        right_count += usize::from(is_right);
    }
    ([left_count, right_count], cut_count)
}

/// Shrinks the boxes that a plane cut, removes empty ones, and returns the numbers of boxes that are left.
#[inline(always)]
pub(super) fn clip_cut<S: Simd>(
    simd: S,
    triangles: Triangles<'_>,
    plane: Plane,
    [left, right]: [&mut [Boxed]; 2],
    cut: &[[u32; 2]],
) -> [usize; 2] {
    let mut is_any_empty = [false; 2];
    for &[below, above] in cut {
        let (below, above) = (&mut left[below as usize], &mut right[above as usize]);
        let [a, b, c] = triangles.indices[below.id() as usize];
        let corners =
            [triangles.positions[a as usize], triangles.positions[b as usize], triangles.positions[c as usize]];
        clip(simd, corners, plane, below, above);
        is_any_empty[0] |= below.is_empty();
        is_any_empty[1] |= above.is_empty();
    }
    let left_count = if is_any_empty[0] { remove_empty(left) } else { left.len() };
    let right_count = if is_any_empty[1] { remove_empty(right) } else { right.len() };
    [left_count, right_count]
}

fn remove_empty(boxes: &mut [Boxed]) -> usize {
    let mut kept = 0;
    for index in 0..boxes.len() {
        boxes[kept] = boxes[index];
        kept += usize::from(!boxes[kept].is_empty());
    }
    kept
}

#[cfg(test)]
mod tests {
    use umbrage_rays::dispatch;

    use super::*;
    use umbrage_rays::SimdLevel;

    #[test]
    fn boxes_are_parted_in_order_and_lose_what_is_empty() {
        let corner = |x: f32, y: f32| Vec3::new(x, y, 0.0);
        let positions = [
            [corner(0.0, 0.0), corner(4.0, 4.0), corner(4.0, 5.0)],
            [corner(3.0, 0.0), corner(4.0, 0.0), corner(4.0, 1.0)],
            [corner(2.0, 0.0), corner(2.0, 1.0), corner(2.0, 2.0)],
            [corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0)],
        ];
        let triangles =
            Triangles { positions: &positions.concat(), indices: &[[0, 1, 2], [3, 4, 5], [6, 7, 8], [9, 10, 11]] };
        let mut boxes: Vec<_> = (0..4).map(|id| Boxed::around(triangles.corners(id), id)).collect();
        // An earlier plane has cut the first: its part is above y = 3, and so right of x = 2.
        boxes[0].0[1] = 3.0;
        for planar_left in [true, false] {
            let best = SplitCandidate { cost: 0.0, plane: Plane { axis: 0, at: 2.0 }, planar_left };
            for level in SimdLevel::available() {
                let mut right = boxes.clone();
                let (mut left, mut cut) = (vec![Boxed::default(); 4], [[0; 2]; 4]);
                let (counts, cut_count) = dispatch!(level, simd => part(simd, &mut right, &best, &mut left, &mut cut));
                let children = [&mut left[..counts[0]], &mut right[..counts[1]]];
                let cut = &cut[..cut_count];
                let counts = dispatch!(level, simd => clip_cut(simd, triangles, best.plane, children, cut));
                let ids = |boxes: &[Boxed]| boxes.iter().map(Boxed::id).collect::<Vec<_>>();
                let expected = if planar_left { [vec![2, 3], vec![0, 1]] } else { [vec![3], vec![0, 1, 2]] };
                assert_eq!([ids(&left[..counts[0]]), ids(&right[..counts[1]])], expected);
                assert_eq!((right[0].low(0), right[0].low(1), right[0].high(1)), (2.0, 3.0, 5.0));
            }
        }
    }
}
