//! The tested structures, with their options: a new one is one line of the table.

use std::num::NonZeroU32;

use umbrage_papers::{BackgroundKdTree, HierarchyKdTree, KdPacketOptions, KdTree, SahCosts, TwoLevelKdTree};
pub use umbrage_papers::{
    Clipping, KdBuilder, KdLayout, KdMailbox, KdMoved, KdPacketWidth, KdTraversal, KdTreeOptions,
};
pub use umbrage_rays::{Bvh, DirectGrids, Insertion, LightClamp, PacketSide, SimdLevel, Structure, UniformOptions};
use umbrage_rays::{Cells, LightMapping, ListedGrids, ListedLightOptions, ListedOptions, UniformGrid};

/// Makes an empty structure.
pub type Make = fn(SimdLevel) -> Box<dyn Structure>;

/// Calls a macro with the table, in two parts: `long` has further options of the structures in `short`, and its tests
/// together take long. The caller needs the items of [this module](self) in scope.
#[macro_export]
macro_rules! structures {
    ($($call:tt)+) => {
        $($call)+! {
            short {
                direct: |level| Box::new(DirectGrids::with_level(level));
                listed: |level| listed(level, [16, 4, 8], true, [192, 256, 512, 1]);
                spherical: |level| spherical(level, [192, 256, 512, 1], None);
                uniform: |level| uniform(level, UniformOptions::DEFAULT);
                uniform_nested: |level| uniform(level, UniformOptions { packet: PacketSide::Sixteen, cells_per_triangle: 0.3, nested_above: Some(8), ..UniformOptions::DEFAULT });
                kd_presorted: |level| kd(level, KdTreeOptions::DEFAULT, KdPacketWidth::Sixteen, KdMailbox::None);
                kd_binned: |level| kd(level, KdTreeOptions { costs: LARGE_LEAVES, ..KdTreeOptions::FAST }, KdPacketWidth::Sixteen, KdMailbox::Ring);
                kd_lazy: |level| kd(level, KdTreeOptions { layout: KdLayout::Subtrees, lazy_below: 40, ..KdTreeOptions::DEFAULT }, KdPacketWidth::Sixteen, KdMailbox::None);
                kd_two_level: |level| two_level(level, KdMoved::Transform, KdTreeOptions::FAST);
                hierarchy: |level| Box::new(Bvh::with_level(level));
            }
            long {
                listed_small_tiles: |level| listed(level, [8, 1, 1], true, [7, 16, 16, 32]);
                listed_many_slices: |level| listed(level, [16, 2, 64], false, [1, 4096, 33, 2]);
                listed_whole_blocks: |level| listed(level, [8, 8, 7], false, [64, 48, 5, 1]);
                listed_large_tiles: |level| listed(level, [64, 1, 3], true, [5, 16, 7, 9]);
                listed_divided: |level| listed_divided(level, 3);
                spherical_slices: |level| spherical(level, [33, 16, 40, 16], None);
                spherical_clamped: |level| spherical(level, [64, 32, 16, 3], LightClamp::new([-40.0, 20.0, 5.0, 170.0]));
                spherical_cell: |level| spherical(level, [1, 4096, 4096, 32], None);
                uniform_two: |level| uniform(level, UniformOptions { packet: PacketSide::Two, cells_per_triangle: 0.3, macrocell: 1, ..UniformOptions::DEFAULT });
                uniform_four: |level| uniform(level, UniformOptions { packet: PacketSide::Four, insertion: Insertion::Exact, shadow_spread: 1e-4, ..UniformOptions::DEFAULT });
                uniform_eight_dense: |level| uniform(level, UniformOptions { packet: PacketSide::Eight, cells_per_triangle: 60.0, macrocell: 4, ..UniformOptions::DEFAULT });
                uniform_nested_all: |level| uniform(level, UniformOptions { packet: PacketSide::Eight, cells_per_triangle: 0.5, macrocell: 2, nested_above: Some(1), insertion: Insertion::Exact, shadow_spread: 10.0 });
                kd_resorting: |level| kd(level, KdTreeOptions { builder: KdBuilder::Resorting, layout: KdLayout::Subtrees, traversal: KdTraversal::Restart, ..KdTreeOptions::DEFAULT }, KdPacketWidth::Four, KdMailbox::None);
                kd_nested: |level| kd(level, KdTreeOptions { builder: KdBuilder::Nested, clipping: Clipping::Boxes, traversal: KdTraversal::PushDown, ..KdTreeOptions::DEFAULT }, KdPacketWidth::Eight, KdMailbox::Ring);
                kd_in_place: |level| kd(level, KdTreeOptions { builder: KdBuilder::InPlace, traversal: KdTraversal::ShortStack(1), ..KdTreeOptions::DEFAULT }, KdPacketWidth::Sixteen, KdMailbox::Hashed);
                kd_streaming: |level| kd(level, KdTreeOptions { builder: KdBuilder::Streaming, traversal: KdTraversal::ShortStack(3), ..KdTreeOptions::DEFAULT }, KdPacketWidth::Four, KdMailbox::Hashed);
                kd_adaptive: |level| kd(level, KdTreeOptions { builder: KdBuilder::Adaptive, clipping: Clipping::Boxes, layout: KdLayout::Scattered, ..KdTreeOptions::DEFAULT }, KdPacketWidth::Eight, KdMailbox::None);
                kd_spatial: |level| kd(level, KdTreeOptions { builder: KdBuilder::SpatialMedian, ..KdTreeOptions::DEFAULT }, KdPacketWidth::Sixteen, KdMailbox::Hashed);
                kd_spatial_in_turn: |level| kd(level, KdTreeOptions { builder: KdBuilder::SpatialInTurn, lazy_below: 50, ..KdTreeOptions::DEFAULT }, KdPacketWidth::Four, KdMailbox::Ring);
                kd_object: |level| kd(level, KdTreeOptions { builder: KdBuilder::ObjectMedian, clipping: Clipping::Boxes, ..KdTreeOptions::DEFAULT }, KdPacketWidth::Eight, KdMailbox::None);
                kd_object_in_turn: |level| kd(level, KdTreeOptions { builder: KdBuilder::ObjectInTurn, traversal: KdTraversal::PushDown, ..KdTreeOptions::DEFAULT }, KdPacketWidth::Sixteen, KdMailbox::Ring);
                kd_lazy_binned: |level| kd(level, KdTreeOptions { traversal: KdTraversal::ShortStack(3), lazy_below: 1000, ..KdTreeOptions::FAST }, KdPacketWidth::Four, KdMailbox::Hashed);
                kd_lazy_restart: |level| kd(level, KdTreeOptions { traversal: KdTraversal::Restart, lazy_below: 100, ..KdTreeOptions::FAST }, KdPacketWidth::Eight, KdMailbox::Ring);
                kd_from_hierarchy: |level| from_hierarchy(level, KdTreeOptions { lazy_below: 40, ..KdTreeOptions::FAST });
                kd_background: |level| background(level);
                kd_groups: |level| two_level(level, KdMoved::Rebuild, KdTreeOptions { traversal: KdTraversal::ShortStack(2), ..KdTreeOptions::DEFAULT });
                kd_fuzzy: |level| two_level(level, KdMoved::Enclose, KdTreeOptions::FAST);
            }
        }
    };
}

macro_rules! list {
    (short { $($name:ident: $make:expr;)+ } long { $($other:ident: $make_other:expr;)+ }) => {
        /// The table, by name.
        pub const STRUCTURES: &[(&str, Make)] =
            &[$((stringify!($name), $make),)+ $((stringify!($other), $make_other)),+];
    };
}

structures!(list);

/// Costs that make leaves of many triangles.
pub const LARGE_LEAVES: SahCosts = SahCosts { step: 10.0, test: 1.0, ..KdTreeOptions::DEFAULT.costs };

/// Pixels on a side of a sorting tile, sorting tiles on a side of a tracing tile, and slices; cells, points and
/// triangles of a light's blocks, and its slices.
#[must_use]
pub fn listed(level: SimdLevel, camera: [u32; 3], skips_blocks: bool, light: [u32; 4]) -> Box<dyn Structure> {
    let [tile, tiles, slices] = camera;
    let cells = Cells::new(tile, tiles, slices).expect("possible cells");
    Box::new(ListedGrids::with_options(
        level,
        ListedOptions { cells, skips_blocks, ..ListedOptions::DEFAULT },
        light_cells(light),
    ))
}

/// Grids of the paper's form whose camera grid lets one thread search at most `most_triangles` triangles of a tile.
#[must_use]
pub fn listed_divided(level: SimdLevel, most_triangles: u32) -> Box<dyn Structure> {
    let camera = ListedOptions { most_triangles: NonZeroU32::new(most_triangles), ..ListedOptions::DEFAULT };
    Box::new(ListedGrids::with_options(level, camera, ListedLightOptions::DEFAULT))
}

/// A light's grid of angles, with cells as in [`listed`].
#[must_use]
pub fn spherical(level: SimdLevel, light: [u32; 4], clamp: Option<LightClamp>) -> Box<dyn Structure> {
    let mut light = light_cells(light);
    (light.map, light.clamp) = (LightMapping::Spherical, clamp);
    Box::new(ListedGrids::with_options(level, ListedOptions::DEFAULT, light))
}

fn light_cells([side, points, triangles, slices]: [u32; 4]) -> ListedLightOptions {
    let sizes = ListedLightOptions::new(side, points, triangles).expect("possible cells");
    sizes.with_slices(slices).expect("possible slices")
}

/// A uniform grid.
#[must_use]
pub fn uniform(level: SimdLevel, options: UniformOptions) -> Box<dyn Structure> {
    let mut grid = UniformGrid::with_level(level);
    grid.set_options(options).expect("possible options");
    Box::new(grid)
}

/// A kd-tree.
#[must_use]
pub fn kd(level: SimdLevel, options: KdTreeOptions, width: KdPacketWidth, mailbox: KdMailbox) -> Box<dyn Structure> {
    let mut tree = KdTree::with_level(level);
    let packets = KdPacketOptions { width, mailbox };
    tree.set_options(KdTreeOptions { packets, ..options }).expect("possible options");
    Box::new(tree)
}

/// A kd-tree that is built from the first frame's tree.
#[must_use]
pub fn from_hierarchy(level: SimdLevel, options: KdTreeOptions) -> Box<dyn Structure> {
    let mut tree = HierarchyKdTree::with_level(level);
    tree.set_options(options).expect("possible options");
    Box::new(tree)
}

/// A kd-tree that is built beside tracing.
///
/// # Panics
/// If threads can't be started.
#[must_use]
pub fn background(level: SimdLevel) -> Box<dyn Structure> {
    Box::new(BackgroundKdTree::new(1).expect("a thread").at_level(level))
}

/// A kd-tree for each part.
#[must_use]
pub fn two_level(level: SimdLevel, moved: KdMoved, options: KdTreeOptions) -> Box<dyn Structure> {
    let mut trees = TwoLevelKdTree::with_level(level, moved);
    trees.set_options(options).expect("possible options");
    Box::new(trees)
}
