//! Structures with every pair of values of any two options.

use umbrage_rays::{Bvh, DirectGrids};

use crate::support::pairs::{check, covering};

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

#[test]
fn direct_grids_and_the_hierarchy_answer_as_the_predicate_does() {
    check(|row, level| match row.pick("structure", &["direct", "hierarchy"]) {
        "direct" => Box::new(DirectGrids::with_level(level)),
        _ => Box::new(Bvh::with_level(level)),
    });
}
