use crate::kdtree::{Ask, Filter, HALF_ULP, LANES, Nodes, Rays, Scale};
use crate::{KdMailbox, KdTree};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use umbrage_rays::{Counts, Triangles};

use super::search::Met;
use super::shaft::{Bundle, Lines, Shaft, alive};
use super::{KdCulling, bits_of};

/// Maximum number of pairs that are settled at once.
const MOST_PAIRS: usize = 32;

/// Takes shafts to leaves instead of their rays. There it tests each triangle that isn't culled, for the groups of rays
/// whose own shafts it meets.
pub(super) struct Beam<'a> {
    tree: &'a KdTree,
    triangles: Triangles<'a>,
    scale: Scale,
    culling: KdCulling,
    mailbox: Mailbox,
    /// Undecided pairs of a ray and a triangle.
    pairs: Vec<(u32, u32)>,
    visits: &'a mut Counts,
}

impl<'a> Beam<'a> {
    pub(super) fn new(
        tree: &'a KdTree,
        triangles: Triangles<'a>,
        scale: Scale,
        culling: KdCulling,
        mailbox: KdMailbox,
        visits: &'a mut Counts,
    ) -> Self {
        let (mailbox, pairs) = (Mailbox::new(mailbox), Vec::with_capacity(MOST_PAIRS));
        Self { tree, triangles, scale, culling, mailbox, pairs, visits }
    }

    /// Takes a shaft to leaves.
    #[inline(always)]
    pub(super) fn visit<S: Simd>(
        &mut self,
        simd: S,
        rays: &mut Rays,
        bundle: &mut Bundle,
        start: &Met,
        ask: &mut Ask<'_>,
    ) {
        let (tree, scale, culling) = (self.tree, self.scale, self.culling);
        self.visits.packets += 1;
        let lines = (culling == KdCulling::CornerRays).then(|| bundle.whole.corner_lines());
        let intervals = if culling == KdCulling::Intervals { intervals(simd, rays) } else { [[0.0; 2]; 6] };
        let mut stack = [*start; Nodes::MAX_DEPTH];
        let mut waiting = 0;
        let mut met = *start;
        let mut last = f64::from(bundle.last(simd));
        loop {
            let node = tree.nodes().get(met.node);
            if node.is_leaf() {
                let ids = &tree.ids()[node.ids()];
                if !ids.is_empty() {
                    self.visits.leaves += 1;
                    let mut culls = Culls { culling, transient: None, lines: lines.as_ref(), intervals: &intervals };
                    let mut is_met = true;
                    if culling == KdCulling::TransientFrustum {
                        culls.transient = bundle.transient(simd, rays, &scale, &met);
                        is_met = culls.transient.is_some();
                    }
                    if is_met {
                        self.test_leaf(simd, rays, bundle, ids, &culls, ask);
                        last = f64::from(bundle.last(simd));
                    }
                }
            } else {
                self.visits.nodes += 1;
                let [left, right] = met.children(tree, &scale, &bundle.whole);
                if let (Some(left), Some(right)) = (left, right) {
                    let is_left_first = bundle.whole.is_left_first(node.plane().axis);
                    let (first, other) = if is_left_first { (left, right) } else { (right, left) };
                    stack[waiting] = other;
                    waiting += 1;
                    met = first;
                    continue;
                } else if let Some(only) = left.or(right) {
                    met = only;
                    continue;
                }
            }
            loop {
                if waiting == 0 {
                    return;
                }
                waiting -= 1;
                met = stack[waiting];
                // The rays that get there may have ended, though others haven't.
                if met.within[0] <= last && bundle.groups_in(simd, &scale, &met) != 0 {
                    break;
                }
            }
        }
    }

    #[inline(always)]
    fn test_leaf<S: Simd>(
        &mut self,
        simd: S,
        rays: &mut Rays,
        bundle: &mut Bundle,
        ids: &[u32],
        culls: &Culls<'_>,
        ask: &mut Ask<'_>,
    ) {
        let mut changed = 0;
        for &id in ids {
            if self.mailbox.has(id) {
                continue;
            }
            let corners = self.triangles.corners(id);
            let (axes, scale) = (bundle.whole.axes, self.scale);
            let turned = corners.map(
                #[inline(always)]
                |corner| axes.turned(scale.point(corner)),
            );
            let filter = Filter::new(&scale, corners, rays.moved);
            let [a, b, c] = turned;
            let low = [0, 1, 2].map(|axis| a[axis].min(b[axis]).min(c[axis]));
            let high = [0, 1, 2].map(|axis| a[axis].max(b[axis]).max(c[axis]));
            if culls.leave_out(simd, rays, &bundle.whole, &turned, [low, high], &filter) {
                self.visits.frustum_culls += 1;
                continue;
            }
            // Tested for all groups that it meets anywhere, so that it needn't be tested again in other leaves.
            self.mailbox.note(id);
            for group in bits_of(bundle.groups(simd, low, high)) {
                let first = group * LANES;
                let members = (1 << (rays.count - first).min(LANES)) - 1;
                self.visits.tests += 1;
                let possible = filter.possible::<S, f32x16<S>>(simd, rays, first) & members;
                for lane in bits_of(possible) {
                    changed |= 1 << group;
                    self.pairs.push(((first + lane) as u32, id));
                    if self.pairs.len() == MOST_PAIRS {
                        self.ask(rays, ask);
                    }
                }
            }
        }
        self.ask(rays, ask);
        for group in bits_of(changed) {
            bundle.shorten(simd, rays, group);
        }
    }

    #[inline(never)]
    fn ask(&mut self, rays: &mut Rays, ask: &mut Ask<'_>) {
        let mut ends = [0.0; MOST_PAIRS];
        let ends = &mut ends[..self.pairs.len()];
        if !ends.is_empty() {
            ask(&self.pairs, ends);
        }
        for ((index, _), &mut end) in self.pairs.drain(..).zip(ends) {
            rays.end(index as usize, end);
        }
    }
}

/// Triangles that a shaft has tested. A forgotten one is tested again, which changes nothing.
struct Mailbox {
    kind: KdMailbox,
    ids: Vec<u32>,
    next: usize,
}

impl Mailbox {
    fn new(kind: KdMailbox) -> Self {
        let slots = match kind {
            KdMailbox::None => 0,
            KdMailbox::Ring => 8,
            KdMailbox::Hashed => 1024,
        };
        Self { kind, ids: vec![u32::MAX; slots], next: 0 }
    }

    #[inline(always)]
    fn has(&self, id: u32) -> bool {
        match self.kind {
            KdMailbox::None => false,
            KdMailbox::Ring => self.ids.contains(&id),
            KdMailbox::Hashed => self.ids[id as usize % self.ids.len()] == id,
        }
    }

    #[inline(always)]
    fn note(&mut self, id: u32) {
        let slots = self.ids.len();
        let slot = match self.kind {
            KdMailbox::None => return,
            KdMailbox::Ring => {
                self.next = (self.next + 1) % slots;
                self.next
            }
            KdMailbox::Hashed => id as usize % slots,
        };
        self.ids[slot] = id;
    }
}

/// Culls triangles for all rays of a shaft.
struct Culls<'a> {
    culling: KdCulling,
    transient: Option<Shaft>,
    lines: Option<&'a Lines>,
    intervals: &'a [[f64; 2]; 6],
}

impl Culls<'_> {
    /// Whether no ray hits a triangle, given by its corners along the shaft's axes; with a transient shaft, none in
    /// this leaf.
    #[inline(always)]
    fn leave_out<S: Simd>(
        &self,
        simd: S,
        rays: &Rays,
        shaft: &Shaft,
        turned: &[[f32; 3]; 3],
        [low, high]: [[f32; 3]; 2],
        filter: &Filter,
    ) -> bool {
        match self.culling {
            KdCulling::None => false,
            KdCulling::Intervals => misses_box(rays, self.intervals, shaft, low, high),
            KdCulling::CornerRays => self.lines.is_some_and(|lines| is_beside_all(simd, filter, lines)),
            KdCulling::Vertices => shaft.is_beside(turned),
            KdCulling::TransientFrustum => self.transient.is_some_and(|shaft| shaft.is_beside(turned)),
        }
    }
}

/// Whether all lines between a shaft's corner lines certainly miss on the same edge. Edge functions and the determinant
/// are linear in a line's positions on each of two planes, so their extremes are on the corner lines.
///
/// The lines' coordinates are nine at most, and s ten instead of two.
#[inline(always)]
fn is_beside_all<S: Simd>(simd: S, filter: &Filter, lines: &Lines) -> bool {
    const LARGER: f32 = 5.0;
    let [[ox, oy, oz], [dx, dy, dz]] = [&lines.origin, &lines.direction];
    let all = |numbers: &[f32; LANES]| f32x16::simd_from(simd, *numbers);
    let values = filter.values::<S, f32x16<S>>(simd, [all(ox), all(oy), all(oz)], [all(dx), all(dy), all(dz)]);
    let (weights, determinant) = (values.weights, values.determinant);
    let [bound, bound_of_a] = filter.weight_bounds.map(
        #[inline(always)]
        |value| f32x16::splat(simd, value * LARGER),
    );
    let bounds = [bound_of_a, bound, bound];
    let least = f32x16::splat(simd, filter.determinant_bound);
    if determinant.simd_gt(least).all_true() {
        (0..3).any(
            #[inline(always)]
            |corner| weights[corner].simd_lt(-bounds[corner]).all_true(),
        )
    } else if determinant.simd_lt(-least).all_true() {
        (0..3).any(
            #[inline(always)]
            |corner| weights[corner].simd_gt(bounds[corner]).all_true(),
        )
    } else {
        false
    }
}

/// Intervals around 1 / d and around the rays' entries into the tree's bounds, by axis, of rays that aren't done.
#[inline(always)]
fn intervals<S: Simd>(simd: S, rays: &Rays) -> [[f64; 2]; 6] {
    let mut intervals = [[f64::INFINITY, f64::NEG_INFINITY]; 6];
    for first in (0..rays.count).step_by(LANES) {
        for lane in bits_of(alive(simd, rays, first).to_bitmask()) {
            for axis in 0..3 {
                for (index, numbers) in [(axis, &rays.inverse[axis]), (axis + 3, &rays.origin[axis])] {
                    let [low, high] = &mut intervals[index];
                    let number = f64::from(numbers[first + lane]);
                    (*low, *high) = (low.min(number), high.max(number));
                }
            }
        }
    }
    intervals
}

/// Whether rays miss a box by interval arithmetic: along each axis t is in (box − origin) · 1 / direction, and the
/// intersection is empty.
fn misses_box(rays: &Rays, intervals: &[[f64; 2]; 6], shaft: &Shaft, low: [f32; 3], high: [f32; 3]) -> bool {
    // Rounding of a box's coordinates and of t.
    const ROUNDING: f64 = 4.0 * HALF_ULP as f64;
    /// Rounding of 1 / d, and of products.
    const INVERSE: f64 = 2.0 * HALF_ULP as f64;
    /// Axes that some ray is almost perpendicular to decide nothing: such directions were replaced by steeper ones.
    const STEEPEST: f64 = (1_u64 << 39) as f64;
    let (mut enter, mut leave) = (f64::NEG_INFINITY, f64::INFINITY);
    let moved = f64::from(rays.moved) + ROUNDING;
    for (slot, axis) in shaft.axes.order.into_iter().enumerate() {
        let [slowest, fastest] = intervals[axis];
        let [first, last] = intervals[axis + 3];
        if (slowest < 0.0 && fastest > 0.0) || slowest.abs().max(fastest.abs()) > STEEPEST {
            continue;
        }
        let (mut low, mut high) = (f64::from(low[slot]), f64::from(high[slot]));
        if slot == 2 && shaft.axes.sign < 0.0 {
            (low, high) = (-high, -low);
        }
        let (low, high) = (low - last - moved, high - first + moved);
        let products = [low * slowest, low * fastest, high * slowest, high * fastest];
        let [least, most] = [
            products.into_iter().fold(f64::INFINITY, f64::min),
            products.into_iter().fold(f64::NEG_INFINITY, f64::max),
        ];
        let slack = least.abs().max(most.abs()) * INVERSE;
        (enter, leave) = (enter.max(least - slack), leave.min(most + slack));
    }
    enter > leave
}
