use std::ops::ControlFlow;

use crate::dispatch;
use fearless_simd::{Simd, f32x8};
use glam::Vec3;

use super::leaf::{Leaf, LeafHits};
use super::line::{Line, Slabs};
use super::{Bvh, Child, Kind, Node, WIDTH};
use crate::predicate::{ShadowRay, hit, hit_of_near_at};
use crate::simd::lanes::bits_of;
use crate::vectorized;
use crate::{Hit, Ray, SimdLevel, SingleRays, Triangles};

impl SingleRays for Bvh {
    fn nearest_from(&self, triangles: Triangles<'_>, ray: &Ray, own: u32, stops: &dyn Fn(&Hit) -> bool) -> Option<Hit> {
        if !self.may_be_met(ray) {
            return None;
        }
        let hit = dispatch!(self.level, simd => self.nearest_at(simd, triangles, ray, own, stops));
        match &self.far {
            None => hit,
            Some(far) => far.nearer_than(hit, triangles, ray, own, stops),
        }
    }

    fn blocked(
        &self,
        triangles: Triangles<'_>,
        shadow_ray: &ShadowRay,
        own: u32,
        stops: &dyn Fn(u32, [f32; 2]) -> bool,
    ) -> bool {
        let blocks = |id: u32| {
            id != own && shadow_ray.blocked_by(triangles.corners(id)).is_some_and(|barycentric| stops(id, barycentric))
        };
        self.may_be_met(&shadow_ray.ray)
            && (dispatch!(self.level, simd => self.blocked_at(simd, &shadow_ray.ray, blocks))
                || self.far.as_ref().is_some_and(|far| far.blocked(triangles, shadow_ray, own, stops)))
    }
}

/// The parts of the hierarchy that rays traverse, for experiments.
#[derive(Clone, Copy)]
pub struct Inside<'a> {
    /// The level whose instructions are used.
    pub level: SimdLevel,
    /// Factor for coordinates in all boxes and leaves. Where some triangles reach beyond 2⁴⁰ and others stay within 2³⁰, the
    /// former are missing here.
    pub scale: f32,
    /// The root; meaningless where there are no nodes.
    pub root: Child,
    /// All nodes.
    pub nodes: &'a [Node],
    /// All leaves.
    pub leaves: &'a [Leaf],
}

/// Candidates of a ray that the predicate hasn't tested yet.
#[derive(Default)]
struct UntestedCandidates {
    /// The leaf of each, and its lane there.
    triangles: [(u32, u32); UntestedCandidates::MOST],
    /// Whether each is certainly hit.
    certain: [bool; UntestedCandidates::MOST],
    earliest: [f32; UntestedCandidates::MOST],
    count: usize,
}

impl UntestedCandidates {
    const MOST: usize = 8;
}

/// Where a hierarchy's triangles are: at its own corners, or at those of a copy or of a moment.
pub trait Corners {
    /// The id and the world-space corners of the triangle in a lane of a leaf.
    fn triangle(&self, bvh: &Bvh, leaf: usize, lane: usize) -> (u32, [Vec3; 3]);

    /// As [`Bvh::visit`].
    #[inline(always)]
    fn visit<S: Simd>(
        &self,
        simd: S,
        bvh: &Bvh,
        (line, stack): (&Line, &mut Stack),
        far: &mut f32,
        test: impl FnMut(usize, &LeafHits, &mut f32) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        bvh.visit(simd, (line, stack), far, test)
    }
}

impl Corners for Triangles<'_> {
    #[inline(always)]
    fn triangle(&self, bvh: &Bvh, leaf: usize, lane: usize) -> (u32, [Vec3; 3]) {
        let leaf = &bvh.leaves[leaf];
        let id = leaf.ids[lane % Leaf::LANES];
        // The leaf has just been read; its corners are the triangle's unless they are scaled.
        (id, if bvh.scale == 1.0 { leaf.corners(lane % Leaf::LANES) } else { self.corners(id) })
    }
}

/// The state of a search for a ray's nearest hit.
pub struct Nearest<'a, C = Triangles<'a>> {
    bvh: &'a Bvh,
    corners: C,
    ray: &'a Ray,
    line: &'a Line,
    /// The triangle that isn't hit, by its id in the leaves.
    own: u32,
    stops: &'a dyn Fn(&Hit) -> bool,
    best: Option<Hit>,
    waiting: UntestedCandidates,
    /// Whether a certain hit shortens the ray before the predicate and `stops` are called.
    lazy: bool,
    /// Whether a hit that had shortened the ray let it through.
    passed: bool,
}

impl<'a, C: Corners> Nearest<'a, C> {
    /// A search without candidates.
    #[inline(always)]
    pub fn new(
        bvh: &'a Bvh,
        corners: C,
        ray: &'a Ray,
        line: &'a Line,
        own: u32,
        stops: &'a dyn Fn(&Hit) -> bool,
    ) -> Self {
        let (best, waiting) = (None, UntestedCandidates::default());
        Self { bvh, corners, ray, line, own, stops, best, waiting, lazy: true, passed: false }
    }

    /// The ray's nearest hit, after all leaves have been taken; `None` where the traversal must be repeated, since a hit
    /// that lets the ray through has hidden others.
    #[inline(always)]
    pub fn end<S: Simd>(&mut self, simd: S, far: &mut f32) -> Option<Option<Hit>> {
        self.settle(simd, far);
        if self.passed && self.lazy {
            self.lazy = false;
            return None;
        }
        Some(self.best)
    }

    /// Takes the candidates of a leaf, and lowers `far` to the nearest known hit.
    #[inline(always)]
    pub fn take<S: Simd>(&mut self, simd: S, leaf: usize, found: &LeafHits, far: &mut f32) {
        for lane in bits_of(found.possible) {
            let lane = lane % Leaf::LANES;
            if found.earliest[lane] > *far || self.bvh.leaves[leaf].ids[lane] == self.own {
                continue;
            }
            if self.waiting.count == UntestedCandidates::MOST {
                self.settle(simd, far);
            }
            let at = self.waiting.count % UntestedCandidates::MOST;
            self.waiting.triangles[at] = (leaf as u32, lane as u32);
            self.waiting.certain[at] = found.is_hit(self.line, lane);
            self.waiting.earliest[at] = found.earliest[lane];
            self.waiting.count += 1;
            if self.lazy && found.certain >> lane & 1 == 1 {
                *far = far.min(found.latest[lane]);
            }
        }
        if !self.lazy {
            self.settle(simd, far);
        }
    }

    /// The nearest hit's triangle after all leaves have been taken, if that is certain without the predicate, and every
    /// triangle stops the ray.
    #[inline(always)]
    pub(super) fn certain(&self, far: f32) -> Option<u32> {
        if self.best.is_some() {
            return None;
        }
        let waiting = &self.waiting;
        let mut left = (0..waiting.count).filter(|&at| waiting.earliest[at % UntestedCandidates::MOST] <= far);
        let at = left.next()? % UntestedCandidates::MOST;
        let (leaf, lane) = waiting.triangles[at];
        (waiting.certain[at] && left.next().is_none())
            .then(|| self.bvh.leaves[leaf as usize].ids[lane as usize % Leaf::LANES])
    }

    /// Settles all waiting candidates by the predicate.
    #[inline(always)]
    fn settle<S: Simd>(&mut self, simd: S, far: &mut f32) {
        vectorized!(simd => self.settle_at(simd, far));
    }

    #[inline(always)]
    fn settle_at<S: Simd>(&mut self, simd: S, far: &mut f32) {
        let count = std::mem::take(&mut self.waiting.count);
        for (&(leaf, lane), &earliest) in self.waiting.triangles[..count].iter().zip(&self.waiting.earliest) {
            if earliest > *far {
                continue;
            }
            let (id, corners) = self.corners.triangle(self.bvh, leaf as usize, lane as usize);
            let Some(hit) = hit_of_near_at(simd, self.ray, corners, id) else { continue };
            if self.best.is_some_and(|best| (best.t, best.triangle) <= (hit.t, hit.triangle)) {
                continue;
            }
            if (self.stops)(&hit) {
                *far = far.min(self.line.at_least(hit.t));
                self.best = Some(hit);
            } else {
                self.passed = true;
            }
        }
    }
}

impl Bvh {
    #[doc(hidden)]
    pub fn inside(&self) -> Inside<'_> {
        let Self { level, scale, root, nodes, leaves, .. } = self;
        Inside { level: *level, scale: *scale, root: *root, nodes, leaves }
    }

    /// A hierarchy of its own for triangles with huge coordinates, where there are others as well.
    #[doc(hidden)]
    pub fn far(&self) -> Option<&Self> {
        self.far.as_deref()
    }

    /// Whether a ray can hit anything. NaN rules nothing out during traversal, so such a ray would be tested against all
    /// triangles.
    #[doc(hidden)]
    pub fn may_be_met(&self, ray: &Ray) -> bool {
        ray.is_sound() && !self.nodes.is_empty()
    }

    /// The nearer of a ray's nearest hit here and its hit on other triangles.
    #[cold]
    fn nearer_than(
        &self,
        other: Option<Hit>,
        triangles: Triangles<'_>,
        ray: &Ray,
        own: u32,
        stops: &dyn Fn(&Hit) -> bool,
    ) -> Option<Hit> {
        // At equal t the lowest id counts.
        let t_max = other.map_or(ray.t_max, |other| other.t.next_up());
        let hit = self.nearest_from(triangles, &Ray { t_max, ..*ray }, own, stops);
        let key = |hit: &Hit| (hit.t, hit.triangle);
        hit.filter(|hit| other.is_none_or(|other| key(hit) < key(&other))).or(other)
    }

    /// The ids of all triangles but far ones, leaf by leaf.
    #[doc(hidden)]
    pub fn ids(&self) -> impl Iterator<Item = u32> {
        self.nodes
            .iter()
            .flat_map(Node::leaves)
            .flat_map(move |(leaf, lanes)| bits_of(lanes).map(move |lane| self.leaves[leaf].ids[lane]))
    }

    #[cold]
    pub(super) fn nearest_of_all(
        &self,
        triangles: Triangles<'_>,
        ray: &Ray,
        own: u32,
        stops: &dyn Fn(&Hit) -> bool,
    ) -> Option<Hit> {
        let hits = self.ids().filter(|&id| id != own).filter_map(|id| hit(ray, triangles, id)).filter(|hit| stops(hit));
        hits.min_by(|a, b| a.t.total_cmp(&b.t).then(a.triangle.cmp(&b.triangle)))
    }

    // The line is made in this function: copying it took a fifth of the time of rays that meet little.
    #[inline(always)]
    fn nearest_at<S: Simd>(
        &self,
        simd: S,
        triangles: Triangles<'_>,
        ray: &Ray,
        own: u32,
        stops: &dyn Fn(&Hit) -> bool,
    ) -> Option<Hit> {
        let Some(line) = Line::new(ray, self.scale) else { return self.nearest_of_all(triangles, ray, own, stops) };
        self.nearest_on(simd, &line, triangles, ray, own, stops)
    }

    /// The nearest hit of a ray on a line that is near its own in the hierarchy's coordinates.
    #[inline(always)]
    pub(crate) fn nearest_on<S: Simd, C: Corners + Copy>(
        &self,
        simd: S,
        line: &Line,
        corners: C,
        ray: &Ray,
        own: u32,
        stops: &dyn Fn(&Hit) -> bool,
    ) -> Option<Hit> {
        let mut nearest = Nearest::new(self, corners, ray, line, own, stops);
        let mut stack = Stack::default();
        loop {
            let mut far = line.far;
            let _ = corners.visit(
                simd,
                self,
                (line, &mut stack),
                &mut far,
                #[inline(always)]
                |leaf, found, far| {
                    nearest.take(simd, leaf, found, far);
                    ControlFlow::Continue(())
                },
            );
            if let Some(hit) = nearest.end(simd, &mut far) {
                return hit;
            }
        }
    }

    #[inline(always)]
    fn blocked_at<S: Simd>(&self, simd: S, ray: &Ray, blocks: impl Fn(u32) -> bool) -> bool {
        let Some(line) = Line::new(ray, self.scale) else { return self.ids().any(blocks) };
        let mut far = line.far;
        let visited = self.visit(
            simd,
            (&line, &mut Stack::default()),
            &mut far,
            #[inline(always)]
            |leaf, found, _| {
                let is_blocked = bits_of(found.possible).any(|lane| blocks(self.leaves[leaf].ids[lane % Leaf::LANES]));
                if is_blocked { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            },
        );
        visited.is_break()
    }

    /// Calls `test` with the candidates of each leaf before `far`, nearer boxes first. `test` may lower `far` or break off.
    ///
    /// The stack is the caller's, for several rays: to fill it with zeros takes a tenth of a ray's time.
    #[inline(always)]
    pub(crate) fn visit<S: Simd>(
        &self,
        simd: S,
        (line, stack): (&Line, &mut Stack),
        far: &mut f32,
        mut test: impl FnMut(usize, &LeafHits, &mut f32) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        walk(
            simd,
            (self.nodes.as_slice(), self.root),
            (line, stack),
            far,
            #[inline(always)]
            |leaf, lanes, far| match self.leaves[leaf].find(simd, line, lanes, *far) {
                Some(found) => test(leaf, &found, far),
                None => ControlFlow::Continue(()),
            },
        )
    }
}

/// Nodes whose children a line enters.
pub(crate) trait Nodes {
    /// As [`Slabs::enter`], for the children of the node at an index.
    fn enter<S: Simd>(&self, simd: S, slabs: &Slabs<S>, index: usize, far: f32) -> (f32x8<S>, u64);

    fn children(&self, index: usize) -> &[Child; WIDTH];
}

impl Nodes for &[Node] {
    #[inline(always)]
    fn enter<S: Simd>(&self, simd: S, slabs: &Slabs<S>, index: usize, far: f32) -> (f32x8<S>, u64) {
        slabs.enter(simd, &self[index], far)
    }

    #[inline(always)]
    fn children(&self, index: usize) -> &[Child; WIDTH] {
        &self[index].children
    }
}

/// Calls `leaf` with the number of each leaf that a line enters before `far` and a bit for each of its triangles, nearer
/// boxes first. `leaf` may lower `far` or break off.
#[inline(always)]
pub(crate) fn walk<S: Simd>(
    simd: S,
    (nodes, root): (impl Nodes, Child),
    (line, stack): (&Line, &mut Stack),
    far: &mut f32,
    mut leaf: impl FnMut(usize, u32, &mut f32) -> ControlFlow<()>,
) -> ControlFlow<()> {
    let slabs = Slabs::new(simd, line);
    stack.clear();
    let mut next = Entered::new(line.near, root);
    loop {
        match next.child().kind() {
            Kind::Leaf { index, lanes } => leaf(index, lanes, far)?,
            Kind::Node(index) => {
                let (enter, mut met) = nodes.enter(simd, &slabs, index, *far);
                if met != 0 {
                    let (enter, children): ([f32; WIDTH], _) = (enter.into(), nodes.children(index));
                    next = Entered::first_of(&mut met, children, &enter);
                    if met != 0 {
                        stack.make_room();
                        let base = stack.waiting;
                        while met != 0 {
                            let other = Entered::first_of(&mut met, children, &enter);
                            let farther = next.max(other);
                            next = next.min(other);
                            stack.insert(base, farther);
                        }
                    }
                    continue;
                }
            }
        }
        loop {
            let Some(top) = stack.pop() else { return ControlFlow::Continue(()) };
            // NaN is visited.
            let is_behind = top.enter() > *far;
            if !is_behind {
                next = top;
                break;
            }
        }
    }
}

/// A child that a ray enters: the bits of its entry t above those of the child. For positive t these are in the order of t,
/// and compared without an unpredictable branch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
struct Entered(u64);

impl Entered {
    #[inline(always)]
    fn new(enter: f32, child: Child) -> Self {
        Self(u64::from(enter.to_bits()) << 32 | u64::from(child.0))
    }

    /// The child of the lowest bit, which is cleared.
    #[inline(always)]
    fn first_of(met: &mut u64, children: &[Child; WIDTH], enter: &[f32; WIDTH]) -> Self {
        let slot = met.trailing_zeros() as usize % WIDTH;
        *met &= *met - 1;
        Self::new(enter[slot], children[slot])
    }

    #[inline(always)]
    fn enter(self) -> f32 {
        f32::from_bits((self.0 >> 32) as u32)
    }

    #[inline(always)]
    fn child(self) -> Child {
        Child(self.0 as u32)
    }
}

/// Waiting children, the nearest of a node last.
pub struct Stack {
    entries: [Entered; Stack::ROOM],
    waiting: usize,
    /// Children moved here when there was no more room: only degenerate hierarchies are that deep.
    earlier: Vec<Entered>,
}

impl Default for Stack {
    #[inline(always)]
    fn default() -> Self {
        Self { entries: [Entered::default(); Self::ROOM], waiting: 0, earlier: Vec::new() }
    }
}

impl Stack {
    const ROOM: usize = 64;

    #[inline(always)]
    fn clear(&mut self) {
        self.waiting = 0;
        self.earlier.clear();
    }

    /// Makes room for the children of a node.
    #[inline(always)]
    fn make_room(&mut self) {
        if self.waiting + WIDTH > Self::ROOM {
            self.put_aside();
        }
    }

    #[cold]
    #[inline(never)]
    fn put_aside(&mut self) {
        self.earlier.extend(&self.entries[..self.waiting]);
        self.waiting = 0;
    }

    /// Adds a child to those from `base` on, and keeps these in order.
    #[inline(always)]
    fn insert(&mut self, base: usize, entered: Entered) {
        let mut at = self.waiting;
        while at > base && self.entries[(at - 1) % Self::ROOM] < entered {
            self.entries[at % Self::ROOM] = self.entries[(at - 1) % Self::ROOM];
            at -= 1;
        }
        self.entries[at % Self::ROOM] = entered;
        self.waiting += 1;
    }

    #[inline(always)]
    fn pop(&mut self) -> Option<Entered> {
        if self.waiting == 0 {
            return self.earlier.pop();
        }
        self.waiting -= 1;
        Some(self.entries[self.waiting % Self::ROOM])
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::random::Random;

    /// The numbers of candidates of 300 rays after the f32 tests, and of leaves with candidates.
    fn visits(positions: &[Vec3], indices: &[[u32; 3]]) -> [usize; 2] {
        let mut bvh = Bvh::default();
        bvh.build(Triangles { positions, indices });
        let mut random = Random::new(10);
        let mut counts = [0; 2];
        for _ in 0..300 {
            let target = DVec3::from_array([0; 3].map(|_| random.signed()));
            let ray = Ray::new(DVec3::Z * 3.0, target - DVec3::Z * 3.0);
            for bvh in [Some(&bvh), bvh.far.as_deref()].into_iter().flatten() {
                let line = Line::new(&ray, bvh.scale).expect("a line");
                dispatch!(SimdLevel::default(), simd => {
                    let _ = bvh.visit(simd, (&line, &mut Stack::default()), &mut line.far.clone(), |_, found, _| {
                        counts[0] += found.possible.count_ones() as usize;
                        counts[1] += 1;
                        ControlFlow::Continue(())
                    });
                });
            }
        }
        counts
    }

    #[test]
    fn one_far_vertex_leaves_little_more_to_the_predicate() {
        let mut random = Random::new(11);
        let mut point = || Vec3::from_array([0; 3].map(|_| random.signed() as f32));
        let positions: Vec<Vec3> =
            (0..2000).map(|_| point()).flat_map(|at| [at, at + 0.02 * Vec3::X, at + 0.02 * Vec3::Y]).collect();
        let indices: Vec<[u32; 3]> = (0..2000).map(|id| [3 * id, 3 * id + 1, 3 * id + 2]).collect();
        let usual = visits(&positions, &indices);
        for distance in [1e6, 1e12, 1e13, 1e25, 1e37] {
            let mut damaged = positions.clone();
            damaged[999] = Vec3::new(-1.0, 0.2, 0.1) * distance;
            let counts = visits(&damaged, &indices);
            let most = usual.map(|usual| usual + 300);
            assert!(counts[0] <= most[0] && counts[1] <= most[1], "{distance}: {counts:?} instead of {usual:?}");
        }
    }
}
