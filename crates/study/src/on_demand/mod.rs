//! Geometry on demand: a scene on disk, of which a fixed number of bytes is in memory while rays are traced (the thesis'
//! §3.1).
//!
//! A hierarchy of boxes over all triangles is cut where a subtree takes no more than so many bytes. What is above the cuts,
//! and the rays, stay in memory; each subtree, a *part*, is on disk with its triangles. A ray goes through parts in the
//! order in which it enters their boxes, and needs no part behind its hit. What order the *rays* take differs:
//!
//! - one ray after the other, to its end, with the parts that were used last kept in memory;
//! - in queues, one for each part: the rays that wait for a part go through it together (Pharr, Kolb, Gershbein and
//!   Hanrahan, *Rendering Complex Scenes with Memory-Coherent Ray Tracing*, 1997), and the part with the most weight of
//!   rays for each byte that has to be read comes next;
//! - in generations: parts that fit into a processor's L2 cache, and all rays of a kind before those that come of them:
//!   from the camera, then to the light, then from a bounce (Navrátil, Fussell, Lin and Mark, *Dynamic Ray Scheduling to Improve Ray
//!   Coherence and Bandwidth Utilization*, 2007).
//!
//! The answers are the same, bit for bit, whatever the order and however little memory there is: the nearest hit that the
//! predicate finds, of equal ones that with the lowest id.
//!
//! **What differs from the papers.** Pharr et al. cut space by a grid and keep a triangle in each of its voxels; here each
//! triangle is in one part, and parts may overlap. They displace and tessellate what they load; here triangles are read.
//! Parts are read into memory rather than mapped: mapping a file needs `unsafe`, as others may change it meanwhile. Making
//! the file needs all triangles in memory.

mod cut;
mod parts;
mod rays;
mod schedule;

use std::io;

use glam::Vec3;
use umbrage_rays::{Hit, LightSource, Ray};

pub use parts::Scene;

/// In which order rays are traced.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// One after the other, each to its end.
    RayByRay,
    /// In queues; the part for which some ray has waited longest comes next.
    FirstCome,
    /// In queues; the part with the most weight of rays for its cost comes next.
    BenefitOverCost,
    /// In queues, parts in turn; rays that come of others wait until all of these are done, and those to the light are first.
    Generations,
}

impl Order {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::RayByRay, Self::FirstCome, Self::BenefitOverCost, Self::Generations];

    /// What it is called.
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

/// The ray that goes on from what ray number so many hits, given the ray, its hit and the corners of the triangle.
pub type Scatter = dyn Fn(usize, &Ray, &Hit, [Vec3; 3]) -> Option<Ray>;

/// What is traced.
#[derive(Clone, Copy)]
pub struct Question<'a> {
    /// Rays from the camera.
    pub rays: &'a [Ray],
    /// What lights the points that rays hit.
    pub light: LightSource,
    /// The bounce: from what its rays hit no further ones go on.
    pub scatter: &'a Scatter,
}

/// What is found: for rays from the camera, and for those that go on from what they hit.
#[derive(Clone, Debug, PartialEq)]
pub struct Answers {
    /// The nearest hit of each ray; `None` also where there is no ray.
    pub hits: [Vec<Option<Hit>>; 2],
    /// Whether the light reaches it.
    pub lit: [Vec<bool>; 2],
}

/// What that took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Costs {
    /// How often a part was read.
    pub loads: u64,
    /// How many bytes that were.
    pub bytes_read: u64,
    /// The most bytes of parts in memory at any time.
    pub most_resident_bytes: u64,
    /// The most rays that waited at any time.
    pub most_waiting: u64,
    /// How often a ray went through a part.
    pub visits: u64,
}

/// Why nothing is found.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The largest part doesn't fit.
    #[error("{budget} bytes for parts, the largest of which takes {largest}")]
    TooLittleMemory {
        /// The bytes that there are.
        budget: u64,
        /// The bytes that there must be.
        largest: u64,
    },
    /// The file can't be read.
    #[error("the scene's file: {0}")]
    Read(#[from] io::Error),
}
