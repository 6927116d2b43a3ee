//! Structures with every pair of values of any two options.

use umbrage_rays::{
    BackgroundKdTree, Bvh, Choice as _, Clipping, DirectGrids, HierarchyKdTree, KdBuilder, KdLayout, KdMailbox,
    KdMoved, KdPacketOptions, KdPacketWidth, KdTraversal, KdTree, KdTreeOptions, RebuildPolicy, SahCosts, SimdLevel,
    Structure, TwoLevelKdTree,
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

fn kd_tree(row: &mut Row<'_>, level: SimdLevel) -> Box<dyn Structure> {
    let entries = KdTraversal::MOST_ENTRIES;
    let traversals = [KdTraversal::Stack, KdTraversal::Restart, KdTraversal::PushDown];
    let stacks = [1, 3, entries].map(KdTraversal::ShortStack);
    let builders: Vec<KdBuilder> = KdBuilder::all().collect();
    let options = KdTreeOptions {
        builder: row.pick("builder", &builders),
        clipping: row.pick("clipping", &[Clipping::Boxes, Clipping::Triangles]),
        layout: row.pick("layout", &[KdLayout::DepthFirst, KdLayout::Subtrees, KdLayout::Scattered]),
        traversal: row.pick("traversal", &[traversals, stacks].concat()),
        packets: KdPacketOptions {
            width: row.pick("width", &[KdPacketWidth::Four, KdPacketWidth::Eight, KdPacketWidth::Sixteen]),
            mailbox: row.pick("mailbox", &[KdMailbox::None, KdMailbox::Ring, KdMailbox::Hashed]),
        },
        costs: SahCosts {
            mailbox: row.pick("mailbox costs", &[false, true]),
            failures: row.pick("failures", &[0, 2, SahCosts::MOST_FAILURES]),
            ..KdTreeOptions::DEFAULT.costs
        },
        lazy_below: row.pick("lazy below", &[0, 20, 200]),
    };
    let form = row.pick("rebuild", &["whole", "transform", "rebuild", "enclose", "hierarchy", "background", "never"]);
    let two_level = |moved| {
        let mut trees = TwoLevelKdTree::with_level(level, moved);
        trees.set_options(options).expect("possible options");
        Box::new(trees)
    };
    match form {
        "transform" => two_level(KdMoved::Transform),
        "rebuild" => two_level(KdMoved::Rebuild),
        "enclose" => two_level(KdMoved::Enclose),
        "hierarchy" => {
            let mut tree = HierarchyKdTree::with_level(level);
            tree.set_options(options).expect("possible options");
            Box::new(tree)
        }
        "background" | "never" => {
            let mut tree = BackgroundKdTree::new(1).expect("a thread").at_level(level);
            tree.set_options(options).expect("possible options");
            let most = if form == "never" { f64::INFINITY } else { 1.0 };
            tree.set_policy(RebuildPolicy { rebuild_above: most, wait_above: f64::INFINITY }).expect("a policy");
            Box::new(tree)
        }
        _ => {
            let mut tree = KdTree::with_level(level);
            tree.set_options(options).expect("possible options");
            Box::new(tree)
        }
    }
}

#[test]
fn kd_trees_of_all_pairs_of_options_answer_as_the_predicate_does() {
    check(kd_tree);
}

#[test]
fn direct_grids_and_the_hierarchy_answer_as_the_predicate_does() {
    check(|row, level| match row.pick("structure", &["direct", "hierarchy"]) {
        "direct" => Box::new(DirectGrids::with_level(level)),
        _ => Box::new(Bvh::with_level(level)),
    });
}
