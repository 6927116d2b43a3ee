use crate::parallel::Parallel;
use glam::Vec3;
use rayon::prelude::*;

use super::{Scanned, Scanner};
use crate::light_grid::{LightGrid, PointList};
use crate::patches::Patches;
use crate::predicate::{HitPoint, ROUNDING, ShadowRay};
use crate::shot::{Cone, OpacityOfSides};
use crate::triangles::Unusable;
use crate::{LightSource, Masks, Opacity, Opaque, RayMasks, Sides, SimdLevel, Triangles};

/// Points, and the triangles that may shadow them.
#[derive(Clone, Copy)]
pub struct Lit<'a> {
    /// World-space triangles.
    pub triangles: Triangles<'a>,
    /// The points.
    pub receivers: Receivers<'a>,
    /// Opacity of the triangles for light.
    pub opacity: &'a dyn Opacity,
    /// Sides of triangles that stop light.
    pub sides: Sides<'a>,
    /// Masks of triangles and lights.
    pub masks: Masks<'a>,
}

impl<'a> Lit<'a> {
    /// Points among triangles opaque on both sides.
    #[must_use]
    pub fn new(triangles: Triangles<'a>, receivers: Receivers<'a>) -> Self {
        Self { triangles, receivers, opacity: &Opaque, sides: Sides::Both, masks: Masks::default() }
    }
}

/// Points that light may reach.
///
/// A point isn't shadowed by its own triangle, nor by triangles whose planes its rounded position may be in.
#[derive(Clone, Copy, Debug)]
pub enum Receivers<'a> {
    /// World positions, each with the id of its own triangle or [`Scanned::NONE`]. `own` may be empty if no point is on a
    /// triangle.
    ///
    /// A point on a triangle counts as rounded to f32, any other as exact.
    Points {
        /// World positions. Those that aren't finite are dark.
        positions: &'a [Vec3],
        /// Own triangles: an id for each point, or none.
        own: &'a [u32],
    },
    /// As `Points`, with one point for each slot of an image in [`TileOrder`](crate::TileOrder): they stay in that order.
    Pixels {
        /// World positions. Those that aren't finite are dark, and cost little.
        positions: &'a [Vec3],
        /// The triangle of each point.
        own: &'a [u32],
    },
    /// The centroid of each triangle. Centroids of triangles that no ray can hit are dark.
    Faces,
    /// This number of points on each triangle, evenly spread: those of triangle i begin at index i times the number.
    Samples(u32),
}

impl Receivers<'_> {
    /// The number of points.
    ///
    /// # Panics
    /// If `own` is neither empty nor as long as the points.
    #[must_use]
    pub fn count(&self, triangles: Triangles<'_>) -> usize {
        self.count_among(triangles.len())
    }

    /// The number of points, with this number of triangles.
    pub(crate) fn count_among(&self, triangles: usize) -> usize {
        match self {
            Self::Points { positions, own } | Self::Pixels { positions, own } => {
                let count = positions.len();
                assert!(own.is_empty() || own.len() == count, "{} own, {count} points", own.len());
                count
            }
            Self::Faces => triangles,
            Self::Samples(each) => triangles * *each as usize,
        }
    }

    /// A point and the triangle that it is on, or [`Scanned::NONE`]; `None` for a point that isn't finite or whose triangle
    /// can't be hit.
    ///
    /// # Panics
    /// If `index` is out of range.
    #[must_use]
    pub fn point(&self, triangles: Triangles<'_>, index: usize) -> Option<(HitPoint, u32)> {
        self.point_among(|id| triangles.usable_corners(id), index)
    }

    /// As [`point`](Self::point), with the corners of triangles that a ray can hit.
    pub(crate) fn point_among(
        &self,
        corners: impl Fn(u32) -> Result<[Vec3; 3], Unusable>,
        index: usize,
    ) -> Option<(HitPoint, u32)> {
        /// Half the distance from one to the next f32.
        const HALF_ULP: f64 = 1.0 / (1 << 24) as f64;
        let weighted = |id: u32, [u, v]: [f64; 2]| {
            let [a, b, c] = corners(id).ok()?.map(Vec3::as_dvec3);
            let largest = a.abs().max(b.abs()).max(c.abs()).max_element();
            // Fewer than 15 roundings of numbers at most twice as large.
            Some((HitPoint { position: a + (b - a) * u + (c - a) * v, error: largest * (30.0 * ROUNDING) }, id))
        };
        match self {
            Self::Points { positions, own } | Self::Pixels { positions, own } => {
                let position = positions[index].as_dvec3();
                let own = if own.is_empty() { Scanned::NONE } else { own[index] };
                let error = if own == Scanned::NONE { 0.0 } else { position.abs().max_element() * HALF_ULP };
                position.is_finite().then_some((HitPoint { position, error }, own))
            }
            Self::Faces => weighted(index as u32, [1.0 / 3.0; 2]),
            Self::Samples(each) => {
                let (id, number) = (index as u32 / each, index as u32 % each);
                weighted(id, sample(id, number))
            }
        }
    }
}

/// Weights of the second and third corner at a triangle's sample: a point of the R₂ sequence (Roberts, *The unreasonable
/// effectiveness of quasirandom sequences*, 2018), shifted by a hash of the triangle's id. The half of the square beyond the
/// diagonal is folded onto the other half.
fn sample(id: u32, number: u32) -> [f64; 2] {
    let mixed = u64::from(id).wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let mixed = (mixed ^ mixed >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let mixed = mixed ^ mixed >> 27;
    let start = [mixed >> 32, mixed & 0xffff_ffff].map(|bits| bits as f64 / (1_u64 << 32) as f64);
    let steps = [0.754_877_666_246_692_7, 0.569_840_290_998_053_3];
    let [u, v] = [0, 1].map(|axis| (start[axis] + f64::from(number) * steps[axis]).fract());
    if u + v > 1.0 { [1.0 - u, 1.0 - v] } else { [u, v] }
}

/// The points that each of some lights reaches: a bit each.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LitBits {
    words: Vec<u64>,
    points: usize,
    lights: usize,
    /// The number of points that aren't finite or whose triangle can't be hit: they are dark.
    pub nowhere: usize,
}

impl LitBits {
    /// The number of points.
    #[must_use]
    pub fn points(&self) -> usize {
        self.points
    }

    /// The number of lights.
    #[must_use]
    pub fn lights(&self) -> usize {
        self.lights
    }

    /// Whether a light reaches a point.
    ///
    /// # Panics
    /// If `light` or `point` is out of range.
    #[must_use]
    pub fn is_lit(&self, light: usize, point: usize) -> bool {
        assert!(point < self.points, "point {point} of {}", self.points);
        self.of_light(light)[point / 64] >> (point % 64) & 1 == 1
    }

    /// The bits of a light: point i is bit i % 64 of word i / 64; the rest of the last word is zero.
    ///
    /// # Panics
    /// If `light` is out of range.
    #[must_use]
    pub fn of_light(&self, light: usize) -> &[u64] {
        let words = self.points.div_ceil(64);
        &self.words[light * words..(light + 1) * words]
    }

    /// Answers each point alone: `point` gives it and its own triangle, unless it is nowhere, and `is_blocked`, given a light's
    /// index, tells whether any other triangle shadows it.
    pub(crate) fn fill(
        &mut self,
        points: usize,
        lights: &[LightSource],
        point: impl Fn(usize) -> Option<(HitPoint, u32)> + Sync,
        is_blocked: impl Fn(usize, &ShadowRay, u32) -> bool + Sync,
    ) {
        let words = points.div_ceil(64);
        self.words.clear();
        self.words.resize(words * lights.len(), 0);
        (self.points, self.lights) = (points, lights.len());
        self.nowhere = (0..points).into_par_iter().filter(|&index| point(index).is_none()).count();
        for (number, (light, words)) in lights.iter().zip(self.words.chunks_mut(words.max(1))).enumerate() {
            let cone = Cone::of(light);
            let is_lit = |(point, own): (HitPoint, u32)| {
                cone.is_none_or(|cone| cone.contains(point.position))
                    && !is_blocked(number, &ShadowRay::new(light, point), own)
            };
            words.par_iter_mut().enumerate().each(|(word, bits)| {
                for bit in 0..64.min(points - 64 * word) {
                    *bits |= u64::from(point(64 * word + bit).is_some_and(is_lit)) << bit;
                }
            });
        }
    }

    /// The lit share of each triangle's area for a light, if the points are [`Receivers::Samples`] with `each` samples a
    /// triangle.
    ///
    /// # Panics
    /// If `light` is out of range, or `each` is zero.
    pub fn shares(&self, light: usize, each: u32) -> impl Iterator<Item = LitShare> {
        let triangles = self.points / each as usize;
        (0..triangles).map(move |id| {
            let points = id * each as usize..(id + 1) * each as usize;
            let lit = points.filter(|&point| self.is_lit(light, point)).count();
            LitShare::new(lit as f64, f64::from(each))
        })
    }
}

/// The share of a triangle's area that a light reaches, estimated by samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LitShare {
    /// Share, from zero to one.
    pub share: f64,
    /// The standard error of the share for independent samples, with one lit and one dark sample added (so that it isn't
    /// zero where all agree); the samples are spread more evenly than independent ones.
    pub standard_error: f64,
}

impl LitShare {
    fn new(lit: f64, samples: f64) -> Self {
        let guess = (lit + 1.0) / (samples + 2.0);
        Self { share: lit / samples, standard_error: (guess * (1.0 - guess) / samples).sqrt() }
    }
}

/// The shadowed points for one light after the other.
struct Shadows {
    grid: LightGrid,
    /// A word for each block of points.
    blocks: Vec<u16>,
}

impl Shadows {
    fn with_level(level: SimdLevel) -> Self {
        Self { grid: LightGrid::with_level(level), blocks: Vec::new() }
    }

    fn bytes(&self) -> usize {
        let grid = self.grid.bytes();
        grid.triangles + grid.points + self.blocks.capacity() * size_of::<u16>()
    }

    /// Finds the points that a light reaches, on this number of threads.
    fn light(
        &mut self,
        lit: &Lit<'_>,
        (patches, list): (&Patches, &PointList),
        (light, mask): (&LightSource, u32),
        threads: usize,
        bits: &mut [u64],
    ) {
        let masked = lit.masks.opacity(mask, lit.opacity);
        let opacity: &dyn Opacity = if lit.masks.hide_nothing() { lit.opacity } else { &masked };
        let opacity = OpacityOfSides::between(lit.triangles, (opacity, lit.sides), light);
        self.grid.shadow_list(opacity, patches, list, (light, threads), &mut self.blocks);
        let cone = Cone::of(light);
        list.visit_lit(&self.blocks, |number, position| {
            let is_lit = cone.is_none_or(|cone| cone.contains(position));
            bits[number / 64] |= u64::from(is_lit) << (number % 64);
        });
    }
}

/// Sorted points and the memory for testing them against lights.
#[derive(Default)]
pub(super) struct LitPoints {
    level: SimdLevel,
    list: PointList,
    shadows: Vec<Shadows>,
}

impl LitPoints {
    pub(super) fn with_level(level: SimdLevel) -> Self {
        Self { level, ..Self::default() }
    }

    pub(super) fn bytes(&self) -> usize {
        self.list.bytes() + self.shadows.iter().map(Shadows::bytes).sum::<usize>()
    }

    fn lit(&mut self, patches: &Patches, lit: &Lit<'_>, lights: &[LightSource], bits: &mut LitBits) {
        self.list(patches, lit);
        self.lit_listed(patches, lit, lights, bits);
    }

    /// Sorts the points.
    fn list(&mut self, patches: &Patches, Lit { triangles, receivers, .. }: &Lit<'_>) {
        let count = receivers.count(*triangles);
        patches.expect(*triangles);
        let point = |number: usize| receivers.point(*triangles, number);
        if matches!(receivers, Receivers::Pixels { .. }) {
            self.list.fill_in_order(count, point);
        } else {
            self.list.fill(count, point);
        }
    }

    /// Finds the sorted points that each light reaches.
    fn lit_listed(&mut self, patches: &Patches, lit: &Lit<'_>, lights: &[LightSource], bits: &mut LitBits) {
        let Lit { triangles, receivers, .. } = *lit;
        let Self { list, shadows, level } = self;
        let count = receivers.count(triangles);
        let words = count.div_ceil(64);
        bits.words.clear();
        bits.words.resize(words * lights.len(), 0);
        (bits.points, bits.lights, bits.nowhere) = (count, lights.len(), count - list.len());
        if list.len() == 0 || lights.is_empty() {
            return;
        }
        // Each thread takes some lights; if there are few lights, all threads share each light's tiles.
        let threads = rayon::current_num_threads();
        let (takers, of_each) = if lights.len() >= 2 * threads { (threads, 1) } else { (1, threads) };
        shadows.resize_with(takers.max(shadows.len()), || Shadows::with_level(*level));
        let lights_of_each = lights.len().div_ceil(takers);
        let questions = lights.par_chunks(lights_of_each).zip(bits.words.par_chunks_mut(words * lights_of_each));
        let questions = questions.enumerate();
        shadows.par_iter_mut().with_max_len(1).zip(questions).each(|(shadows, (chunk, (lights, bits)))| {
            let numbers = chunk * lights_of_each..;
            for ((number, light), bits) in numbers.zip(lights).zip(bits.chunks_mut(words)) {
                shadows.light(lit, (patches, list), (light, lit.masks.of_ray(number)), of_each, bits);
            }
        });
    }
}

impl Scanner {
    /// Finds the points that each light reaches. Cones of spots count, ranges and strengths don't; nor does the side of its
    /// own triangle that a point is on.
    ///
    /// Points are sorted once for all lights, so that neighbours follow each other; the light grid then takes
    /// tiles of them in place of an image's.
    ///
    /// # Panics
    /// If it was built for another number of triangles, if `own` is neither empty nor as long as the points, if a light has no
    /// mask, or if pixels aren't full tiles.
    pub fn lit(&mut self, lit: &Lit<'_>, lights: &[LightSource], bits: &mut LitBits) {
        self.points.lit(&self.patches, lit, lights, bits);
    }

    /// As [`lit`](Self::lit), with a structure's [patches](crate::Structure::patches) of the triangles; without patches, the
    /// scanner is built first.
    ///
    /// # Panics
    /// As `lit`, or if the patches are of another number of triangles.
    pub fn lit_with(&mut self, patches: Option<&Patches>, lit: &Lit<'_>, lights: &[LightSource], bits: &mut LitBits) {
        if let Some(patches) = patches {
            self.points.lit(patches, lit, lights, bits);
        } else {
            self.build(lit.triangles);
            self.lit(lit, lights, bits);
        }
    }

    /// Estimates the share of each triangle's area that each light reaches, by `samples` evenly spread points on each: all
    /// triangles for the first light, then for the next one. Triangles that no ray can hit are dark.
    ///
    /// # Panics
    /// If it was built for another number of triangles, there are no samples, or a light has no mask.
    pub fn lit_areas(
        &mut self,
        triangles: Triangles<'_>,
        masks: Masks<'_>,
        lights: &[LightSource],
        samples: u32,
        shares: &mut Vec<LitShare>,
    ) {
        let Self { patches, points, .. } = self;
        let lit = Lit::new(triangles, Receivers::Samples(samples));
        let mut bits = LitBits::default();
        shares.clear();
        points.list(patches, &lit);
        for (number, light) in lights.iter().enumerate() {
            let masks = Masks { rays: RayMasks::All(masks.of_ray(number)), ..masks };
            points.lit_listed(patches, &Lit { masks, ..lit }, std::slice::from_ref(light), &mut bits);
            shares.extend(bits.shares(0, samples));
        }
    }
}
