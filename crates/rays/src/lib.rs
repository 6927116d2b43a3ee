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
    BackgroundKdTree, Clipping, ImpossibleBackground, ImpossibleHierarchy, ImpossibleKdTreeOptions, ImpossibleObjects,
    KdAge, KdBuilder, KdCulling, KdEntry, KdLayout, KdMailbox, KdMotion, KdObject, KdPacketOptions, KdPacketVisits,
    KdPacketWidth, KdTraversal, KdTree, KdTreeCounts, KdTreeForm, KdTreeOptions, KdTreeVisits, RebuildPolicy, SahCosts,
    SceneHierarchy, TwoLevelCounts, TwoLevelKdTree,
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
