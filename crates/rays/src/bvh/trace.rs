use std::ops::ControlFlow;

use fearless_simd::{Simd, dispatch};

use super::leaf::{Found, Leaf};
use super::line::{Line, Slabs};
use super::{Bvh, Child, Kind, Node, WIDTH};
use crate::predicate::{ShadowRay, hit, hit_of_near};
use crate::simd::lanes::bits_of;
use crate::{Hit, Ray, SingleRays, Triangles};

impl SingleRays for Bvh {
    fn nearest(&self, triangles: Triangles<'_>, ray: &Ray, stops: &dyn Fn(&Hit) -> bool) -> Option<Hit> {
        let line = match self.start(ray) {
            Start::Miss => return None,
            Start::Everything => None,
            Start::Line(line) => Some(line),
        };
        let Some(line) = line else { return self.nearest_of_all(triangles, ray, stops) };
        let mut nearest = Nearest {
            triangles,
            ray,
            stops,
            line: &line,
            best: None,
            waiting: Waiting::default(),
            lazy: true,
            passed: false,
        };
        dispatch!(self.level.into(), simd => self.nearest_at(simd, &mut nearest));
        if nearest.passed {
            // What lets the ray through has hidden others.
            nearest.lazy = false;
            dispatch!(self.level.into(), simd => self.nearest_at(simd, &mut nearest));
        }
        nearest.best
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
        match self.start(&shadow_ray.ray) {
            Start::Miss => false,
            Start::Everything => self.ids().any(blocks),
            Start::Line(line) => dispatch!(self.level.into(), simd => self.blocked_at(simd, &line, blocks)),
        }
    }
}

/// What a ray's traversal begins with.
enum Start {
    Miss,
    /// Numbers so large that f32 can't hold them: all triangles are asked about.
    Everything,
    Line(Line),
}

/// Triangles that a ray may hit, about which the predicate hasn't been asked yet.
#[derive(Default)]
struct Waiting {
    ids: [u32; Waiting::MOST],
    earliest: [f32; Waiting::MOST],
    count: usize,
}

impl Waiting {
    const MOST: usize = 8;
}

struct Nearest<'a> {
    triangles: Triangles<'a>,
    ray: &'a Ray,
    line: &'a Line,
    stops: &'a dyn Fn(&Hit) -> bool,
    best: Option<Hit>,
    waiting: Waiting,
    /// Whether a triangle that is certainly met ends the ray before the predicate and `stops` are asked.
    lazy: bool,
    /// Whether a hit that had ended the ray let it through.
    passed: bool,
}

impl Nearest<'_> {
    #[inline(always)]
    fn take(&mut self, leaf: &Leaf, found: &Found, far: &mut f32) {
        for lane in bits_of(found.possible) {
            let lane = lane % Leaf::LANES;
            if found.earliest[lane] > *far {
                continue;
            }
            if self.waiting.count == Waiting::MOST {
                self.settle(far);
            }
            let at = self.waiting.count % Waiting::MOST;
            self.waiting.ids[at] = leaf.ids[lane];
            self.waiting.earliest[at] = found.earliest[lane];
            self.waiting.count += 1;
            if self.lazy && found.certain >> lane & 1 == 1 {
                *far = far.min(found.latest[lane]);
            }
        }
        if !self.lazy {
            self.settle(far);
        }
    }

    /// Asks the predicate about all that wait.
    #[inline(never)]
    fn settle(&mut self, far: &mut f32) {
        let count = std::mem::take(&mut self.waiting.count);
        for (&id, &earliest) in self.waiting.ids[..count].iter().zip(&self.waiting.earliest) {
            if earliest > *far {
                continue;
            }
            let Some(hit) = hit_of_near(self.ray, self.triangles.corners(id), id) else { continue };
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
    fn start(&self, ray: &Ray) -> Start {
        // What isn't a number rules nothing out on the way, and would be tested with all triangles.
        if !ray.is_sound() || self.nodes.is_empty() {
            return Start::Miss;
        }
        Line::new(ray, self.scale).map_or(Start::Everything, Start::Line)
    }

    /// The ids of all triangles, leaf by leaf.
    #[doc(hidden)]
    pub fn ids(&self) -> impl Iterator<Item = u32> {
        self.nodes
            .iter()
            .flat_map(Node::leaves)
            .flat_map(move |(leaf, lanes)| bits_of(lanes).map(move |lane| self.leaves[leaf].ids[lane]))
    }

    #[cold]
    fn nearest_of_all(&self, triangles: Triangles<'_>, ray: &Ray, stops: &dyn Fn(&Hit) -> bool) -> Option<Hit> {
        let hits = self.ids().filter_map(|id| hit(ray, triangles, id)).filter(|hit| stops(hit));
        hits.min_by(|a, b| a.t.total_cmp(&b.t).then(a.triangle.cmp(&b.triangle)))
    }

    #[inline(always)]
    fn nearest_at<S: Simd>(&self, simd: S, nearest: &mut Nearest<'_>) {
        let mut far = nearest.line.far;
        let line = nearest.line;
        let _ = self.visit(
            simd,
            line,
            &mut far,
            #[inline(always)]
            |leaf, found, far| {
                nearest.take(leaf, found, far);
                ControlFlow::Continue(())
            },
        );
        nearest.settle(&mut far);
    }

    #[inline(always)]
    fn blocked_at<S: Simd>(&self, simd: S, line: &Line, blocks: impl Fn(u32) -> bool) -> bool {
        let mut far = line.far;
        let visited = self.visit(
            simd,
            line,
            &mut far,
            #[inline(always)]
            |leaf, found, _| {
                let is_blocked = bits_of(found.possible).any(|lane| blocks(leaf.ids[lane % Leaf::LANES]));
                if is_blocked { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            },
        );
        visited.is_break()
    }

    /// Calls `test` with what a line may hit in leaves before `far`, nearer boxes first. It may lower `far` or break off.
    #[inline(always)]
    fn visit<S: Simd>(
        &self,
        simd: S,
        line: &Line,
        far: &mut f32,
        mut test: impl FnMut(&Leaf, &Found, &mut f32) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let slabs = Slabs::new(simd, line);
        let mut stack = Stack::default();
        let mut next = Entered { enter: line.near, child: self.root };
        loop {
            match next.child.kind() {
                Kind::Leaf { index, lanes } => {
                    let leaf = &self.leaves[index];
                    if let Some(found) = leaf.find(simd, line, lanes, *far) {
                        test(leaf, &found, far)?;
                    }
                }
                Kind::Node(index) => {
                    let node = &self.nodes[index];
                    let (enter, mut met) = slabs.enter(simd, node, *far);
                    if met != 0 {
                        let enter: [f32; WIDTH] = enter.into();
                        next = Entered::first_of(&mut met, node, &enter);
                        if met != 0 {
                            stack.make_room();
                            let base = stack.waiting;
                            while met != 0 {
                                let mut other = Entered::first_of(&mut met, node, &enter);
                                if other.enter < next.enter {
                                    std::mem::swap(&mut next, &mut other);
                                }
                                stack.insert(base, other);
                            }
                        }
                        continue;
                    }
                }
            }
            loop {
                let Some(top) = stack.pop() else { return ControlFlow::Continue(()) };
                // What isn't a number is visited.
                let is_behind = top.enter > *far;
                if !is_behind {
                    next = top;
                    break;
                }
            }
        }
    }
}

/// A child that a ray comes to.
#[derive(Clone, Copy, Debug, Default)]
struct Entered {
    enter: f32,
    child: Child,
}

impl Entered {
    /// The child of the lowest bit, which is taken away.
    #[inline(always)]
    fn first_of(met: &mut u64, node: &Node, enter: &[f32; WIDTH]) -> Self {
        let slot = met.trailing_zeros() as usize % WIDTH;
        *met &= *met - 1;
        Self { enter: enter[slot], child: node.children[slot] }
    }
}

/// Children that wait, the nearest of a node last.
struct Stack {
    entries: [Entered; Stack::ROOM],
    waiting: usize,
    /// Those that came before where there was no more room: deeper than any hierarchy that isn't degenerate.
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

    /// Adds a child to those from `base` on, which stay in order.
    #[inline(always)]
    fn insert(&mut self, base: usize, entered: Entered) {
        let mut at = self.waiting;
        while at > base && self.entries[(at - 1) % Self::ROOM].enter < entered.enter {
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
