//! Geometry on demand: a scene on disk, with a fixed number of its bytes in memory while rays are traced (the thesis' §3.1).
//!
//! A hierarchy of boxes over all triangles is cut where a subtree takes no more than a given number of bytes. The boxes
//! above the cuts, and the rays, stay in memory; each subtree, a *part*, is on disk with its triangles. A ray goes through
//! parts in the order in which it enters their boxes, and needs no part behind its hit. The order of *rays* can be:
//!
//! - one ray after the other, to its end, with the most recently used parts kept in memory;
//! - queues, one for each part: the rays that wait for a part go through it together (Pharr, Kolb, Gershbein and
//!   Hanrahan, *Rendering Complex Scenes with Memory-Coherent Ray Tracing*, 1997), and the part with the most weight of
//!   rays for each byte to be read comes next;
//! - generations: parts that fit into a processor's L2 cache, and all rays of a kind before the rays that they spawn:
//!   from the camera, then to the light, then from a bounce (Navrátil, Fussell, Lin and Mark, *Dynamic Ray Scheduling to
//!   Improve Ray Coherence and Bandwidth Utilization*, 2007).
//!
//! The answers are the same, bit for bit, in any order and with any amount of memory: the predicate's nearest hit, of
//! equal ones that with the lowest id.
//!
//! **Differences from the papers.** Pharr et al. cut space by a grid and keep a triangle in each of its voxels; here
//! each triangle is in one part, and parts may overlap. They displace and tessellate loaded geometry; here triangles
//! are read. Parts are read into memory rather than mapped: mapping a file needs `unsafe`, as other programs may change
//! it meanwhile. Making the file needs all triangles in memory.

mod cut;
mod parts;
mod rays;
mod schedule;

use std::io;

use glam::Vec3;
use umbrage_rays::{Hit, LightSource, Ray};

pub use parts::Scene;

/// Order in which rays are traced.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// One after the other, each to its end.
    RayByRay,
    /// In queues; the part with the longest waiting ray comes next.
    FirstCome,
    /// In queues; the part with the most weight of rays for its cost comes next.
    BenefitOverCost,
    /// In queues, parts in turn; spawned rays wait until the rays before them are done, and shadow rays come first.
    Generations,
}

impl Order {
    /// All orders.
    pub const ALL: [Self; 4] = [Self::RayByRay, Self::FirstCome, Self::BenefitOverCost, Self::Generations];

    /// Name for output.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::RayByRay => "ray by ray",
            Self::FirstCome => "queues, first come",
            Self::BenefitOverCost => "queues, benefit over cost",
            Self::Generations => "generations",
        }
    }
}

/// The bounced ray of a hit, given the index of the camera's ray, the ray, its hit and the corners of the triangle.
pub type Scatter = dyn Fn(usize, &Ray, &Hit, [Vec3; 3]) -> Option<Ray>;

/// The rays to trace, their light and their bounce.
#[derive(Clone, Copy)]
pub struct Question<'a> {
    /// Rays from the camera.
    pub rays: &'a [Ray],
    /// Light on the points of hits.
    pub light: LightSource,
    /// The bounce; its rays spawn no further ones.
    pub scatter: &'a Scatter,
}

/// Answers for rays from the camera, and for their bounced rays.
#[derive(Clone, Debug, PartialEq)]
pub struct Answers {
    /// The nearest hit of each ray; `None` also if there is no ray.
    pub hits: [Vec<Option<Hit>>; 2],
    /// Whether the light reaches the hit.
    pub lit: [Vec<bool>; 2],
}

/// Costs of tracing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Costs {
    /// Number of times that a part was read.
    pub loads: u64,
    /// Bytes read.
    pub bytes_read: u64,
    /// Maximum bytes of parts in memory at any time.
    pub most_resident_bytes: u64,
    /// Maximum number of waiting rays at any time.
    pub most_waiting: u64,
    /// Number of times that a ray went through a part.
    pub visits: u64,
}

/// Why tracing failed.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The largest part doesn't fit.
    #[error("{budget} bytes for parts, the largest of which takes {largest}")]
    TooLittleMemory {
        /// The available bytes.
        budget: u64,
        /// The bytes of the largest part.
        largest: u64,
    },
    /// The file can't be read.
    #[error("the scene's file: {0}")]
    Read(#[from] io::Error),
}
