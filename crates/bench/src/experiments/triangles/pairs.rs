//! Rays and the triangles that a structure would test them against.

use std::ops::ControlFlow;

use anyhow::{Result, ensure};
use umbrage::rays::predicate;
use umbrage::rays::{Ray, Triangles, View};
use umbrage_papers::{UniformGrid, Visit as _};

/// Approximate number of ray groups from an image.
const BLOCKS: u32 = 4096;
/// Side of a group in pixels.
const SIDE: u32 = 4;
/// Index of a group's representative ray.
pub(super) const SINGLE: usize = 5;

/// A group of rays and a triangle, or a fan, by their indices.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair {
    pub(super) block: u32,
    pub(super) target: u32,
}

/// Pairs in the order of a traversal: all, and separately hits and misses.
#[derive(Debug, Default)]
pub(super) struct Lists {
    pub(super) all: Vec<Pair>,
    pub(super) hits: Vec<Pair>,
    pub(super) misses: Vec<Pair>,
}

impl Lists {
    pub(super) fn new(pairs: impl Iterator<Item = Pair>, is_hit: impl Fn(&Pair) -> bool) -> Self {
        let all: Vec<Pair> = pairs.collect();
        let (hits, misses) = all.iter().partition(|pair| is_hit(pair));
        Self { all, hits, misses }
    }
}

/// Input of all tests.
#[derive(Debug)]
pub(super) struct Pairs {
    /// Sixteen rays each.
    pub(super) blocks: Vec<[Ray; 16]>,
    pub(super) single: Lists,
    pub(super) sixteen: Lists,
}

impl Pairs {
    pub(super) fn new(triangles: Triangles<'_>, view: &View) -> Result<Self> {
        let (columns, rows) = (view.width / SIDE, view.height / SIDE);
        ensure!(columns > 0 && rows > 0, "the image is smaller than {SIDE}x{SIDE} pixels");
        let stride = (columns * rows).div_ceil(BLOCKS);
        let block = |index: u32| {
            let (x, y) = (index % columns * SIDE, index / columns * SIDE);
            let ray = |lane: u32| view.ray(f64::from(x + lane % SIDE) + 0.5, f64::from(y + lane / SIDE) + 0.5);
            std::array::from_fn(|lane| ray(lane as u32))
        };
        // An odd stride spreads them over all columns.
        let blocks: Vec<[Ray; 16]> = (0..columns * rows).step_by((stride | 1) as usize).map(block).collect();

        let mut grid = UniformGrid::default();
        grid.build(triangles);
        let mut pairs = Vec::new();
        // The group that last met a triangle, so that each meets it once.
        let mut met = vec![u32::MAX; triangles.len()];
        for (block, rays) in (0..).zip(&blocks) {
            let ray = &rays[SINGLE];
            let _ = grid.visit(triangles, ray, |id, t_max| {
                if std::mem::replace(&mut met[id as usize], block) != block {
                    pairs.push(Pair { block, target: id });
                    *t_max = predicate::hit(ray, triangles, id).map_or(*t_max, |hit| t_max.min(hit.t));
                }
                ControlFlow::Continue(())
            });
        }
        ensure!(!pairs.is_empty(), "no ray comes near a triangle");
        let is_hit = |ray: &Ray, pair: &Pair| predicate::hit(ray, triangles, pair.target).is_some();
        let single = Lists::new(pairs.iter().copied(), |pair| is_hit(&blocks[pair.block as usize][SINGLE], pair));
        let sixteen =
            Lists::new(pairs.iter().copied(), |pair| blocks[pair.block as usize].iter().any(|ray| is_hit(ray, pair)));
        Ok(Self { blocks, single, sixteen })
    }
}
