//! Scenes of every magnitude that coordinates may have, through the papers' structures, against the predicate asked about
//! every triangle.

use umbrage_papers::{UniformGrid, UniformOptions};

use crate::support::scales::{Structures, check_every_scale, check_far_parts};

/// Every structure, by its name.
fn structures() -> Structures {
    let mut nested = UniformGrid::default();
    let options = UniformOptions { cells_per_triangle: 0.3, nested_above: Some(4), ..UniformOptions::DEFAULT };
    nested.set_options(options).expect("possible options");
    vec![("uniform grid", Box::new(UniformGrid::default())), ("nested grid", Box::new(nested))]
}

#[test]
fn scenes_of_every_scale_are_seen_and_lit_as_the_predicate_says() {
    check_every_scale(structures());
}

#[test]
fn scenes_some_of_which_is_far_away_are_seen_and_lit_as_the_predicate_says() {
    check_far_parts(structures());
}
