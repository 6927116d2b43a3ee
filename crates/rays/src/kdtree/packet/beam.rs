use fearless_simd::{Simd, f32x16};

use super::KdCulling;
use super::filter::Filter;
use super::rays::{HALF_ULP, LANES, Rays};
use super::scale::Scale;
use super::search::Met;
use super::shaft::{Bundle, Lines, Shaft};
use super::tester::{Tester, bits_of};
use crate::kdtree::node::Nodes;

/// Leads a shaft to leaves in place of the rays inside it, and tests triangles there that aren't left out for the groups whose
/// own shafts they meet.
#[inline(always)]
pub(super) fn visit<S: Simd>(
    simd: S,
    rays: &mut Rays,
    bundle: &mut Bundle,
    start: &Met,
    culling: KdCulling,
    tester: &mut Tester<'_, '_>,
) {
    let (tree, scale) = (tester.tree, tester.scale);
    tester.steps.note(|visits| visits.packets += 1);
    tester.mailbox.clear(true);
    let lines = (culling == KdCulling::CornerRays).then(|| bundle.whole.corner_lines());
    let mut stack = [*start; Nodes::MAX_DEPTH];
    let mut waiting = 0;
    let mut met = *start;
    let mut last = f64::from(bundle.last(simd));
    loop {
        let node = tree.nodes.get(met.place);
        if node.is_leaf() {
            let ids = &tree.ids[node.ids()];
            if !ids.is_empty() {
                tester.steps.note(|visits| visits.leaves += 1);
                let mut culls = Culls { culling, transient: None, lines: lines.as_ref() };
                let mut is_met = true;
                if culling == KdCulling::TransientFrustum {
                    culls.transient = bundle.transient(simd, rays, &scale, &met);
                    is_met = culls.transient.is_some();
                }
                if is_met {
                    test_leaf(simd, rays, bundle, ids, &culls, &scale, tester);
                    last = f64::from(bundle.last(simd));
                }
            }
        } else {
            tester.steps.note(|visits| visits.nodes += 1);
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
            // Those of its rays that get there may have ended, though others haven't.
            if met.within[0] <= last && bundle.groups_in(simd, &scale, &met) != 0 {
                break;
            }
        }
    }
}

/// What leaves triangles out for all rays of a shaft.
struct Culls<'a> {
    culling: KdCulling,
    transient: Option<Shaft>,
    lines: Option<&'a Lines>,
}

impl Culls<'_> {
    /// Whether no ray hits a triangle, given by its corners along the shaft's axes: nowhere, or with a transient shaft not in
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
            KdCulling::Intervals => misses_box(rays, shaft, low, high),
            KdCulling::CornerRays => self.lines.is_some_and(|lines| filter.is_beside_all(simd, lines)),
            KdCulling::Vertices => shaft.is_beside(turned),
            KdCulling::TransientFrustum => self.transient.is_some_and(|shaft| shaft.is_beside(turned)),
        }
    }
}

#[inline(always)]
fn test_leaf<S: Simd>(
    simd: S,
    rays: &mut Rays,
    bundle: &mut Bundle,
    ids: &[u32],
    culls: &Culls<'_>,
    scale: &Scale,
    tester: &mut Tester<'_, '_>,
) {
    let mut changed = 0;
    for &id in ids {
        if tester.mailbox.has(id) {
            continue;
        }
        let corners = tester.triangles.corners(id);
        let axes = bundle.whole.axes;
        let turned = corners.map(
            #[inline(always)]
            |corner| axes.turned(scale.point(corner)),
        );
        let filter = Filter::new(scale, corners, rays.moved);
        let [a, b, c] = turned;
        let low = [0, 1, 2].map(|axis| a[axis].min(b[axis]).min(c[axis]));
        let high = [0, 1, 2].map(|axis| a[axis].max(b[axis]).max(c[axis]));
        if culls.leave_out(simd, rays, &bundle.whole, &turned, [low, high], &filter) {
            tester.steps.note(|visits| visits.culled += 1);
            continue;
        }
        // All groups that it meets anywhere are asked, so that it needn't be tested again in other leaves.
        let _ = tester.mailbox.untested(id, 1);
        for group in bits_of(bundle.groups(simd, low, high)) {
            let first = group * LANES;
            let members = (1 << (rays.count - first).min(LANES)) - 1;
            if tester.test::<S, f32x16<S>>(simd, rays, first, id, &filter, members) {
                changed |= 1 << group;
            }
        }
    }
    tester.ask(rays);
    for group in bits_of(changed) {
        bundle.shorten(simd, rays, group);
    }
}

/// Whether rays miss a box by interval arithmetic: along each axis t is in (box − origin) · 1 / direction, and in all of them.
fn misses_box(rays: &Rays, shaft: &Shaft, low: [f32; 3], high: [f32; 3]) -> bool {
    // Of a box's coordinates, and of t, which is far from both.
    const ROUNDING: f64 = 4.0 * HALF_ULP as f64;
    /// Directions that were taken for steeper ones are left alone.
    const STEEPEST: f64 = (1_u64 << 39) as f64;
    let (mut enter, mut leave) = (f64::NEG_INFINITY, f64::INFINITY);
    let moved = f64::from(rays.moved) + ROUNDING;
    for (place, axis) in shaft.axes.order.into_iter().enumerate() {
        let [slowest, fastest] = rays.intervals[axis];
        let [first, last] = rays.intervals[axis + 3];
        if (slowest < 0.0 && fastest > 0.0) || slowest.abs().max(fastest.abs()) > STEEPEST {
            continue;
        }
        let (mut low, mut high) = (f64::from(low[place]), f64::from(high[place]));
        if place == 2 && shaft.axes.sign < 0.0 {
            (low, high) = (-high, -low);
        }
        let (low, high) = (low - last - moved, high - first + moved);
        let products = [low * slowest, low * fastest, high * slowest, high * fastest];
        let [least, most] = [
            products.into_iter().fold(f64::INFINITY, f64::min),
            products.into_iter().fold(f64::NEG_INFINITY, f64::max),
        ];
        let slack = least.abs().max(most.abs()) * 1e-12;
        (enter, leave) = (enter.max(least - slack), leave.min(most + slack));
    }
    enter > leave
}
