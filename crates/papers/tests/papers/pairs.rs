//! The papers' structures with every pair of values of any two options.

use umbrage_papers::{Insertion, PacketSide, UniformGrid, UniformOptions};
use umbrage_rays::{Choice as _, SimdLevel, Structure};

use crate::support::pairs::{Row, check};

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

#[test]
fn uniform_grids_of_all_pairs_of_options_answer_as_the_predicate_does() {
    check(uniform);
}
