//! Runs tests in turn over the same pairs.

use std::fmt;
use std::hint::black_box;
use std::time::Instant;

use fearless_simd::{Simd, f32x16, prelude::*};
use glam::Vec3;
use umbrage::rays::dispatch;
use umbrage::rays::predicate;
use umbrage::rays::{Ray, SimdLevel, Triangles};
use umbrage_papers::triangle::{self, Bundle, BundleTest, Fans, Hits, TriangleTest};

use super::pairs::{Lists, Pair, Pairs, SINGLE};
use crate::measure::median;

/// Which rays are tested at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rays {
    One,
    Sixteen,
    /// Sixteen with an origin that the triangle is prepared for.
    SixteenBundled,
}

impl fmt::Display for Rays {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::One => "1",
            Self::Sixteen => "16",
            Self::SixteenBundled => "16 bundle",
        })
    }
}

/// Costs of a test: medians.
#[derive(Debug)]
pub(super) struct Costs {
    pub(super) name: &'static str,
    pub(super) rays: Rays,
    /// For each triangle.
    pub(super) bytes: f64,
    pub(super) prepare_ns: f64,
    /// Million tests of one ray and one triangle a second: all pairs, and those that hit and miss apart.
    pub(super) rate: f64,
    pub(super) hit_rate: f64,
    pub(super) miss_rate: f64,
    /// Number of tests relative to other tests, which need one only for each pair's triangle.
    pub(super) more_tests: f64,
    /// Rate relative to that of the first test for as many rays from anywhere, in the same round.
    pub(super) speedup: f64,
}

/// A test and its measurements.
struct Contestant<'a> {
    name: &'static str,
    rays: Rays,
    bytes: f64,
    /// Seconds to prepare all triangles, then to test each list, for each round.
    seconds: Vec<[f64; 4]>,
    /// Tests of one ray and one triangle in each list.
    tests: [f64; 3],
    run: Box<dyn Fn() -> [f64; 4] + 'a>,
}

/// Tests that run in turn.
pub(super) struct Contest<'a> {
    triangles: Triangles<'a>,
    pairs: &'a Pairs,
    level: SimdLevel,
    contestants: Vec<Contestant<'a>>,
}

/// A number for each of sixteen rays.
type Wide<S> = f32x16<S>;

impl<'a> Contest<'a> {
    pub(super) fn new(triangles: Triangles<'a>, pairs: &'a Pairs, level: SimdLevel) -> Self {
        Self { triangles, pairs, level, contestants: Vec::new() }
    }

    /// Adds a test for one ray, and for sixteen.
    pub(super) fn add<T: TriangleTest + 'a>(&mut self) {
        let Self { triangles, pairs, level, .. } = *self;
        let prepare = move || -> Vec<T> { corners(triangles).map(T::new).collect() };
        let rays = single_rays(pairs);
        let one = move |tests: &Vec<T>| {
            one_by_one(&pairs.single, |pair, last| {
                if let Some(hits) = tests[pair.target as usize].hit(&rays[pair.block as usize]) {
                    *last = [hits.t, hits.barycentric[0], hits.barycentric[1]];
                }
            })
        };
        let sixteen = move |tests: &Vec<T>| dispatch!(level, simd => sixteen(simd, tests, pairs));
        let bytes = size_of::<T>() as f64;
        self.push(T::NAME, Rays::One, bytes, counts(&pairs.single, |_| 1), prepare, one);
        self.push(T::NAME, Rays::Sixteen, bytes, counts(&pairs.sixteen, |_| 16), prepare, sixteen);
    }

    /// Adds a test for sixteen rays with one origin, the camera's.
    pub(super) fn add_bundle<T: BundleTest + 'a>(&mut self) {
        let Self { triangles, pairs, level, .. } = *self;
        let origin = pairs.blocks[0][0].origin.as_vec3();
        let prepare = move || -> Vec<T> { corners(triangles).map(|corners| T::new(corners, origin)).collect() };
        let run = move |tests: &Vec<T>| dispatch!(level, simd => bundled(simd, tests, pairs));
        let (bytes, tests) = (size_of::<T>() as f64, counts(&pairs.sixteen, |_| 16));
        self.push(T::NAME, Rays::SixteenBundled, bytes, tests, prepare, run);
    }

    /// Adds fans for one ray, and for sixteen. Their pairs are the fans of all triangles of other tests' pairs.
    pub(super) fn add_fans(&mut self) {
        let Self { triangles, pairs, level, .. } = *self;
        let fans = Fans::new(triangles);
        let mut fan_of = vec![u32::MAX; triangles.len()];
        for index in 0..fans.len() {
            fans.fan(index).ids().iter().for_each(|&id| fan_of[id as usize] = index as u32);
        }
        // Triangles that can't be hit are in no fan.
        let mut fan_pairs: Vec<Pair> = Vec::new();
        let mut met = vec![u32::MAX; fans.len()];
        for &Pair { block, target } in &pairs.single.all {
            if let Some(met) = met.get_mut(fan_of[target as usize] as usize).filter(|met| **met != block) {
                *met = block;
                fan_pairs.push(Pair { block, target: fan_of[target as usize] });
            }
        }
        let is_hit = |ray: &Ray, pair: &Pair| {
            let ids = fans.fan(pair.target as usize);
            ids.ids().iter().any(|&id| predicate::hit(ray, triangles, id).is_some())
        };
        let block = |pair: &Pair| &pairs.blocks[pair.block as usize];
        let of_one = Lists::new(fan_pairs.iter().copied(), |pair| is_hit(&block(pair)[SINGLE], pair));
        let of_sixteen = Lists::new(fan_pairs.iter().copied(), |pair| block(pair).iter().any(|ray| is_hit(ray, pair)));
        let size = |pair: &Pair| fans.fan(pair.target as usize).ids().len();
        let tests = [counts(&of_one, size), counts(&of_sixteen, |pair| 16 * size(pair))];
        let bytes = fans.bytes() as f64 / triangles.len().max(1) as f64;

        let prepare = move || Fans::new(triangles);
        let rays = single_rays(pairs);
        let one = move |fans: &Fans| {
            one_by_one(&of_one, |pair, last| {
                fans.fan(pair.target as usize).hit(&rays[pair.block as usize], |_, hits| {
                    *last = [hits.t, hits.barycentric[0], hits.barycentric[1]];
                });
            })
        };
        let sixteen = move |fans: &Fans| dispatch!(level, simd => sixteen_fans(simd, fans, pairs, &of_sixteen));
        self.push("Galin–Akkouche", Rays::One, bytes, tests[0], prepare, one);
        self.push("Galin–Akkouche", Rays::Sixteen, bytes, tests[1], prepare, sixteen);
    }

    /// Adds a test: `prepare` makes its form of all triangles, and `test` returns the seconds for each list.
    fn push<T>(
        &mut self,
        name: &'static str,
        rays: Rays,
        bytes: f64,
        tests: [f64; 3],
        prepare: impl Fn() -> T + 'a,
        test: impl Fn(&T) -> [f64; 3] + 'a,
    ) {
        let run = Box::new(move || {
            let start = Instant::now();
            let prepared = prepare();
            let seconds = start.elapsed().as_secs_f64();
            let [all, hits, misses] = test(&prepared);
            [seconds, all, hits, misses]
        });
        self.contestants.push(Contestant { name, rays, bytes, seconds: Vec::new(), tests, run });
    }

    /// Runs all in turn, for `rounds` rounds after one that doesn't count. Results are ordered by the rays at once.
    pub(super) fn run(mut self, rounds: u32) -> Vec<Costs> {
        for round in 0..=rounds {
            for contestant in &mut self.contestants {
                let seconds = (contestant.run)();
                if round > 0 {
                    contestant.seconds.push(seconds);
                }
            }
        }
        let count = self.triangles.len() as f64;
        self.contestants.sort_by_key(|contestant| contestant.rays as u8);
        let costs = self.contestants.iter().map(|contestant| {
            let Contestant { name, rays, bytes, .. } = *contestant;
            let median_of = |part: usize| median(contestant.seconds.iter().map(|seconds| seconds[part]));
            let rate = |list: usize| 1e-6 * contestant.tests[list] / median_of(list + 1);
            // Other load of the machine changes from round to round, but less within one.
            let is_one = |other: &&Contestant<'_>| (other.rays == Rays::One) == (rays == Rays::One);
            let first = self.contestants.iter().find(is_one).unwrap_or(contestant);
            let rounds = contestant.seconds.iter().zip(&first.seconds);
            let seconds_ratio = median(rounds.map(|(seconds, first)| first[1] / seconds[1]));
            let more_tests = contestant.tests[0] / first.tests[0];
            let speedup = seconds_ratio * more_tests;
            let (rate, hit_rate, miss_rate) = (rate(0), rate(1), rate(2));
            let prepare_ns = 1e9 * median_of(0) / count;
            Costs { name, rays, bytes, prepare_ns, rate, hit_rate, miss_rate, more_tests, speedup }
        });
        costs.collect()
    }
}

fn corners(triangles: Triangles<'_>) -> impl Iterator<Item = [Vec3; 3]> {
    (0..triangles.len() as u32).map(move |id| triangles.corners(id))
}

/// Numbers of tests of one ray and one triangle in each list, given the number for a pair.
fn counts(lists: &Lists, tests: impl Fn(&Pair) -> usize) -> [f64; 3] {
    [&lists.all, &lists.hits, &lists.misses].map(|list| list.iter().map(&tests).sum::<usize>() as f64)
}

/// The representative ray of each group.
fn single_rays(pairs: &Pairs) -> Vec<triangle::Rays<f32>> {
    let single = |ray: &Ray| {
        let (origin, direction) = (ray.origin.as_vec3(), ray.direction.as_vec3());
        triangle::Rays::new(origin.to_array(), direction.to_array(), [0.0, f32::INFINITY])
    };
    pairs.blocks.iter().map(|block| single(&block[SINGLE])).collect()
}

/// Seconds that `test` takes for one ray and all pairs of each list; it stores its last result.
fn one_by_one(of: &Lists, test: impl Fn(&Pair, &mut [f32; 3])) -> [f64; 3] {
    lists(of, |pairs| {
        let mut last = [0.0; 3];
        pairs.iter().for_each(|pair| test(pair, &mut last));
        black_box(last);
    })
}

/// As [`one_by_one`], for sixteen rays.
#[inline(always)]
fn by_sixteen<S: Simd>(simd: S, of: &Lists, mut test: impl FnMut(&Pair, &mut [Wide<S>; 3])) -> [f64; 3] {
    lists(
        of,
        #[inline(always)]
        |pairs| {
            let mut last = [f32x16::splat(simd, 0.0); 3];
            for pair in pairs {
                test(pair, &mut last);
            }
            black_box(&last);
        },
    )
}

/// Seconds that `test` takes for each list, with its data in the caches as far as they fit.
#[inline(always)]
fn lists(lists: &Lists, mut test: impl FnMut(&[Pair])) -> [f64; 3] {
    /// Minimum number of tested pairs; shorter lists are repeated.
    const PAIRS: usize = 1 << 18;
    let mut seconds = [0.0; 3];
    for (seconds, list) in seconds.iter_mut().zip([&lists.all, &lists.hits, &lists.misses]) {
        let repeats = PAIRS.div_ceil(list.len().max(1)).min(1000);
        test(list);
        let start = Instant::now();
        for _ in 0..repeats {
            test(list);
        }
        *seconds = start.elapsed().as_secs_f64() / repeats as f64;
    }
    seconds
}

/// The rays of all groups.
#[inline(always)]
fn wide<S: Simd>(simd: S, pairs: &Pairs) -> Vec<triangle::Rays<Wide<S>>> {
    let mut rays = Vec::with_capacity(pairs.blocks.len());
    let interval = [f32x16::splat(simd, 0.0), f32x16::splat(simd, f32::INFINITY)];
    for block in &pairs.blocks {
        let origin = |axis: usize| block.map(|ray| ray.origin[axis] as f32);
        let direction = |axis: usize| block.map(|ray| ray.direction[axis] as f32);
        let [ox, oy, oz] = [origin(0), origin(1), origin(2)];
        let [dx, dy, dz] = [direction(0), direction(1), direction(2)];
        let origin = [f32x16::simd_from(simd, ox), f32x16::simd_from(simd, oy), f32x16::simd_from(simd, oz)];
        let direction = [f32x16::simd_from(simd, dx), f32x16::simd_from(simd, dy), f32x16::simd_from(simd, dz)];
        rays.push(triangle::Rays::new(origin, direction, interval));
    }
    rays
}

/// Keeps the numbers of rays that hit, as a traversal does.
#[inline(always)]
fn keep<S: Simd>(last: &mut [Wide<S>; 3], hits: Hits<Wide<S>>) {
    let [t, v, w] = *last;
    let [new_v, new_w] = hits.barycentric;
    *last = [hits.mask.select(hits.t, t), hits.mask.select(new_v, v), hits.mask.select(new_w, w)];
}

#[inline(always)]
fn sixteen<S: Simd, T: TriangleTest>(simd: S, tests: &[T], pairs: &Pairs) -> [f64; 3] {
    let rays = wide(simd, pairs);
    by_sixteen(
        simd,
        &pairs.sixteen,
        #[inline(always)]
        |pair, last| {
            if let Some(hits) = tests[pair.target as usize].hit(&rays[pair.block as usize]) {
                keep(last, hits);
            }
        },
    )
}

#[inline(always)]
fn bundled<S: Simd, T: BundleTest>(simd: S, tests: &[T], pairs: &Pairs) -> [f64; 3] {
    let rays = wide(simd, pairs);
    let mut bundles = Vec::with_capacity(rays.len());
    for &triangle::Rays { direction, t_min, t_max, .. } in &rays {
        bundles.push(Bundle { direction, t_min, t_max });
    }
    by_sixteen(
        simd,
        &pairs.sixteen,
        #[inline(always)]
        |pair, last| {
            if let Some(hits) = tests[pair.target as usize].hit(&bundles[pair.block as usize]) {
                keep(last, hits);
            }
        },
    )
}

#[inline(always)]
fn sixteen_fans<S: Simd>(simd: S, fans: &Fans, pairs: &Pairs, of_fans: &Lists) -> [f64; 3] {
    let rays = wide(simd, pairs);
    by_sixteen(
        simd,
        of_fans,
        #[inline(always)]
        |pair, last| {
            fans.fan(pair.target as usize).hit(
                &rays[pair.block as usize],
                #[inline(always)]
                |_, hits| keep(last, hits),
            );
        },
    )
}
