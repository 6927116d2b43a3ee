//! Packets of any rays through the uniform grid (Wald et al. 2006, §2.2). They will serve batches of secondary rays.

mod lines;

use fearless_simd::Simd;
use glam::DVec3;
use umbrage_rays::dispatch;
use umbrage_rays::predicate::{ShadowRay, hit};
use umbrage_rays::{Hit, Ray, Triangles};

use super::UniformGrid;
use super::lattice::Lattice;
use super::slices::{Beam, Scratch, Visitor};
use crate::packet::{Group, LANES, Planes};
use crate::statistics::Statistics;
use lines::{LineBlock, LineFilter};

/// Maximum number of rays that are traced together.
const MOST_RAYS: usize = 256;

/// Maximum number of blocks of 16 rays.
const MOST_BLOCKS: usize = MOST_RAYS / LANES;

/// [`nearest`](umbrage_rays::SingleRays::nearest) for each of `rays`, with any origins and directions: the hit of each
/// is written to the same index of `hits`, `None` for a miss.
///
/// Up to 256 consecutive rays are traced together, those that agree about the sign of a major axis (Wald et al. 2006,
/// §2.2): it pays if neighbours run side by side.
///
/// # Panics
/// If there are more or fewer `hits` than `rays`.
pub fn nearest_of_packet(
    grid: &UniformGrid,
    triangles: Triangles<'_>,
    rays: &[Ray],
    stops: impl Fn(&Hit) -> bool,
    hits: &mut [Option<Hit>],
) {
    assert!(rays.len() == hits.len(), "{} hits for {} rays", hits.len(), rays.len());
    hits.fill(None);
    for (rays, hits) in rays.chunks(MOST_RAYS).zip(hits.chunks_mut(MOST_RAYS)) {
        visit_packet(grid, triangles, &|index| rays[index], rays.len(), &mut |index, id| {
            let best = &mut hits[index];
            if let Some(hit) = hit(&rays[index], triangles, id)
                && best.is_none_or(|best| (hit.t, id) < (best.t, best.triangle))
                && stops(&hit)
            {
                *best = Some(hit);
            }
            best.map_or(f64::INFINITY, |best| best.t)
        });
    }
}

/// [`blocked`](umbrage_rays::SingleRays::blocked) for each of `rays`, whose points are on the triangles `own`.
///
/// Rays are traced together as by [`nearest_of_packet`].
///
/// # Panics
/// If there are more or fewer `own` or `blocked` than `rays`.
pub fn blocked_of_packet(
    grid: &UniformGrid,
    triangles: Triangles<'_>,
    rays: &[ShadowRay],
    own: &[u32],
    stops: impl Fn(u32, [f32; 2]) -> bool,
    blocked: &mut [bool],
) {
    let lens = (own.len(), blocked.len());
    assert!(lens == (rays.len(), rays.len()), "{lens:?} triangles and answers for {} rays", rays.len());
    blocked.fill(false);
    let packets = rays.chunks(MOST_RAYS).zip(own.chunks(MOST_RAYS)).zip(blocked.chunks_mut(MOST_RAYS));
    for ((rays, own), blocked) in packets {
        visit_packet(grid, triangles, &|index| rays[index].ray, rays.len(), &mut |index, id| {
            let corners = triangles.corners(id);
            let asked = !blocked[index] && id != own[index];
            blocked[index] |=
                asked && rays[index].blocked_by(corners).is_some_and(|barycentric| stops(id, barycentric));
            if blocked[index] { f64::NEG_INFINITY } else { f64::INFINITY }
        });
    }
}

/// Calls `ask` with the index of each ray and each triangle that it may hit; the result is the t beyond which hits
/// don't matter to the ray. Takes both functions by reference, so that this is compiled once.
fn visit_packet(
    grid: &UniformGrid,
    triangles: Triangles<'_>,
    ray: &dyn Fn(usize) -> Ray,
    count: usize,
    ask: &mut dyn FnMut(usize, u32) -> f64,
) {
    let Some(lattice) = grid.lattice else { return };
    let mut scratch = Scratch::default();
    let unit = grid.unit();
    let mut remaining = [0_u16; MOST_BLOCKS];
    (0..count).for_each(|index| remaining[index / LANES] |= 1 << (index % LANES));
    while let Some(block) = remaining.iter().position(|&remaining| remaining != 0) {
        let first = block * LANES + remaining[block].trailing_zeros() as usize;
        let group = Group::of(ray(first).direction);
        let mut packet = Lines::new(&lattice, triangles, group, ray(first).origin, unit, ask);
        for (block, remaining) in remaining.iter_mut().enumerate() {
            for lane in lanes_of(*remaining) {
                let index = block * LANES + lane;
                if index == first || group.has(ray(index).direction) {
                    packet.add(&lattice, index, &ray(index));
                    *remaining &= !(1 << lane);
                }
            }
        }
        let (beam, within) = packet.beam(&lattice);
        let scratch = &mut scratch;
        dispatch!(grid.level, simd => grid.visit_beam(simd, triangles, beam, within, scratch, &mut packet));
    }
}

/// A ray of a packet in cell coordinates.
#[derive(Clone, Copy, Default)]
struct Line {
    origin: DVec3,
    direction: DVec3,
    t_min: f64,
    /// The t from which on hits don't matter.
    t_max: f64,
}

/// The rays of a packet that agree about the sign of the major axis, and the visitor that tests triangles for them.
struct Lines<'a> {
    triangles: Triangles<'a>,
    group: Group,
    members: [u16; MOST_BLOCKS],
    lines: [Line; MOST_RAYS],
    blocks: [LineBlock; MOST_BLOCKS],
    filter: LineFilter,
    /// Last position along the major axis at which a hit may matter to a ray, in cells.
    last: f64,
    ask: &'a mut dyn FnMut(usize, u32) -> f64,
}

impl<'a> Lines<'a> {
    fn new(
        lattice: &Lattice,
        triangles: Triangles<'a>,
        group: Group,
        origin: DVec3,
        unit: f64,
        ask: &'a mut dyn FnMut(usize, u32) -> f64,
    ) -> Self {
        // The rays' origin if it is near the scene; corners are relative to it.
        let middle = lattice.corner + lattice.cells.as_dvec3() * (0.5 * lattice.side);
        let is_near = (origin - middle).abs().max_element() < lattice.side * f64::from(lattice.cells.max_element());
        let origin = if is_near { origin } else { middle };
        Self {
            triangles,
            group,
            members: [0; MOST_BLOCKS],
            lines: [Line::default(); MOST_RAYS],
            blocks: [LineBlock::default(); MOST_BLOCKS],
            filter: LineFilter::new(group, origin, unit),
            last: f64::INFINITY,
            ask,
        }
    }

    fn add(&mut self, lattice: &Lattice, index: usize, ray: &Ray) {
        let (block, lane) = (index / LANES, index % LANES);
        self.members[block] |= 1 << lane;
        self.filter.add(&mut self.blocks[block], lane, ray);
        self.lines[index] = Line {
            origin: lattice.coordinates(ray.origin),
            direction: ray.direction * (1.0 / lattice.side),
            t_min: ray.t_min,
            t_max: ray.t_max,
        };
    }

    fn members(&self) -> impl Iterator<Item = usize> + '_ {
        let blocks = self.members.iter().enumerate();
        blocks.flat_map(|(block, &members)| lanes_of(members).map(move |lane| block * LANES + lane))
    }

    /// Position of a ray along the major axis at t.
    fn way(&self, line: &Line, t: f64) -> f64 {
        let axis = self.group.axes[2];
        (line.origin[axis] + line.direction[axis] * t) * self.group.sign
    }

    /// The beam around all rays, and its interval of w.
    ///
    /// The lowest coordinate of several lines is a concave function of w, the highest a convex one: between two slices'
    /// faces the chords of both hold all rays (the bounding planes of Wald et al. 2006, §2.2).
    fn beam(&self, lattice: &Lattice) -> (Beam, [f64; 2]) {
        let Group { axes, sign } = self.group;
        let cells = f64::from(lattice.cells[axes[2]]);
        let mut beam = Beam { base: [0.0; 4], rate: [0.0; 4], axes, sign, start: 0.0, slack: 0.0 };
        let first = beam.first(lattice.cells[axes[2]]);
        let (mut enter, mut leave, mut reach) = (f64::INFINITY, f64::NEG_INFINITY, cells);
        for line in self.members().map(|index| &self.lines[index]) {
            enter = enter.min(self.way(line, line.t_min));
            leave = leave.max(self.way(line, line.t_max));
            reach = reach.max(line.origin.abs().max_element());
        }
        // Slopes are four at most. Twice as many roundings as in other packets, for the chords.
        const ROUNDINGS: f64 = 1.0 / (1_u64 << 39) as f64;
        beam.slack = Lattice::DOUBT + ROUNDINGS * 16.0 * (reach + f64::from(lattice.cells.max_element()));
        // NaN, of rays that hit nothing, is dropped here.
        let enter = (enter - beam.slack).floor().max(first).min(first + cells - 1.0);
        let leave = (leave + beam.slack).ceil().max(enter + 1.0).min(first + cells);
        let [near, far] = [enter, leave].map(|way| self.bounds(way));
        for bound in 0..4 {
            beam.rate[bound] = (far[bound] - near[bound]) / (leave - enter);
            beam.base[bound] = near[bound] - beam.rate[bound] * enter;
            // Rays from so far away that f64 overflows may be anywhere.
            if !beam.base[bound].is_finite() {
                (beam.base[bound], beam.rate[bound]) = (f64::NEG_INFINITY, 0.0);
            }
        }
        (beam, [enter, leave])
    }

    /// The box around all rays at a position along the major axis, as in [`Beam`].
    fn bounds(&self, way: f64) -> [f64; 4] {
        let [u, v, w] = self.group.axes;
        let mut bounds = [f64::INFINITY; 4];
        for line in self.members().map(|index| &self.lines[index]) {
            let t = (way * self.group.sign - line.origin[w]) / line.direction[w];
            let at = |axis: usize| line.origin[axis] + line.direction[axis] * t;
            let [at_u, at_v] = [at(u), at(v)];
            for (bound, at) in bounds.iter_mut().zip([at_u, -at_u, at_v, -at_v]) {
                *bound = bound.min(at);
            }
        }
        bounds
    }
}

impl Visitor for Lines<'_> {
    fn is_done(&self, way: f64) -> bool {
        way > self.last
    }

    #[inline(always)]
    fn test<S: Simd>(&mut self, simd: S, ids: &[u32], _: &mut Planes, statistics: &mut Statistics) {
        for &id in ids {
            let triangle = self.filter.triangle(self.triangles.corners(id));
            let mut is_asked = false;
            for block in 0..MOST_BLOCKS {
                if self.members[block] == 0 {
                    continue;
                }
                let missed = triangle.missed(simd, &self.blocks[block]);
                for lane in lanes_of(self.members[block] & !missed) {
                    statistics.note(|counts| counts.settled += 1);
                    let index = block * LANES + lane;
                    self.lines[index].t_max = self.lines[index].t_max.min((self.ask)(index, id));
                    is_asked = true;
                }
            }
            if is_asked {
                self.last = self.members().fold(f64::NEG_INFINITY, |last, index| {
                    let line = &self.lines[index];
                    last.max(self.way(line, line.t_max))
                });
            }
        }
    }
}

/// Indices of a word's set bits.
fn lanes_of(mut bits: u16) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = bits.trailing_zeros() as usize;
        bits &= bits.wrapping_sub(1);
        (lane < LANES).then_some(lane)
    })
}
