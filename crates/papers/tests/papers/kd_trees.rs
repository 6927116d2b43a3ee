//! kd-trees with every pair of values of any two options, in scenes of every magnitude, and in scenes that one far vertex
//! stretches, or that one triangle covers: these cost as much as ordinary ones.

use std::ops::ControlFlow;

use umbrage_papers::{
    BackgroundKdTree, Clipping, HierarchyKdTree, KdBuilder, KdLayout, KdMailbox, KdMoved, KdPacketOptions,
    KdPacketWidth, KdTraversal, KdTree, KdTreeOptions, RebuildPolicy, SahCosts, TwoLevelKdTree, Visit,
};
use umbrage_rays::predicate::hit;
use umbrage_rays::{Choice as _, Hit, Ray, SimdLevel, Structure};

use crate::support::far::{check_answers, damaged, ordinary, rays};
use crate::support::pairs::{Row, check};
use crate::support::scales::{Structures, check_every_scale, check_far_parts};
use crate::support::{Mesh, nearest_of_all};

fn of_row(row: &mut Row<'_>, level: SimdLevel) -> Box<dyn Structure> {
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

fn structures() -> Structures {
    let mut binned = KdTree::default();
    binned.set_options(KdTreeOptions::FAST).expect("possible options");
    let two_level = TwoLevelKdTree::with_level(SimdLevel::default(), KdMoved::Transform);
    vec![
        ("kd-tree", Box::new(KdTree::default())),
        ("binned kd-tree", Box::new(binned)),
        ("two-level kd-tree", Box::new(two_level)),
    ]
}

#[test]
fn trees_of_all_pairs_of_options_answer_as_the_predicate_does() {
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

/// Counts the triangles that rays are tested against.
fn tests(structure: &impl Visit, mesh: &Mesh, rays: &[Ray]) -> usize {
    let triangles = mesh.triangles();
    let mut count = 0;
    for ray in rays {
        let _ = structure.visit(triangles, ray, |id, t_max| {
            count += 1;
            if let Some(hit) = hit(ray, triangles, id) {
                *t_max = t_max.min(hit.t);
            }
            ControlFlow::Continue(())
        });
    }
    count
}

fn tree(builder: KdBuilder, mesh: &Mesh) -> KdTree {
    let mut tree = KdTree::default();
    tree.set_options(KdTreeOptions { builder, ..KdTreeOptions::FAST }).expect("possible options");
    tree.build(mesh.triangles());
    tree.check(mesh.triangles()).expect("a valid tree");
    tree
}

#[test]
fn rays_are_tested_against_hardly_more_triangles() {
    let (rays, ordinary) = (rays(), ordinary());
    use KdBuilder::{Naive, SpatialInTurn, SpatialMedian};
    // Planes in the middle of space take a level for each power of two before they come near the other triangles.
    let builders = KdBuilder::all().filter(|builder| ![Naive, SpatialMedian, SpatialInTurn].contains(builder));
    for builder in builders {
        let usual = tests(&tree(builder, &ordinary), &ordinary, &rays);
        for (name, mesh) in damaged() {
            let count = tests(&tree(builder, &mesh), &mesh, &rays);
            // Far triangles are in many leaves: those of a vertex are six.
            let most = 4 * usual + 30 * 6 * rays.len();
            assert!(count < most, "{builder}: {name}: {count} tests instead of {usual}, of {}", mesh.indices.len());
        }
    }
}

#[test]
fn answers_are_the_predicates() {
    let mut tree = KdTree::default();
    tree.set_options(KdTreeOptions::FAST).expect("possible options");
    check_answers(tree);
}

#[test]
fn packets_hit_the_triangles_of_the_predicate() {
    let rays = rays();
    for (name, mesh) in damaged() {
        let triangles = mesh.triangles();
        let mut packet = vec![None; rays.len()];
        tree(KdBuilder::Binned, &mesh).nearest_of_packet(triangles, &rays, |_| true, &mut packet);
        let expected: Vec<Option<Hit>> = rays.iter().map(|ray| nearest_of_all(triangles, ray, |_| true)).collect();
        assert_eq!(packet, expected, "{name}");
    }
}
