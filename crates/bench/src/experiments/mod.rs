//! The experiments of Guntury and Narayanan 2010, and others of the literature, one a file, each a table and a chart.

mod breakdown;
mod camera_triangles;
mod cells;
mod distance;
mod growth;
mod kd_tree;
mod light_buffer;
mod light_maps;
mod mapping;
mod on_demand;
mod queues;
mod reorder;
mod sweep;
mod table1;
mod triangles;
mod uniform;

pub(crate) use breakdown::BreakdownFlags;
pub(crate) use camera_triangles::CameraTrianglesFlags;
pub(crate) use cells::CellsFlags;
pub(crate) use distance::DistanceFlags;
pub(crate) use growth::GrowthFlags;
pub(crate) use kd_tree::{
    KdAblationsFlags, KdBouncesFlags, KdBuildersFlags, KdEntriesFlags, KdFramesFlags, KdGpuFlags, KdMovingFlags,
    KdScalingFlags, KdTraversalsFlags,
};
pub(crate) use light_buffer::LightBufferFlags;
pub(crate) use light_maps::LightMapsFlags;
pub(crate) use mapping::MappingFlags;
pub(crate) use on_demand::OnDemandFlags;
pub(crate) use queues::QueuesFlags;
pub(crate) use reorder::ReorderFlags;
pub(crate) use table1::Table1Flags;
pub(crate) use triangles::TrianglesFlags;
pub(crate) use uniform::{
    CullingFlags, DensityFlags, GridOptionsFlags, ModelsFlags, NestedFlags, PacketsFlags, ResolutionFlags,
};
