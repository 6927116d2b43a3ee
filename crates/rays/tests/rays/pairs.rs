//! Structures with every pair of values of any two options.

use std::num::NonZeroU32;

use umbrage_rays::{
    Bvh, Cells, Choice as _, DirectGrids, Insertion, LightMapping, ListedGrids, ListedLightOptions, ListedOptions,
    PacketSide, SimdLevel, Structure, UniformGrid, UniformOptions,
};

use crate::support::pairs::{Row, check, covering};

#[test]
fn every_pair_of_values_is_in_some_row() {
    for counts in [&[3, 3, 3][..], &[12, 7, 6, 3, 3, 3, 3, 3, 2, 2, 2], &[1, 5], &[2, 2]] {
        let rows = covering(counts);
        for (a, b) in (0..counts.len()).flat_map(|a| (0..a).map(move |b| (a, b))) {
            for (x, y) in (0..counts[a]).flat_map(|x| (0..counts[b]).map(move |y| (x, y))) {
                assert!(rows.iter().any(|row| row[a] == x && row[b] == y), "{counts:?}: {x} and {y} of {a} and {b}");
            }
        }
        let mut sorted = counts.to_vec();
        sorted.sort_unstable_by_key(|count| usize::MAX - count);
        // No fewer rows than pairs of the two largest, and hardly more.
        let least = sorted[0] * sorted[1];
        assert!((least..=least + least / 4 + 8).contains(&rows.len()), "{counts:?}: {} rows", rows.len());
    }
}

fn uniform(row: &mut Row<'_>, level: SimdLevel) -> Box<dyn Structure> {
    let packets: Vec<PacketSide> = PacketSide::all().collect();
    let options = UniformOptions {
        cells_per_triangle: row.pick("cells", &[0.3, 6.0, 60.0]),
        macrocell: row.pick("macrocell", &[1, 4, 6]),
        insertion: row.pick("insertion", &[Insertion::Boxes, Insertion::Exact]),
        packet: row.pick("packet", &packets),
        nested_above: row.pick("nested above", &[None, Some(1), Some(8)]),
        shadow_spread: row.pick("spread", &[1e-4, 0.05, 10.0]),
    };
    let mut grid = UniformGrid::with_level(level);
    grid.set_options(options).expect("possible options");
    Box::new(grid)
}

fn listed(row: &mut Row<'_>, level: SimdLevel) -> Box<dyn Structure> {
    let [tile, tiles, slices] = row.pick("cells", &[[16, 4, 8], [8, 1, 1], [8, 8, 7], [64, 1, 3]]);
    let camera = ListedOptions {
        cells: Cells::new(tile, tiles, slices).expect("possible cells"),
        skips_blocks: row.pick("skips blocks", &[true, false]),
        most_triangles: NonZeroU32::new(row.pick("most triangles", &[0, 3])),
    };
    let side = row.pick("side", &[1, 33, 192]);
    let points = row.pick("points", &[16, 256, 4096]);
    let light = ListedLightOptions::new(side, points, row.pick("triangles", &[5, 64, 512])).expect("possible cells");
    let mut light = light.with_slices(row.pick("slices", &[1, 3, 16])).expect("possible slices");
    light.map = row.pick("map", &[LightMapping::Faces, LightMapping::Spherical]);
    Box::new(ListedGrids::with_options(level, camera, light))
}

#[test]
fn uniform_grids_of_all_pairs_of_options_answer_as_the_predicate_does() {
    check(uniform);
}

#[test]
fn listed_grids_of_all_pairs_of_options_answer_as_the_predicate_does() {
    check(listed);
}

#[test]
fn direct_grids_and_the_hierarchy_answer_as_the_predicate_does() {
    check(|row, level| match row.pick("structure", &["direct", "hierarchy"]) {
        "direct" => Box::new(DirectGrids::with_level(level)),
        _ => Box::new(Bvh::with_level(level)),
    });
}
