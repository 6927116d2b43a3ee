//! A kd-tree that is built again on threads of its own while rays are traced through the one before (Yang, Xu and Zhao, *Ray
//! Tracing Dynamic Scenes using fast KD-tree Base on Multi-Core Architecture*, 2008; thesis §4.2).
//!
//! A new tree is ready some frames after the one that it was built for, and triangles have moved since. Yang et al. deform their
//! tree, and don't say what rays may miss. Here the older tree stays as it is: for each of its nodes it is measured how far
//! at most a vertex of a triangle below it has moved, along any axis, and cells count as larger by that much. So answers are
//! those for the triangles where they are, however old the tree is; age only costs time. As Yang et al. do, the
//! surface area heuristic judges that: the cost of the tree with its grown cells, in parts of what it was when it was built,
//! says when to build again, and when not to use it at all.
//!
//! `advance` moves on to a frame, `trace` leads rays, and `grown` says why nothing is missed: for a triangle now at
//! weights w₁ a + w₂ b + w₃ c of its corners, the same point at rest is no farther away along an axis than the corner that has
//! moved most.

mod advance;
mod trace;
mod validate;

use std::sync::Mutex;
use std::sync::mpsc::Receiver;

use glam::Vec3;

use crate::kdtree::Extent;
use crate::shot::{Bytes, LightMask, SeenPixels, Shot, Work};
use crate::{
    ImageTooLarge, ImpossibleKdTreeOptions, KdTree, KdTreeOptions, LightSource, Omitted, SimdLevel, SingleRays,
    Structure, Triangles, ray_by_ray,
};

/// When a [`BackgroundKdTree`] is built again: by what rays through it are expected to cost, in parts of what they did when it
/// was built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RebuildPolicy {
    /// A new tree is begun for a frame that costs more, unless one is being built. From 1.
    pub rebuild_above: f64,
    /// A frame that would cost more, or isn't of the same triangles, waits for a tree of its own. No less than the above.
    pub wait_above: f64,
}

impl RebuildPolicy {
    /// Begins early, since a new tree is for an earlier frame when it comes; and waits where a build is cheaper than such rays.
    pub const DEFAULT: Self = Self { rebuild_above: 1.05, wait_above: 3.0 };
}

impl Default for RebuildPolicy {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// What a frame is traced with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KdAge {
    /// Frames since the one that the tree was built for.
    pub frames: u32,
    /// What rays are expected to cost, in parts of what they did for that frame; 1 where nothing has moved.
    pub cost_ratio: f64,
    /// Whether the frame waited for its tree.
    pub has_waited: bool,
    /// Whether a newer tree is being built.
    pub is_building: bool,
}

/// Why there is no [`BackgroundKdTree`], or no such policy.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ImpossibleBackground {
    /// Its threads can't be started, in the words of the system.
    #[error("threads can't be started: {0}")]
    Threads(String),
    /// Ratios aren't in order, or not from 1.
    #[error("a tree can't be rebuilt above {} and waited for above {}", .0.rebuild_above, .0.wait_above)]
    Policy(RebuildPolicy),
}

/// A kd-tree that is built on threads of its own while rays are traced through an earlier one. What rays hit are the
/// triangles of the current frame, exactly, whichever tree leads them there; so answers don't depend on when a tree is ready.
///
/// Call [`advance`](Self::advance) for each frame. Two trees are held, with a copy of the triangles that each was built over:
/// about twice what a [`KdTree`] takes, 24 bytes for each vertex and triangle, and four for each node.
pub struct BackgroundKdTree {
    options: KdTreeOptions,
    policy: RebuildPolicy,
    threads: rayon::ThreadPool,
    /// What rays are traced through.
    current: Built,
    /// Memory for the next tree, unless it is being built.
    spare: Option<Built>,
    /// Where the next tree comes from, and how many frames ago it was begun. The lock is never taken: it lets threads share
    /// the whole.
    coming: Option<(Mutex<Receiver<Built>>, u32)>,
    /// Frames since the one that the current tree was built for.
    frames: u32,
    /// By node, how far a vertex of a triangle below it has moved since, at most.
    drift: Vec<f32>,
    /// By triangle.
    triangle_drift: Vec<f32>,
    /// Around all triangles now.
    extent: Extent,
    omitted: Omitted,
}

/// A tree, and what it was built over.
#[derive(Default)]
struct Built {
    tree: KdTree,
    positions: Vec<Vec3>,
    indices: Vec<[u32; 3]>,
    /// Triangles that no ray could hit.
    unusable: Vec<u32>,
    /// What rays through it were expected to cost.
    cost: f64,
}

impl std::fmt::Debug for BackgroundKdTree {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("BackgroundKdTree")
            .field("current", &self.current.tree)
            .field("frames", &self.frames)
            .field("is_building", &self.coming.is_some())
            .finish_non_exhaustive()
    }
}

impl BackgroundKdTree {
    /// Nothing yet, with so many threads to build on; zero means as many as there are processors.
    ///
    /// # Errors
    /// If threads can't be started.
    pub fn new(threads: usize) -> Result<Self, ImpossibleBackground> {
        let threads = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        Ok(Self {
            options: KdTreeOptions::DEFAULT,
            policy: RebuildPolicy::DEFAULT,
            threads: threads.map_err(|error| ImpossibleBackground::Threads(error.to_string()))?,
            current: Built::default(),
            spare: Some(Built::default()),
            coming: None,
            frames: 0,
            drift: Vec::new(),
            triangle_drift: Vec::new(),
            extent: Extent::EMPTY,
            omitted: Omitted::default(),
        })
    }

    /// The same with packets that use the instructions of `level`, as rays do where nothing has moved.
    #[must_use]
    pub fn at_level(mut self, level: SimdLevel) -> Self {
        for built in [&mut self.current].into_iter().chain(&mut self.spare) {
            built.tree = KdTree::with_level(level);
        }
        self
    }

    /// Whether triangles are where they were when the tree was built.
    fn is_still(&self) -> bool {
        self.drift.first().is_none_or(|&drift| drift == 0.0)
    }

    /// Says how trees are built that are begun from now on. None is [lazy](KdTreeOptions::lazy_below), and where triangles have
    /// moved all are traversed with a stack.
    ///
    /// # Errors
    /// As [`KdTree::set_options`].
    pub fn set_options(&mut self, options: KdTreeOptions) -> Result<(), ImpossibleKdTreeOptions> {
        options.check()?;
        self.options = options;
        Ok(())
    }

    /// Says when trees are built again.
    ///
    /// # Errors
    /// If a ratio is below 1 or not a number, or frames wait for less than what trees are built again for.
    pub fn set_policy(&mut self, policy: RebuildPolicy) -> Result<(), ImpossibleBackground> {
        let RebuildPolicy { rebuild_above, wait_above } = policy;
        if !(1.0 <= rebuild_above && rebuild_above <= wait_above) {
            return Err(ImpossibleBackground::Policy(policy));
        }
        self.policy = policy;
        Ok(())
    }
}

impl Structure for BackgroundKdTree {
    fn build(&mut self, triangles: Triangles<'_>) {
        self.advance(triangles);
    }

    fn see(&mut self, shot: &Shot<'_>, seen: &mut SeenPixels) -> Result<Work, ImageTooLarge> {
        if self.is_still() {
            return self.current.tree.see(shot, seen);
        }
        ray_by_ray::see(self, shot, seen);
        Ok(Work::default())
    }

    fn shadow(&mut self, shot: &Shot<'_>, seen: &SeenPixels, lights: &[LightSource], masks: &mut [LightMask]) -> Work {
        if self.is_still() {
            return self.current.tree.shadow(shot, seen, lights, masks);
        }
        ray_by_ray::shadow(self, shot, seen, lights, masks);
        Work::default()
    }

    fn omitted(&self) -> &Omitted {
        &self.omitted
    }

    /// Not those of a tree that is being built.
    fn bytes(&self) -> Bytes {
        let drift = (self.drift.capacity() + self.triangle_drift.capacity()) * size_of::<f32>();
        let triangles = self.current.bytes() + self.spare.as_ref().map_or(0, Built::bytes) + drift;
        Bytes { triangles, points: 0 }
    }

    fn validate(&mut self, shot: &Shot<'_>, _: &SeenPixels, _: &[LightSource]) -> Result<(), String> {
        self.check(shot.triangles)
    }

    fn single_rays(&self) -> Option<&dyn SingleRays> {
        Some(self)
    }
}

impl Built {
    fn bytes(&self) -> usize {
        self.tree.bytes().triangles
            + self.positions.capacity() * size_of::<Vec3>()
            + self.indices.capacity() * size_of::<[u32; 3]>()
            + self.unusable.capacity() * size_of::<u32>()
    }
}
