//! What does a ray hit?
//!
//! Triangles, rays, cameras and lights as sources of rays, the exact [predicate] that decides every hit, and the
//! structures that find the triangles worth asking it about. No files, no images, no GPU.
#![forbid(unsafe_code)]

mod bounds;
mod bvh;
mod camera;
mod choice;
mod grid;
mod kdtree;
mod light;
mod packet;
pub mod predicate;
mod ray;
mod single;
pub mod triangle;
mod triangles;

pub use bounds::Bounds;
pub use bvh::Bvh;
pub use camera::{Camera, Projection, View};
pub use choice::{Choice, UnknownChoice};
pub use grid::{
    Cells, GridCounts, ImageTooLarge, ImpossibleCells, ImpossibleLightCells, ImpossibleUniformOptions, Insertion,
    LightCell, LightCells, LightFace, LightGrid, LightGridCounts, LightGridSeconds, ListedCounts, ListedGrid,
    ListedLightCounts, ListedLightGrid, ListedLightOptions, ListedLightSeconds, ListedOptions, ListedSeconds, Mask,
    MaskAnswers, MaskPoints, PacketSide, PerspectiveGrid, PixelWork, SeenImage, SeenPixels, ShadowMask, SimdLevel,
    TileOrder, UniformCounts, UniformGrid, UniformOptions, Unmasked, Work,
};
pub use kdtree::{
    BackgroundKdTree, Clipping, ImpossibleBackground, ImpossibleHierarchy, ImpossibleKdTreeOptions, ImpossibleObjects,
    KdAge, KdBuilder, KdCulling, KdEntry, KdLayout, KdMailbox, KdMotion, KdObject, KdPacketOptions, KdPacketVisits,
    KdPacketWidth, KdTraversal, KdTree, KdTreeCounts, KdTreeForm, KdTreeOptions, KdTreeVisits, RebuildPolicy, SahCosts,
    SceneHierarchy, TwoLevelCounts, TwoLevelKdTree,
};
pub use light::LightSource;
pub use ray::{Hit, Ray};
pub use triangles::{Omitted, OmittedKind, Triangles};
