//! The kd-tree, with each builder and traversal, against the predicate asked about every triangle.

use glam::{DVec3, Vec3};
use umbrage_papers::{Clipping, KdBuilder, KdLayout, KdTraversal, KdTree, KdTreeOptions, SahCosts};
use umbrage_rays::{Choice as _, Hit, Ray, SingleRays as _, Structure as _, Triangles};

use crate::support::{self, Mesh, Random, blocks, nearest_of_all as nearest, random_ray, scene};

const EXACT: [KdBuilder; 5] =
    [KdBuilder::Naive, KdBuilder::Resorting, KdBuilder::Presorted, KdBuilder::Nested, KdBuilder::InPlace];

const TRAVERSALS: [KdTraversal; 6] = [
    KdTraversal::Stack,
    KdTraversal::Restart,
    KdTraversal::PushDown,
    KdTraversal::ShortStack(1),
    KdTraversal::ShortStack(3),
    KdTraversal::ShortStack(KdTraversal::MOST_ENTRIES),
];

fn tree(triangles: Triangles<'_>, options: KdTreeOptions) -> KdTree {
    let mut tree = KdTree::default();
    tree.set_options(options).expect("possible options");
    tree.build(triangles);
    tree.check(triangles).unwrap_or_else(|broken| panic!("{options:?}: {broken}"));
    tree
}

fn with(builder: KdBuilder) -> KdTreeOptions {
    KdTreeOptions { builder, ..KdTreeOptions::DEFAULT }
}

/// Trees of each builder and layout, some with other costs and some that are built when rays reach them.
fn trees(triangles: Triangles<'_>) -> Vec<KdTree> {
    let mut options = Vec::new();
    for builder in KdBuilder::all() {
        options.push(with(builder));
        let costs = SahCosts { step: 0.1, test: 10.0, empty: 0.3, mailbox: builder == KdBuilder::Binned, failures: 1 };
        let clipping = if builder == KdBuilder::Adaptive { Clipping::Triangles } else { Clipping::Boxes };
        let layout = if builder == KdBuilder::Adaptive { KdLayout::Scattered } else { KdLayout::Subtrees };
        options.push(KdTreeOptions { clipping, costs, layout, ..with(builder) });
        options.push(KdTreeOptions { lazy_below: 100, ..with(builder) });
    }
    options.into_iter().map(|options| tree(triangles, options)).collect()
}

/// Compares all trees and traversals with the predicate for each ray. Returns the number of hits.
fn check(mesh: &Mesh, rays: &[Ray]) -> usize {
    let triangles = mesh.triangles();
    let expected: Vec<_> = rays.iter().map(|ray| nearest(triangles, ray, |_| true)).collect();
    let bits = |hit: &Option<Hit>| hit.map(|hit| (hit.triangle, hit.t.to_bits(), hit.barycentric));
    for mut tree in trees(triangles) {
        for traversal in TRAVERSALS {
            let options = KdTreeOptions { traversal, ..tree.options() };
            tree.set_options(options).expect("possible options");
            for (ray, expected) in rays.iter().zip(&expected) {
                let found = tree.nearest(triangles, ray, &|_| true);
                assert_eq!(bits(&found), bits(expected), "{ray:?} through {tree:?}, {options:?}");
            }
        }
    }
    expected.iter().flatten().count()
}

/// Naive builds take too long for the conformance suite.
#[test]
fn naive_trees_of_any_number_of_triangles_are_whole() {
    let mut random = Random(5);
    let mut tree = KdTree::default();
    tree.set_options(with(KdBuilder::Naive)).expect("possible options");
    for count in (0..40).chain([200, 0, 5]) {
        let mesh = Mesh::soup(&mut random, count, 0.1);
        tree.build(mesh.triangles());
        tree.check(mesh.triangles()).expect("a valid tree");
        assert_eq!(tree.omitted(), &mesh.triangles().omitted());
        let ray = random_ray(&mut random, 3.0);
        assert_eq!(tree.nearest(mesh.triangles(), &ray, &|_| true), nearest(mesh.triangles(), &ray, |_| true));
    }
}

#[test]
fn exact_builders_make_the_same_tree() {
    let mut random = Random(12);
    for mesh in [scene(&mut random), blocks(&mut random, 60), Mesh::soup(&mut random, 250, 0.1)] {
        for clipping in [Clipping::Boxes, Clipping::Triangles] {
            for mailbox in [false, true] {
                let costs = SahCosts { mailbox, ..KdTreeOptions::DEFAULT.costs };
                let [naive, others @ ..] =
                    EXACT.map(|builder| tree(mesh.triangles(), KdTreeOptions { clipping, costs, ..with(builder) }));
                assert!(others.iter().all(|other| other.is_same_as(&naive)), "{clipping:?}");
                assert!(naive.counts().leaves > 50, "{:?}", naive.counts());
            }
        }
    }
}

/// Nodes are shared by threads from 2¹⁴ triangles on.
#[test]
fn threads_that_share_nodes_make_the_tree_of_one() {
    let mut random = Random(13);
    let mut curved = Mesh::bumpy_ball(Vec3::ZERO, 1.0, 90);
    curved.append(&Mesh::soup(&mut random, 2000, 0.01));
    curved.positions[5].x = f32::NAN;
    let mut flat = Mesh::floor(100, 4.0);
    flat.append(&blocks(&mut random, 500));
    flat.append(&Mesh::floor(70, 4.0).moved(1.0, Vec3::Y));
    for mesh in [&curved, &flat] {
        for (clipping, mailbox) in [(Clipping::Boxes, false), (Clipping::Triangles, true)] {
            let costs = SahCosts { mailbox, ..KdTreeOptions::DEFAULT.costs };
            let [one, nested, in_place] = [KdBuilder::Presorted, KdBuilder::Nested, KdBuilder::InPlace]
                .map(|builder| tree(mesh.triangles(), KdTreeOptions { clipping, costs, ..with(builder) }));
            assert!(nested.is_same_as(&one), "{clipping:?} {:?} {:?}", nested.counts(), one.counts());
            assert!(in_place.is_same_as(&one), "{clipping:?} {:?} {:?}", in_place.counts(), one.counts());
        }
    }
}

#[test]
fn trees_do_not_depend_on_threads_or_on_what_was_built_before() {
    let mut random = Random(14);
    // Large enough for clusters and for nodes whose children are built on two threads.
    let mut mesh = Mesh::bumpy_ball(Vec3::ZERO, 1.0, 90);
    mesh.append(&Mesh::soup(&mut random, 2000, 0.01));
    for builder in KdBuilder::all().filter(|&builder| builder != KdBuilder::Naive) {
        let first = tree(mesh.triangles(), with(builder));
        let mut again = tree(Mesh::soup(&mut random, 500, 0.1).triangles(), with(builder));
        for threads in [1, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            pool.install(|| again.build(mesh.triangles()));
            assert!(again.is_same_as(&first), "{builder:?} on {threads} threads");
        }
    }
}

#[test]
fn layouts_hold_the_same_tree() {
    let mut random = Random(15);
    let mesh = Mesh::soup(&mut random, 600, 0.05);
    let [first, second, third] = [KdLayout::DepthFirst, KdLayout::Subtrees, KdLayout::Scattered]
        .map(|layout| tree(mesh.triangles(), KdTreeOptions { layout, ..KdTreeOptions::DEFAULT }));
    assert_eq!(first.counts(), second.counts());
    assert_eq!(first.counts(), third.counts());
    assert!(!first.is_same_as(&second) && !second.is_same_as(&third));
}

#[test]
fn many_triangles_in_one_place_do_not_fill_memory() {
    const COUNT: usize = 40_000;
    let mut random = Random(16);
    let mut equal = Mesh::default();
    equal.push([Vec3::ZERO, Vec3::new(1.0, 2.0, 0.5), Vec3::new(-1.0, 0.5, 3.0)]);
    equal.indices = vec![equal.indices[0]; COUNT];
    let mut large = Mesh::default();
    (0..COUNT / 10).for_each(|_| large.push([random.point(), random.point(), random.point()]));
    for builder in KdBuilder::all().filter(|&builder| builder != KdBuilder::Naive) {
        for mesh in [&equal, &large] {
            let tree = tree(mesh.triangles(), with(builder));
            let per_triangle = tree.bytes().triangles / mesh.indices.len();
            assert!(per_triangle < 2000, "{builder:?}: {per_triangle} bytes a triangle, {:?}", tree.counts());
            let ray = Ray::new(DVec3::new(0.1, 0.9, -5.0), DVec3::new(-0.01, 0.0, 1.0));
            assert_eq!(
                tree.nearest(mesh.triangles(), &ray, &|_| true),
                nearest(mesh.triangles(), &ray, |_| true),
                "{builder:?}"
            );
        }
    }
}

#[test]
fn clipping_makes_fewer_references() {
    let mesh = Mesh::soup(&mut Random(17), 1000, 0.3);
    let [boxes, triangles] = [Clipping::Boxes, Clipping::Triangles]
        .map(|clipping| tree(mesh.triangles(), KdTreeOptions { clipping, ..KdTreeOptions::DEFAULT }).counts());
    assert!(triangles.sah_cost < boxes.sah_cost * 0.95, "{triangles:?} {boxes:?}");
}

#[test]
fn costs_are_those_of_the_formula() {
    // Two squares at the ends of a box of 1 × 1 × 4: leaves cut them off.
    let mut mesh = Mesh::default();
    for z in [0.0, 4.0] {
        let corner = Vec3::Z * z;
        mesh.quad([corner, corner + Vec3::X, corner + Vec3::X + Vec3::Y, corner + Vec3::Y]);
    }
    let tree = tree(mesh.triangles(), KdTreeOptions::DEFAULT);
    let counts = tree.counts();
    assert_eq!((counts.nodes, counts.leaves, counts.empty_leaves, counts.references, counts.depth), (5, 3, 1, 4, 2));
    // The whole has an area of 18, the rest without one of the squares as well, and the flat leaves have 2 each.
    let SahCosts { step, test, .. } = tree.options().costs;
    assert_eq!(counts.sah_cost, 2.0 * step + 2.0 * 2.0 * test * 2.0 / 18.0);
}

#[test]
fn planes_may_fail_as_often_as_is_said() {
    let mesh = Mesh::soup(&mut Random(18), 1000, 0.3);
    let [never, twice, always] = [0, 2, SahCosts::MOST_FAILURES].map(|failures| {
        let costs = SahCosts { step: 10.0, test: 1.0, failures, ..KdTreeOptions::DEFAULT.costs };
        tree(mesh.triangles(), KdTreeOptions { costs, ..KdTreeOptions::DEFAULT }).counts()
    });
    assert!(never.leaves < twice.leaves && twice.leaves < always.leaves, "{never:?} {twice:?} {always:?}");
    assert!(never.depth <= twice.depth && twice.depth <= always.depth, "{never:?} {twice:?} {always:?}");
}

#[test]
fn medians_halve_cells_or_triangles() {
    use KdBuilder::{ObjectInTurn, ObjectMedian, SpatialInTurn, SpatialMedian};
    // Small triangles at the points of a lattice: columns are evenly spaced, or each twice as far as the one before.
    let lattice = |column: fn(i32) -> f32| {
        let mut mesh = Mesh::default();
        for index in 0..64 {
            let at = Vec3::new(column(index % 4), (index / 4 % 4) as f32, (index / 16) as f32);
            mesh.push([at, at + 0.1 * Vec3::X, at + 0.1 * Vec3::Y + 0.1 * Vec3::Z]);
        }
        mesh
    };
    let shape = |mesh: &Mesh, builder| {
        let counts = tree(mesh.triangles(), with(builder)).counts();
        (counts.depth, counts.leaves, counts.references)
    };
    let (even, uneven) = (lattice(|column| column as f32), lattice(|column| 9.0 * (2.0_f32).powi(column)));
    for builder in [SpatialMedian, SpatialInTurn, ObjectMedian, ObjectInTurn] {
        assert_eq!(shape(&even, builder), (4, 16, 64), "{builder}");
    }
    assert_eq!(shape(&uneven, ObjectInTurn), (4, 16, 64));
    assert!(shape(&uneven, SpatialInTurn).0 > 4 && shape(&uneven, SpatialMedian).0 > 4);
}

#[test]
fn impossible_options_are_refused() {
    let mut tree = KdTree::default();
    let costs = KdTreeOptions::DEFAULT.costs;
    for costs in [
        SahCosts { step: -1.0, ..costs },
        SahCosts { test: 0.0, ..costs },
        SahCosts { test: f64::INFINITY, ..costs },
        SahCosts { empty: 1.5, ..costs },
        SahCosts { empty: f64::NAN, ..costs },
        SahCosts { failures: SahCosts::MOST_FAILURES + 1, ..costs },
    ] {
        let options = KdTreeOptions { costs, ..KdTreeOptions::DEFAULT };
        assert!(tree.set_options(options).unwrap_err().to_string().contains("a kd-tree can't have"));
    }
    assert!(
        tree.set_options(KdTreeOptions { lazy_below: KdTreeOptions::MOST_LAZY + 1, ..with(KdBuilder::Naive) }).is_err()
    );
    for entries in [0, KdTraversal::MOST_ENTRIES + 1] {
        let traversal = KdTraversal::ShortStack(entries);
        assert!(tree.set_options(KdTreeOptions { traversal, ..KdTreeOptions::DEFAULT }).is_err());
    }
}

#[cfg(feature = "statistics")]
#[test]
fn short_stacks_visit_hardly_more_than_a_whole_one() {
    let mut random = Random(19);
    let mut mesh = Mesh::bumpy_ball(Vec3::ZERO, 1.0, 60);
    mesh.append(&Mesh::soup(&mut random, 3000, 0.01));
    let rays: Vec<_> = (0..1000).map(|_| random_ray(&mut random, 3.0)).collect();
    let mut tree = tree(mesh.triangles(), KdTreeOptions::DEFAULT);
    let mut visits = |traversal| {
        tree.set_options(KdTreeOptions { traversal, ..KdTreeOptions::DEFAULT }).expect("possible options");
        let hits = rays.iter().filter(|ray| tree.nearest(mesh.triangles(), ray, &|_| true).is_some()).count();
        assert!(hits > 100);
        tree.take_visits()
    };
    let [stack, restart, push_down, one, four, whole] = [
        KdTraversal::Stack,
        KdTraversal::Restart,
        KdTraversal::PushDown,
        KdTraversal::ShortStack(1),
        KdTraversal::ShortStack(4),
        KdTraversal::ShortStack(KdTraversal::MOST_ENTRIES),
    ]
    .map(&mut visits);
    assert!(stack.nodes > 10_000 && stack.leaves > 2000 && stack.tests > 500 && stack.restarts == 0, "{stack:?}");
    // The same leaves and tests, on longer ways.
    for other in [restart, push_down, one, four, whole] {
        assert!(other.leaves == stack.leaves && other.tests == stack.tests && other.rays == stack.rays, "{other:?}");
    }
    assert!(restart.nodes > push_down.nodes && push_down.nodes > one.nodes && one.nodes > four.nodes);
    assert!(four.nodes as f64 <= stack.nodes as f64 * 1.03, "{four:?} {stack:?}");
    assert!(whole.nodes == stack.nodes && whole.restarts == 0, "{whole:?} {stack:?}");
}

/// Tests that take long, which `cargo run -p ci` runs with `--all` alone.
mod long {
    use super::*;

    /// The conformance suite has each builder with one traversal; here is each with all of them.
    #[test]
    fn all_builders_and_traversals_hit_what_the_predicate_says() {
        let mut random = Random(1);
        let mesh = scene(&mut random);
        let mut rays: Vec<_> = [0.5, 3.0, 1e15]
            .into_iter()
            .flat_map(|reach| [reach; 40])
            .map(|reach| random_ray(&mut random, reach))
            .collect();
        rays.extend(support::rays_with_intervals(mesh.triangles(), &mut random, 20));
        rays.extend(support::grazing_rays(mesh.triangles(), &mut random, 30));
        assert!(check(&mesh, &rays) > 100);
        let mesh = blocks(&mut random, 80);
        assert!(check(&mesh, &support::rays_in_planes(&mut random, 60)) > 100);
        let (mesh, rays) = support::corners_of_cells();
        let rays: Vec<_> = rays.into_iter().step_by(23).collect();
        assert!(check(&mesh, &rays) > rays.len() / 2);
        // Hardly any triangles are left if coordinates overflow.
        let overflowing = Mesh::soup(&mut random, 60, 0.05).moved(1e38, Vec3::ZERO);
        let rays: Vec<_> = (0..40).map(|_| random_ray(&mut random, 3.0)).collect();
        check(
            &overflowing,
            &rays.iter().map(|ray| Ray::new(ray.origin * 1e38, ray.direction * 1e38)).collect::<Vec<_>>(),
        );
    }
}
