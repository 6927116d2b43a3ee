//! What does a ray hit?
//!
//! Triangles, rays, cameras and lights as sources of rays, the exact [predicate] that decides every hit, and the
//! structures that find the triangles worth asking it about. No files, no images, no GPU.
#![forbid(unsafe_code)]

mod bounds;
mod bvh;
mod camera;
mod camera_grid;
mod choice;
mod counting_sort;
mod kdtree;
mod light;
mod light_grid;
mod listed;
mod packet;
pub mod predicate;
mod ray;
mod shot;
mod simd;
mod single;
mod triangles;
mod uniform;

pub use bounds::Bounds;
pub use bvh::Bvh;
pub use camera::{Camera, Projection, View};
pub use camera_grid::{GridCounts, ImageTooLarge, PerspectiveGrid};
pub use choice::{Choice, UnknownChoice};
pub use kdtree::{
    Clipping, ImpossibleKdTreeOptions, KdBuilder, KdLayout, KdMailbox, KdPacketOptions, KdPacketVisits, KdPacketWidth,
    KdTraversal, KdTree, KdTreeCounts, KdTreeOptions, KdTreeVisits, SahCosts,
};
pub use light::LightSource;
pub use light_grid::{LightCell, LightCells, LightFace, LightGrid, LightGridCounts, LightGridSeconds};
pub use listed::{
    Cells, ImpossibleCells, ImpossibleLightCells, ListedCounts, ListedGrid, ListedLightCounts, ListedLightGrid,
    ListedLightOptions, ListedLightSeconds, ListedOptions, ListedSeconds,
};
pub use ray::{Hit, Ray};
pub use shot::{
    Mask, MaskAnswers, MaskPoints, PixelWork, SeenImage, SeenPixels, ShadowMask, TileOrder, Unmasked, Work,
};
pub use simd::SimdLevel;
pub use triangles::{Omitted, OmittedKind, Triangles};
pub use uniform::{ImpossibleUniformOptions, Insertion, PacketSide, UniformCounts, UniformGrid, UniformOptions};

/// What `umbrage-study` needs of the crate's inside. Not part of the public API.
#[doc(hidden)]
pub mod internals {
    pub use crate::kdtree::{
        Ask, Branch, Candidate, Cell, Extent, Filter, HALF_ULP, Job, LANES, MOST_RAYS, Node, Nodes, Plane, Rays,
        Reference, Scale, Sides, Wide, load,
    };
    pub use crate::packet::{Group, Planes};
    pub use crate::single::{Visit, blocked, nearest};
    pub use crate::triangles::Unusable;
    pub use crate::uniform::{Beam, Lattice, Scratch, Statistics, Visitor};
}
