//! Shafts: convex parts of space around up to 256 rays. They find the node at which the rays enter the kd-tree, and are
//! taken to leaves instead of the rays (Rahikainen 2013, §5). They will serve batches of secondary rays.
//!
//! `shaft` is the part of space. Its rays have the same sign along one axis, and none of them is almost perpendicular
//! to it; other rays go in packets from the root. `search` finds their entry, `beam` takes a shaft to leaves. `options`
//! has the choices.

mod beam;
mod options;
mod search;
#[allow(clippy::module_inception, reason = "one file for each of the parts")]
mod shaft;

use crate::KdTree;
use crate::kdtree::{Ask, Extent, LANES, Rays, Scale};
use fearless_simd::Simd;
use umbrage_rays::dispatch;
use umbrage_rays::predicate::ShadowRay;
use umbrage_rays::{Counts, Hit, Ray, Triangles};

use beam::Beam;
pub use options::{KdCulling, KdEntry, ShaftLead, ShaftOptions};
pub use search::EntryPoint;
use search::Search;
use shaft::{Axes, Bundle};

/// [`KdTree::nearest_of_packet`] by shafts. Returns their counts: shafts as `packets`, culled triangles as
/// `frustum_culls`. The tree has the counts of packets.
///
/// # Panics
/// If there are more or fewer `hits` than `rays`.
pub fn nearest_of_shafts(
    tree: &KdTree,
    triangles: Triangles<'_>,
    rays: &[Ray],
    options: ShaftOptions,
    stops: impl Fn(&Hit) -> bool,
    hits: &mut [Option<Hit>],
) -> Counts {
    nearest_of_shafts_below(&EntryPoint::root(tree), tree, triangles, rays, options, stops, hits)
}

/// [`nearest_of_shafts`] for rays that all begin at `entry`.
///
/// # Panics
/// If there are more or fewer `hits` than `rays`.
pub fn nearest_of_shafts_below(
    entry: &EntryPoint,
    tree: &KdTree,
    triangles: Triangles<'_>,
    rays: &[Ray],
    options: ShaftOptions,
    stops: impl Fn(&Hit) -> bool,
    hits: &mut [Option<Hit>],
) -> Counts {
    let mut visits = Counts::default();
    tree.nearest_by(triangles, rays, stops, hits, |ask| {
        visits = visit((tree, entry), triangles, options, &|index| rays[index], rays.len(), ask);
    });
    visits
}

/// [`KdTree::blocked_of_packet`] by shafts. Returns counts as [`nearest_of_shafts`] does.
///
/// # Panics
/// If there are more or fewer `own` or `blocked` than `rays`.
pub fn blocked_of_shafts(
    tree: &KdTree,
    triangles: Triangles<'_>,
    (rays, own): (&[ShadowRay], &[u32]),
    options: ShaftOptions,
    stops: impl Fn(u32, [f32; 2]) -> bool,
    blocked: &mut [bool],
) -> Counts {
    let mut visits = Counts::default();
    tree.blocked_by(triangles, rays, own, stops, blocked, |ask| {
        let entry = EntryPoint::root(tree);
        visits = visit((tree, &entry), triangles, options, &|index| rays[index].ray, rays.len(), ask);
    });
    visits
}

fn visit(
    (tree, entry): (&KdTree, &EntryPoint),
    triangles: Triangles<'_>,
    options: ShaftOptions,
    ray: &dyn Fn(usize) -> Ray,
    count: usize,
    ask: &mut Ask<'_>,
) -> Counts {
    let mut visits = Counts::default();
    tree.prepare(ray, count, ask, &mut |rays, ask| {
        let mut shafts =
            Shafts { tree, entry, triangles, scale: Scale::of(&tree.extent()), options, visits: &mut visits };
        let met = dispatch!(tree.level(), simd => shafts.visit(simd, rays, ask));
        if let Some(root) = met {
            tree.visit_from(triangles, rays, root, ask);
        }
    });
    visits
}

/// Context of a call.
struct Shafts<'a> {
    tree: &'a KdTree,
    entry: &'a EntryPoint,
    triangles: Triangles<'a>,
    scale: Scale,
    options: ShaftOptions,
    visits: &'a mut Counts,
}

impl Shafts<'_> {
    /// Finds the node from which the rays go on. If a shaft is to take them to leaves, traces them and returns `None`;
    /// else returns the node for packets.
    #[inline(always)]
    fn visit<S: Simd>(&mut self, simd: S, rays: &mut Rays, ask: &mut Ask<'_>) -> Option<u32> {
        if self.options.entry == KdEntry::Root && self.options.lead == ShaftLead::Packets {
            return Some(self.begin(rays, self.entry.node, self.entry.cell));
        }
        let Some(axes) = Axes::of(simd, rays) else {
            return Some(self.begin(rays, self.entry.node, self.entry.cell));
        };
        let mut bundle = Bundle::around(simd, rays, axes);
        let Self { tree, entry, triangles, scale, options, visits } = self;
        let ShaftOptions { entry: kind, lead, mailbox } = *options;
        let start = Search { tree, triangles: *triangles, scale, shaft: &bundle.whole, kind, visits }.start(entry)?;
        match lead {
            ShaftLead::Shaft(culling) => {
                let mut beam = Beam::new(tree, *triangles, *scale, culling, mailbox, visits);
                beam.visit(simd, rays, &mut bundle, &start, ask);
                None
            }
            ShaftLead::Packets => Some(self.begin(rays, start.node, start.cell)),
        }
    }

    /// Clips rays to the cell of a node, as on the way to a child, so that they begin there. All leaves that matter are
    /// below it.
    fn begin(&self, rays: &mut Rays, node: u32, cell: Extent) -> u32 {
        let (scale, whole) = (self.scale, self.tree.extent());
        for axis in 0..3 {
            for (at, is_low) in [(cell.min[axis], true), (cell.max[axis], false)] {
                if at == if is_low { whole.min[axis] } else { whole.max[axis] } {
                    continue;
                }
                let at = scale.coordinate(at, axis);
                for ray in 0..rays.count.next_multiple_of(LANES) {
                    let inverse = rays.inverse[axis][ray];
                    let (crossing, doubt) = ((at - rays.origin[axis][ray]) * inverse, rays.doubt[axis][ray]);
                    if (inverse < 0.0) == is_low {
                        rays.leave[ray] = rays.leave[ray].min(crossing + doubt);
                    } else {
                        rays.enter[ray] = rays.enter[ray].max(crossing - doubt);
                    }
                }
            }
        }
        node
    }
}

/// Indices of a word's set bits.
fn bits_of(mut bits: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let bit = bits.trailing_zeros() as usize;
        bits &= bits.wrapping_sub(1);
        (bit < 64).then_some(bit)
    })
}
