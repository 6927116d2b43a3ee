//! A kd-tree that is built again on threads of its own while rays are traced through the one before (Yang, Xu and Zhao, *Ray
//! Tracing Dynamic Scenes using fast KD-tree Base on Multi-Core Architecture*, 2008; thesis §4.2).
//!
//! A new tree is ready some frames after the one that it was built for, and triangles have moved since. Yang et al. deform
//! their tree, and don't discuss the hits that may be missed. Here the older tree stays as it is. The largest distance that
//! a vertex of a triangle below a node has moved along any axis is measured for each node, and cells count as larger by that
//! much. So answers are those for the current triangles, however old the tree is; age only costs time. As in Yang et al.,
//! the surface area heuristic judges that: the cost of the tree with its grown cells, relative to that when it was built,
//! decides when to build again, and when not to use it at all.
//!
//! `advance` moves on to a frame, `trace` leads rays, and `grown` shows why no hit is missed: a point w₁ a + w₂ b + w₃ c of
//! a triangle is no farther along an axis from the same point at rest than the corner that has moved most.

mod advance;
mod trace;
mod validate;

use std::sync::Mutex;
use std::sync::mpsc::Receiver;

use glam::Vec3;

use crate::kdtree::Extent;
use crate::{ImpossibleKdTreeOptions, KdTree, KdTreeOptions};
use umbrage_rays::shot::{Bytes, LightMask, SeenPixels, Shot, Work};
use umbrage_rays::{ImageTooLarge, LightSource, Omitted, SimdLevel, SingleRays, Structure, Triangles, ray_by_ray};

/// Thresholds for building a [`BackgroundKdTree`] again: ratios of the expected cost of rays through it to that when it was
/// built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RebuildPolicy {
    /// A frame with a higher ratio begins a new tree, unless one is being built. At least 1.
    pub rebuild_above: f64,
    /// A frame with a higher ratio, or of other triangles, waits for a tree of its own. At least `rebuild_above`.
    pub wait_above: f64,
}

impl RebuildPolicy {
    /// Begins early, since a new tree is for an earlier frame when it is ready, and waits if a build is cheaper than such
    /// rays.
    pub const DEFAULT: Self = Self { rebuild_above: 1.05, wait_above: 3.0 };
}

impl Default for RebuildPolicy {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// The age of the tree that a frame is traced with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KdAge {
    /// The number of frames since the one that the tree was built for.
    pub frames: u32,
    /// The expected cost of rays relative to that for that frame; 1 if nothing has moved.
    pub cost_ratio: f64,
    /// Whether the frame waited for its tree.
    pub has_waited: bool,
    /// Whether a newer tree is being built.
    pub is_building: bool,
}

/// The reason why there is no [`BackgroundKdTree`], or no such policy.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ImpossibleBackground {
    /// Its threads can't be started, in the words of the system.
    #[error("threads can't be started: {0}")]
    Threads(String),
    /// Ratios are below 1, not numbers, or not in order.
    #[error("a tree can't be rebuilt above {} and waited for above {}", .0.rebuild_above, .0.wait_above)]
    Policy(RebuildPolicy),
}

/// A kd-tree that is built on threads of its own while rays are traced through an earlier one. Rays hit the triangles of the
/// current frame, exactly, with any tree, so answers don't depend on when a tree is ready.
///
/// Call [`advance`](Self::advance) for each frame. Two trees are held, with a copy of the triangles that each was built
/// over: about twice the memory of a [`KdTree`], 24 bytes for each vertex and triangle, and four for each node.
pub struct BackgroundKdTree {
    options: KdTreeOptions,
    policy: RebuildPolicy,
    threads: rayon::ThreadPool,
    /// The tree that rays are traced through.
    current: Built,
    /// Memory for the next tree, unless it is being built.
    spare: Option<Built>,
    /// The channel of the next tree, and the number of frames since it was begun. The lock is never taken: it lets threads
    /// share the whole.
    coming: Option<(Mutex<Receiver<Built>>, u32)>,
    /// The number of frames since the one that the current tree was built for.
    frames: u32,
    /// The largest distance along an axis that a vertex of a triangle below a node has moved since, by node.
    drift: Vec<f32>,
    /// The same, by triangle.
    triangle_drift: Vec<f32>,
    /// The bounds of all triangles now.
    extent: Extent,
    omitted: Omitted,
}

/// A tree, and the triangles that it was built over.
#[derive(Default)]
struct Built {
    tree: KdTree,
    positions: Vec<Vec3>,
    indices: Vec<[u32; 3]>,
    /// Triangles that no ray could hit.
    unusable: Vec<u32>,
    /// The expected cost of rays through it when it was built.
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
    /// An empty tree that is built on this number of threads; zero means one for each processor.
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

    /// Makes packets use the instructions of `level`. Rays go in packets if nothing has moved.
    #[must_use]
    pub fn at_level(mut self, level: SimdLevel) -> Self {
        for built in [&mut self.current].into_iter().chain(&mut self.spare) {
            built.tree = KdTree::with_level(level);
        }
        self
    }

    /// Whether no triangle has moved since the tree was built.
    fn is_still(&self) -> bool {
        self.drift.first().is_none_or(|&drift| drift == 0.0)
    }

    /// Sets the options of trees that are begun from now on. None is [lazy](KdTreeOptions::lazy_below), and trees whose
    /// triangles have moved are all traversed with a stack.
    ///
    /// # Errors
    /// As [`KdTree::set_options`].
    pub fn set_options(&mut self, options: KdTreeOptions) -> Result<(), ImpossibleKdTreeOptions> {
        options.check()?;
        self.options = options;
        Ok(())
    }

    /// Sets the policy for building trees again.
    ///
    /// # Errors
    /// If a ratio is below 1 or not a number, or `wait_above` is below `rebuild_above`.
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

    /// Excludes a tree that is being built.
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
