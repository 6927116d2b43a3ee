//! What does a ray hit?
//!
//! Triangles, rays, cameras and lights as sources of rays, the exact [predicate] that decides every hit, and the
//! structures that find the triangles worth asking it about. No files, no images, no GPU.
#![forbid(unsafe_code)]

mod bounds;
mod bvh;
mod camera;
mod camera_grid;
mod counting_sort;
mod grids;
mod kdtree;
mod light;
mod light_grid;
mod listed;
mod packet;
pub mod predicate;
mod ray;
pub mod ray_by_ray;
mod shot;
mod simd;
mod single;
mod structure;
mod triangles;
mod uniform;

pub use bounds::Bounds;
pub use bvh::Bvh;
pub use camera::{Camera, Projection, View};
pub use camera_grid::{ImageTooLarge, PerspectiveGrid};
pub use grids::{CameraGrid, DirectGrids, Grids, LightsGrid, ListedGrids};
pub use kdtree::{
    BackgroundKdTree, Clipping, ImpossibleBackground, ImpossibleHierarchy, ImpossibleKdTreeOptions, ImpossibleObjects,
    KdAge, KdBuilder, KdCulling, KdEntry, KdLayout, KdMailbox, KdMotion, KdObject, KdPacketOptions, KdPacketVisits,
    KdPacketWidth, KdTraversal, KdTree, KdTreeCounts, KdTreeForm, KdTreeOptions, KdTreeVisits, RebuildPolicy, SahCosts,
    SceneHierarchy, TwoLevelCounts, TwoLevelKdTree, UnknownKdName,
};
pub use light::LightSource;
pub use light_grid::{LightCell, LightCells, LightFace, LightGrid};
pub use listed::{
    Cells, ImpossibleCells, ImpossibleLightCells, ListedGrid, ListedLightGrid, ListedLightOptions, ListedOptions,
};
pub use ray::{Hit, Ray};
pub use shot::{
    Bytes, Counts, LightMask, MaskAnswers, MaskPoints, Opacity, Opaque, PixelCounts, PixelWork, Seconds, SeenPixels,
    Shot, Sides, TileOrder, Work,
};
pub use simd::{SimdLevel, UnknownSimdLevel};
pub use single::{SingleRays, Visit};
pub use structure::{Specialised, Structure};
pub use triangles::{Omitted, OmittedKind, Triangles};
pub use uniform::{ImpossibleUniformOptions, Insertion, PacketSide, UniformGrid, UniformOptions};
