//! Re-ordering of secondary rays: batches of each generation, in other orders and together, beside single rays.

mod generations;

use anyhow::{Result, ensure};
use clap::{Args, ValueEnum};
use rayon::prelude::*;
use umbrage::rays::{Bvh, SingleRays as _, Triangles};
use umbrage_papers::reorder::{self, Counts, Order, Reorder, Traversal};

use super::kd_tree::frame;
use crate::flags::ImageFlags;
use crate::grids::time;
use crate::measure::{geometric_mean, median};
use crate::shot::{Lights, Shot, name};
use crate::table::{Cell, Table, row};
use generations::{Path, Rays, ShadowRays, WINDOW};

#[derive(Args, Debug)]
pub(crate) struct ReorderFlags {
    /// Files, sequences or demo:NAME
    #[arg(default_values = ["demo:glass", "demo:marbles", "demo:hall", "demo:statue"])]
    scenes: Vec<String>,
    /// Generations that are measured: how many bounces came before
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_values_t = [0, 1, 5, 10])]
    bounces: Vec<u32>,
    /// Most rays of a generation that are timed: batches that are spread over all of them
    #[arg(long, value_name = "N", default_value = "32768")]
    rays: usize,
    /// What is said of each method
    #[arg(long, value_enum, default_value = "rate")]
    show: Show,
    #[command(flatten)]
    common: ImageFlags,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Show {
    /// Rays a second, in relation to single rays
    Rate,
    /// Tests of eight lanes for each ray
    Tests,
    /// Part of their lanes in which something is tested
    Used,
    /// Pairs of a ray and a triangle for each ray
    Triangles,
}

/// Compared methods, single rays first.
const METHODS: [(&str, Reorder); 14] = [
    ("single", of(Order::Arrival, Traversal::Single)),
    ("sorted", of(Order::Directions, Traversal::Single)),
    ("8", of(Order::Arrival, Traversal::Packets(8))),
    ("16", of(Order::Arrival, Traversal::Packets(16))),
    ("64", of(Order::Arrival, Traversal::Packets(64))),
    ("runs", of(Order::Runs, Traversal::Packets(64))),
    ("types", of(Order::Types, Traversal::Packets(64))),
    ("directions", of(Order::Directions, Traversal::Packets(64))),
    ("ranged", of(Order::Directions, Traversal::Ranged)),
    ("adaptive", of(Order::Types, Traversal::Adaptive)),
    ("by_direction", of(Order::Directions, Traversal::Adaptive)),
    ("stream", of(Order::Arrival, Traversal::Stream)),
    ("by_types", of(Order::Types, Traversal::Stream)),
    ("frusta", of(Order::Directions, Traversal::MultiFrusta)),
];

const fn of(order: Order, by: Traversal) -> Reorder {
    Reorder { order, by }
}

/// Times and counts of a method for a batch of rays.
struct Taken {
    milliseconds: Vec<f64>,
    counts: Counts,
}

impl ReorderFlags {
    pub(crate) fn run(&self) -> Result<()> {
        let mut table = self.common.start_without_chart()?;
        let mut ratios = vec![Vec::new(); METHODS.len()];
        for address in &self.scenes {
            let frame = frame(address)?;
            let mut shot = Shot::new(&frame, address, self.common.size, 1, Lights::First);
            shot.make_lights(2);
            let mut bvh = Bvh::default();
            // As from the second frame on, when patches are known.
            (0..3).for_each(|_| bvh.build(frame.triangles()));
            for path in [Path::Mirrors, Path::Diffuse] {
                let mut rays = Rays::of_camera(&shot);
                for bounce in 0..=self.bounces.iter().copied().max().unwrap_or(0) {
                    let hits = rays.hits(&shot, &bvh);
                    // Camera rays are the same on all paths.
                    if self.bounces.contains(&bounce) && (bounce > 0 || path == Path::Mirrors) {
                        let shadow = ShadowRays::new(&shot, &rays.rays, &hits, self.rays);
                        let timed = rays.clone().thinned(self.rays);
                        let title = if bounce == 0 { "camera" } else { path.name() };
                        let taken = self.nearest(&bvh, frame.triangles(), &timed)?;
                        self.push(&mut table, [name(address), title], bounce, timed.rays.len(), &taken, &mut ratios)?;
                        let title = format!("{title}, shadow");
                        let taken = self.blocked(&bvh, frame.triangles(), &shadow)?;
                        self.push(&mut table, [name(address), &title], bounce, shadow.rays.len(), &taken, &mut ratios)?;
                    }
                    rays = rays.next(&shot, &hits, path);
                }
            }
        }
        let mean = |(&(name, _), ratios): (_, &Vec<f64>)| {
            let ratios = ratios.iter().copied().filter(|&ratio| ratio > 0.0);
            format!("{name} {:.2}", geometric_mean(ratios))
        };
        let means: Vec<String> = METHODS.iter().zip(&ratios).map(mean).collect();
        let means = format!("Geometric means: {}.", means.join(", "));
        table.finish(&[self.show.meaning(), METHODS_IN_WORDS, &means])?;
        Ok(())
    }

    /// Times of all methods for the nearest hits, which must be the same.
    fn nearest(&self, bvh: &Bvh, triangles: Triangles<'_>, batch: &Rays) -> Result<Vec<Taken>> {
        let single: Vec<_> = batch.rays.iter().map(|ray| bvh.nearest(triangles, ray, &|_| true)).collect();
        self.taken(|how| {
            let rays = batch.rays.par_chunks(WINDOW).zip(batch.kinds.par_chunks(WINDOW));
            let answer = |(rays, kinds): (&[_], &[_])| {
                let mut hits = vec![None; rays.len()];
                let counts = reorder::nearest(bvh, triangles, (rays, kinds), how, &|_| true, &mut hits);
                (hits, counts)
            };
            let answers: Vec<_> = rays.map(answer).collect();
            let is_same = || answers.iter().flat_map(|(hits, _)| hits).eq(&single);
            (sum(answers.iter().map(|(_, counts)| *counts)), is_same())
        })
    }

    fn blocked(&self, bvh: &Bvh, triangles: Triangles<'_>, batch: &ShadowRays) -> Result<Vec<Taken>> {
        let is_blocked = |(ray, &own)| bvh.blocked(triangles, ray, own, &|_, _| true);
        let single: Vec<bool> = batch.rays.iter().zip(&batch.own).map(is_blocked).collect();
        self.taken(|how| {
            let rays =
                batch.rays.par_chunks(WINDOW).zip(batch.own.par_chunks(WINDOW)).zip(batch.kinds.par_chunks(WINDOW));
            let answer = |((rays, own), kinds): ((&[_], &[_]), &[_])| {
                let mut blocked = vec![false; rays.len()];
                let counts = reorder::blocked(bvh, triangles, (rays, own, kinds), how, &|_, _| true, &mut blocked);
                (blocked, counts)
            };
            let answers: Vec<_> = rays.map(answer).collect();
            let is_same = || answers.iter().flat_map(|(blocked, _)| blocked).eq(&single);
            (sum(answers.iter().map(|(_, counts)| *counts)), is_same())
        })
    }

    /// Runs all methods in turn, several times. To show counts, once, and single rays by the counting traversal.
    fn taken(&self, answer: impl Fn(Reorder) -> (Counts, bool)) -> Result<Vec<Taken>> {
        let nothing = || Taken { milliseconds: Vec::new(), counts: Counts::default() };
        let mut all: Vec<Taken> = METHODS.iter().map(|_| nothing()).collect();
        let rounds = if self.show == Show::Rate { self.common.animation.frames } else { 1 };
        for _ in 0..rounds {
            for ((title, how), taken) in METHODS.iter().zip(&mut all) {
                let is_counted = self.show != Show::Rate && how.by == Traversal::Single;
                let how = if is_counted { Reorder { by: Traversal::SingleCounted, ..*how } } else { *how };
                let mut milliseconds = 0.0;
                let (counts, is_same) = time(&mut milliseconds, || answer(how));
                ensure!(is_same, "{title} gives other answers than single rays");
                taken.milliseconds.push(milliseconds);
                taken.counts = counts;
            }
        }
        Ok(all)
    }

    fn push(
        &self,
        table: &mut Table,
        [scene, rays]: [&str; 2],
        bounce: u32,
        count: usize,
        taken: &[Taken],
        ratios: &mut [Vec<f64>],
    ) -> Result<()> {
        let mut row = row![("scene", scene), ("rays", rays), ("bounce", bounce), ("count", count)];
        let spent = |taken: &Taken| median(taken.milliseconds.iter().copied());
        let single = spent(&taken[0]);
        if self.show == Show::Rate {
            row.push(("single_us".to_owned(), Cell::Number(count as f64 / (1e3 * single), 2)));
        }
        for (((title, _), taken), ratios) in METHODS.iter().zip(taken).zip(ratios) {
            let Counts { tests, lanes, triangles, .. } = taken.counts;
            let of_ray = |number: u64| number as f64 / count.max(1) as f64;
            let (number, digits) = match self.show {
                Show::Rate => (single / spent(taken), 2),
                Show::Tests => (of_ray(tests), 1),
                Show::Used => (lanes as f64 / (8 * tests.max(1)) as f64, 2),
                Show::Triangles => (of_ray(triangles), 1),
            };
            if count > 0 {
                ratios.push(number);
            }
            row.push(((*title).to_owned(), Cell::Number(number, digits)));
        }
        Ok(table.push(row)?)
    }
}

fn sum(counts: impl Iterator<Item = Counts>) -> Counts {
    counts.fold(Counts::default(), |mut sum, counts| {
        sum += counts;
        sum
    })
}

const METHODS_IN_WORDS: &str = "single: the hierarchy's own rays; sorted: the same by kind and direction; 8, 16, 64: packets as rays come; runs: of one kind, as they come; types: sorted by kind; directions: by direction as well; ranged: packets of 256 by direction, with ranges and bounds; adaptive: regrouped packets of 64 by kind, and by direction; stream: of 4096, and by kind; frusta: eight of eight rays, by direction.";

impl Show {
    fn meaning(self) -> &'static str {
        match self {
            Self::Rate => {
                "single_us: rays a microsecond, one by one; others: rates in relation to it, with what sorting takes."
            }
            Self::Tests => {
                "Tests of eight lanes for each ray: rays or frusta with a box, a ray or bounds with eight boxes."
            }
            Self::Used => "Part of the lanes of these tests in which there is something to test.",
            Self::Triangles => "Pairs of a ray and a triangle for each ray, eight of which are tested at once.",
        }
    }
}
