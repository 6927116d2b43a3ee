//! Grids in their paper's form: every pair of values of any two options, and scenes of every magnitude.

use std::num::NonZeroU32;

use umbrage_papers::{Cells, LightMapping, ListedGrids, ListedLightOptions, ListedOptions};
use umbrage_rays::{SimdLevel, Structure};

use crate::support::pairs::{Row, check};
use crate::support::scales::{Structures, check_every_scale, check_far_parts};

fn of_row(row: &mut Row<'_>, level: SimdLevel) -> Box<dyn Structure> {
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

fn structures() -> Structures {
    let mut spherical = ListedLightOptions::DEFAULT;
    spherical.map = LightMapping::Spherical;
    let spherical = ListedGrids::with_options(SimdLevel::default(), ListedOptions::DEFAULT, spherical);
    vec![("listed grids", Box::new(ListedGrids::default())), ("spherical grids", Box::new(spherical))]
}

#[test]
fn grids_of_all_pairs_of_options_answer_as_the_predicate_does() {
    check(of_row);
}

#[test]
fn scenes_of_every_scale_are_seen_and_lit_as_the_predicate_says() {
    check_every_scale(structures());
}

#[test]
fn scenes_some_of_which_is_far_away_are_seen_and_lit_as_the_predicate_says() {
    check_far_parts(structures());
}
