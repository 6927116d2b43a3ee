//! What does a ray hit?
//!
//! Triangles, rays, cameras and lights as sources of rays, the exact [predicate] that decides every hit, and the
//! structures that find the triangles worth asking it about. No files, no images, no GPU.
//!
//! Hidden modules are for `umbrage-papers`, whose structures are made of the same parts. They may change in any version.
#![forbid(unsafe_code)]

/// `Debug` for a type that shows some of its fields and marks the rest as omitted.
#[doc(hidden)]
#[macro_export]
macro_rules! debug_some {
    ($type:ident as $this:ident: $($name:literal => $value:expr),+) => {
        impl std::fmt::Debug for $type {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                let $this = self;
                f.debug_struct(stringify!($type))$(.field($name, &$value))+.finish_non_exhaustive()
            }
        }
    };
}

mod bounds;
mod bvh;
mod camera;
#[doc(hidden)]
pub mod camera_grid;
mod choice;
mod curve_order;
mod edge_functions;
mod edges;
#[doc(hidden)]
pub mod grids;
mod hash_key;
mod hilbert;
mod light;
#[doc(hidden)]
pub mod light_grid;
mod nearest;
#[doc(hidden)]
pub mod parallel;
mod patches;
#[cfg(test)]
#[path = "tests/precise.rs"]
mod precise;
pub mod predicate;
#[cfg(test)]
mod random;
mod ray;
pub mod ray_by_ray;
mod scan;
#[doc(hidden)]
pub mod shear;
#[doc(hidden)]
pub mod shot;
#[doc(hidden)]
pub mod simd;
mod structure;
mod trace;
#[doc(hidden)]
pub mod triangles;

#[doc(hidden)]
pub use fearless_simd;
#[doc(hidden)]
pub use hash_key::HashKey;

pub use bounds::Bounds;
pub use bvh::{Bvh, InstanceTree, InstancedTriangles, Key, MotionTree, MovingTriangles, Placement};
pub use camera::{Camera, Projection, View};
pub use camera_grid::ImageTooLarge;
pub use choice::{Choice, UnknownChoice};
pub use grids::DirectGrids;
pub use light::LightSource;
pub use light_grid::{LightCell, LightCells, LightFace};
pub use nearest::{Closest, ClosestPoints, Nearest, Within};
pub use patches::Patches;
pub use ray::{Hit, Ray};
pub use ray_by_ray::SingleRays;
pub use scan::{Lit, LitBits, LitShare, Receivers, Scan, Scanned, Scanner, Sweep, Wanted};
pub use shot::{
    Bytes, Cone, Counts, LightMask, MaskAnswers, MaskPoints, Masks, Opacity, Opaque, PixelCounts, PixelWork, RayMasks,
    Seconds, SeenPixels, Shifts, Shot, Sides, TileOrder, Work,
};
pub use simd::SimdLevel;
pub use structure::{Parts, Specialised, Structure};
pub use trace::{Rays, Trace, TracedBy, Tracer};
pub use triangles::{Omitted, OmittedKind, Triangles};

/// Internals for `umbrage-papers`. Not part of the public API.
#[doc(hidden)]
pub mod internals {
    pub use crate::bvh::{
        Child as BvhChild, Inside as BvhInside, Kind as BvhKind, LESS as BVH_LESS, Leaf as BvhLeaf,
        LeafHits as BvhFound, Line as BvhLine, MORE as BVH_MORE, Nearest as BvhNearest, Node as BvhNode,
        Slabs as BvhSlabs, WIDTH as BVH_WIDTH,
    };
    pub use crate::triangles::Unusable;
}
