use crate::parallel::both;
use std::sync::Mutex;

use crate::dispatch;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x8};
use glam::DVec3;

use super::boxes::{FaceBox, SixteenBoxes};
use super::face::{FACE_LIMIT, Face, HALF_ULP, ROUNDING, VERTEX_MARGIN};
use super::large_triangles::LargeTriangles;
use super::settle::Settler;
use crate::patches::{Patches, SixteenBoxes as WorldBoxes};
use crate::simd::SimdLevel;
use crate::simd::lanes::{load_positions, quads};
use crate::simd::vectors::{LANES, Vectors, dot, largest, minus, narrow, splat, splat_vector, widen};

/// Sixteens of patches that one thread takes at once.
const CHUNK_SIXTEENS: usize = 4;

/// The patches of a frame as a face sees them.
#[derive(Debug, Default)]
pub(crate) struct FacePatches {
    /// X, Y and W of the patches' vertices, in the patches' order; those of patches that the face doesn't see are stale.
    pub(crate) vertices: Vec<[f32; 4]>,
    /// The boxes of patches; those that can't shadow a point of the face overlap nothing.
    pub(crate) sixteens: Vec<SixteenBoxes>,
    /// The boxes of sixteens.
    pub(crate) upper: Vec<SixteenBoxes>,
    /// Triangles of patches with a vertex that f32 can't hold.
    pub(crate) large: LargeTriangles,
    /// The patches of these triangles.
    of_large: Vec<u32>,
}

impl FacePatches {
    /// Projects all patches that may shadow a point of the face. No point is farther from the light than `farthest`, a depth
    /// in perspective, else minus W.
    pub(crate) fn project(&mut self, face: &Face, farthest: f64, patches: &Patches, settler: &Settler<'_>) {
        let Settler { opacity, level, .. } = settler;
        let Self { vertices, sixteens, upper, large, of_large } = self;
        vertices.resize(patches.vertex_count(), [0.0; 4]);
        sixteens.resize(patches.len().div_ceil(LANES), SixteenBoxes::NOTHING);
        of_large.clear();
        let projector = Projector {
            face,
            sides: Sides::new(face, farthest),
            patches,
            of_large: Mutex::new(of_large),
            level: *level,
        };
        projector.project(0, vertices, sixteens);
        upper.clear();
        upper.extend(sixteens.chunks(LANES).map(|sixteens| {
            let mut all = SixteenBoxes::NOTHING;
            for (lane, boxes) in sixteens.iter().enumerate() {
                all.set(lane, dispatch!(*level, simd => boxes.around_patches(simd)));
            }
            all
        }));
        of_large.sort_unstable();
        let ids = of_large.iter().flat_map(|&number| {
            let patch = patches.get(number as usize);
            patch.ids[..patch.count].iter().copied()
        });
        large.find(face, ids, opacity);
    }

    pub(crate) fn bytes(&self) -> usize {
        self.vertices.capacity() * size_of::<[f32; 4]>()
            + (self.sixteens.capacity() + self.upper.capacity()) * size_of::<SixteenBoxes>()
            + self.large.bytes()
            + self.of_large.capacity() * size_of::<u32>()
    }
}

/// The sides of the region in which triangles may shadow points of a face. Each has a normal n and a distance c; n · v + c
/// is at least zero inside, with v from the face's origin.
struct Sides {
    count: usize,
    normals: [DVec3; 6],
    distances: [f64; 6],
}

impl Sides {
    fn new(face: &Face, farthest: f64) -> Self {
        let Face { x, y, z, .. } = *face;
        if face.is_parallel {
            let normals = [x, -x, y, -y, z, DVec3::ZERO];
            Self { count: 5, normals, distances: [FACE_LIMIT, FACE_LIMIT, FACE_LIMIT, FACE_LIMIT, farthest, 0.0] }
        } else {
            let wide = z * FACE_LIMIT;
            let normals = [wide - x, wide + x, wide - y, wide + y, z, -z];
            Self { count: 6, normals, distances: [0.0, 0.0, 0.0, 0.0, 0.0, farthest] }
        }
    }

    /// Mask of the boxes, among sixteen, that are certainly outside; a box with NaN isn't.
    #[inline(always)]
    fn outside<S: Simd>(&self, simd: S, boxes: &WorldBoxes, origin: DVec3) -> u16 {
        // In relation to size · |n|₁ + |c|, the sum is wrong by 2 ε for the origin and the difference from it, 2 ε for
        // the normal and the products, and 5 ε for c and four sums. In parallel light over nearly all that f32 can
        // hold, it has few bits of the normal, so that each component of a vertex adds 2⁻¹⁵⁰ · 2¹²⁸: 12 ε, where |c| is
        // about one.
        const ROUNDED: f64 = 24.0 * HALF_ULP;
        let origin32 = origin.as_vec3().to_array();
        let largest_origin = origin.abs().max_element() as f32;
        let mut outside = 0;
        let mut size = splat(simd, largest_origin);
        let zero = splat(simd, 0.0);
        let (mut low, mut high) = ([zero; 3], [zero; 3]);
        for axis in 0..3 {
            let origin = splat(simd, origin32[axis]);
            low[axis] = fearless_simd::f32x16::simd_from(simd, boxes.low[axis]) - origin;
            high[axis] = fearless_simd::f32x16::simd_from(simd, boxes.high[axis]) - origin;
            size = size.max(low[axis].abs()).max(high[axis].abs());
        }
        for (normal, distance) in self.normals.iter().zip(self.distances).take(self.count) {
            let sum = normal.abs().element_sum();
            // Infinite where a product or their sum may overflow, so that nothing is outside.
            let largest = (size * splat(simd, sum as f32) + splat(simd, distance.abs() as f32)) * 4.0;
            let error = largest * (ROUNDED / 4.0) as f32;
            // Products that underflow lose their bound.
            let mut most = error + splat(simd, distance as f32 + f32::MIN_POSITIVE);
            for (axis, &factor) in normal.as_vec3().to_array().iter().enumerate() {
                let end = if factor > 0.0 { high[axis] } else { low[axis] };
                most = end.mul_add(splat(simd, factor), most);
            }
            outside |= most.simd_lt(zero).to_bitmask() as u16;
        }
        outside
    }
}

struct Projector<'a> {
    face: &'a Face,
    sides: Sides,
    patches: &'a Patches,
    of_large: Mutex<&'a mut Vec<u32>>,
    level: SimdLevel,
}

/// The result for a patch.
enum Projected {
    /// It is in this box.
    Inside(FaceBox),
    /// It can't shadow a point of the face.
    Outside,
    /// It has a vertex that f32 can't hold.
    Large,
}

impl Projector<'_> {
    /// Projects the sixteens from `first` on with their vertices, divided in halves for threads.
    fn project(&self, first: usize, vertices: &mut [[f32; 4]], sixteens: &mut [SixteenBoxes]) {
        if sixteens.len() <= CHUNK_SIXTEENS {
            dispatch!(self.level, simd => self.project_chunk(simd, first, vertices, sixteens));
            return;
        }
        let middle = sixteens.len() / 2;
        let start = |sixteen: usize| self.patches.vertex_range(sixteen * LANES).start;
        let (low, high) = vertices.split_at_mut(start(first + middle) - start(first));
        let (low_boxes, high_boxes) = sixteens.split_at_mut(middle);
        both(|| self.project(first, low, low_boxes), || self.project(first + middle, high, high_boxes));
    }

    #[inline(always)]
    fn project_chunk<S: Simd>(
        &self,
        simd: S,
        first: usize,
        mut vertices: &mut [[f32; 4]],
        sixteens: &mut [SixteenBoxes],
    ) {
        for (sixteen, boxes) in sixteens.iter_mut().enumerate() {
            let sixteen = first + sixteen;
            *boxes = SixteenBoxes::NOTHING;
            let outside = self.sides.outside(simd, &self.patches.bounds.sixteens[sixteen], self.face.origin);
            for lane in 0..LANES.min(self.patches.len() - sixteen * LANES) {
                let number = sixteen * LANES + lane;
                let (of_patch, rest) = vertices.split_at_mut(self.patches.vertex_range(number).len());
                vertices = rest;
                if outside >> lane & 1 == 1 {
                    continue;
                }
                match self.project_patch(simd, number, of_patch) {
                    Projected::Inside(one) => boxes.set(lane, one),
                    Projected::Outside => {}
                    Projected::Large => {
                        if let Ok(mut large) = self.of_large.lock() {
                            large.push(number as u32);
                        }
                    }
                }
            }
        }
    }

    #[inline(always)]
    fn project_patch<S: Simd>(&self, simd: S, number: usize, vertices: &mut [[f32; 4]]) -> Projected {
        let face = self.face;
        let infinity = splat(simd, f32::INFINITY);
        let (mut low_x, mut high_x, mut low_y, mut high_y) = (infinity, -infinity, infinity, -infinity);
        let (mut farthest, mut nearest) = (infinity, -infinity);
        let mut outside = [u64::MAX; 5];
        let mut sum = splat(simd, 0.0);
        for (positions, vertices) in self.patches.positions(number).iter().zip(vertices.chunks_exact_mut(LANES)) {
            let [low, high] = widen(load_positions(simd, positions));
            let (low, low_codes) = project_eight(simd, face, low);
            let (high, high_codes) = project_eight(simd, face, high);
            let [x, y, nearness] = narrow(low, high);
            for side in 0..5 {
                outside[side] &= low_codes[side] & high_codes[side];
            }
            let interleaved = quads([x, y, nearness, splat(simd, 0.0)]);
            for (quad, to) in interleaved.into_iter().zip(vertices.as_flattened_mut().chunks_exact_mut(LANES)) {
                quad.store_slice(to);
            }
            sum += x;
            low_x = low_x.min(x);
            high_x = high_x.max(x);
            low_y = low_y.min(y);
            high_y = high_y.max(y);
            farthest = farthest.min(nearness);
            nearest = nearest.max(nearness);
        }
        if outside.iter().any(|lanes| lanes & 0xff == 0xff) {
            return Projected::Outside;
        }
        let x = [low_x.reduce_min(), high_x.reduce_max()];
        let y = [low_y.reduce_min(), high_y.reduce_max()];
        let (farthest, nearest) = (farthest.reduce_min(), nearest.reduce_max());
        // The sum is NaN where one is, even if a minimum drops it.
        let is_usable = sum.simd_eq(sum).all_true();
        // A coordinate found to be at 2 may be rounded to that by 2 ε.
        let is_near_the_face = x[0] > -2.0 && x[1] < 2.0 && y[0] > -2.0 && y[1] < 2.0;
        // The predicate's error bound relies on it.
        let is_even = face.is_parallel || nearest <= farthest * 1.99;
        if !(is_usable && is_near_the_face && is_even) {
            return Projected::Large;
        }
        // Wrong by two roundings; in parallel light of one.
        let error = nearest.abs().max(if face.is_parallel { 1.0 } else { 0.0 }) * (4.0 * HALF_ULP) as f32;
        Projected::Inside(FaceBox {
            x: [x[0] - VERTEX_MARGIN, x[1] + VERTEX_MARGIN],
            y: [y[0] - VERTEX_MARGIN, y[1] + VERTEX_MARGIN],
            nearness: nearest + error,
        })
    }
}

/// X, Y and W of eight vertices, NaN where the filter can't use them, and the lanes of each outcode.
///
/// There is an outcode for each side of the face's frustum, grown to [`FACE_LIMIT`], that a vertex is certainly outside of:
/// high X, low X, high Y, low Y, behind the light.
///
/// The filter relies on coordinates with errors of at most ε / 8 of their size or of one in f64, ε = 2⁻²⁴. The homogeneous
/// ones are wrong by 4 u · |x|₁ |v|, u = 2⁻⁵³. No face reaches farther aside than 1.6 p.z, so where |X| and |Y| are at most
/// M ≥ 1, |v| is at most 2.5 M p.z; and with |x|₁ below 2²⁰, X is wrong by less than 2⁻²⁹ M. W is wrong by 2⁻⁴⁸ M of itself.
/// In parallel light X and W are wrong by 4 u |x|₁ |v| ≤ ε / 8 where |v| |x|₁ is at most 2²⁴.
///
/// The difference between X p.z and its limit is wrong by 4 u |x|₁ |v|, and by 7 u |z|₁ |v| for the other side and the sums.
#[inline(always)]
pub fn project_eight<S: Simd>(simd: S, face: &Face, position: Vectors<S>) -> (Vectors<S>, [u64; 5]) {
    const ROUNDINGS: f64 = 8.0 * ROUNDING;
    let constant = |value: f64| f64x8::splat(simd, value);
    let v = minus(position, splat_vector(simd, face.origin));
    let (at, _) = face.project(simd, v);
    let reach = largest(v);
    let one = constant(1.0);
    let usable = if face.is_parallel {
        (reach * face.norms().max_element()).simd_le(constant(f64::from(1 << 24)))
    } else {
        at[2].simd_lt(constant((1_u64 << 40) as f64)) & at[2].simd_gt(constant(1.0 / (1_u64 << 60) as f64))
    };
    let usable = usable & at[0].abs().max(at[1].abs()).simd_le(constant(4096.0));
    let nan = constant(f64::NAN);

    // p.x > p.z and so on, by more than rounding; written so that NaN is outside of nothing.
    let (x, y) = (dot(v, splat_vector(simd, face.x)), dot(v, splat_vector(simd, face.y)));
    let z = if face.is_parallel { one } else { dot(v, splat_vector(simd, face.z)) };
    let norms = face.norms();
    let error = reach * ((norms.x + norms.y + norms.z) * ROUNDINGS);
    let limit = z * FACE_LIMIT + error;
    let behind = if face.is_parallel { 0 } else { (z + error).simd_lt(constant(0.0)).to_bitmask() };
    let outside = [
        x.simd_gt(limit).to_bitmask(),
        (-x).simd_gt(limit).to_bitmask(),
        y.simd_gt(limit).to_bitmask(),
        (-y).simd_gt(limit).to_bitmask(),
        behind,
    ];
    ([usable.select(at[0], nan), usable.select(at[1], nan), usable.select(at[2], nan)], outside)
}

#[cfg(test)]
mod tests;
