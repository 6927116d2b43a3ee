//! The kd-tree, with each builder and traversal, against the predicate asked about every triangle.

use glam::{DVec3, Vec3};
use umbrage_rays::predicate::{HitPoint, ShadowRay};
use umbrage_rays::{
    Clipping, Hit, KdBuilder, KdLayout, KdTraversal, KdTree, KdTreeOptions, LightSource, Ray, SahCosts,
    SingleRays as _, Structure as _, Triangles,
};

use crate::support::{self, Mesh, Random, blocked_by_any, blocks, nearest_of_all as nearest, random_ray, scene};

const BUILDERS: [KdBuilder; 8] = [
    KdBuilder::Naive,
    KdBuilder::Resorting,
    KdBuilder::Presorted,
    KdBuilder::Nested,
    KdBuilder::InPlace,
    KdBuilder::Binned,
    KdBuilder::Streaming,
    KdBuilder::Adaptive,
];

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

/// Trees of each builder and layout, some with other costs and some that are built where rays reach them.
fn trees(triangles: Triangles<'_>) -> Vec<KdTree> {
    let mut options = Vec::new();
    for builder in BUILDERS {
        options.push(with(builder));
        let costs = SahCosts { step: 0.1, test: 10.0, empty: 0.3, mailbox: builder == KdBuilder::Binned };
        let clipping = if builder == KdBuilder::Adaptive { Clipping::Triangles } else { Clipping::Boxes };
        options.push(KdTreeOptions { clipping, costs, layout: KdLayout::Subtrees, ..with(builder) });
        options.push(KdTreeOptions { lazy_below: 100, ..with(builder) });
    }
    options.into_iter().map(|options| tree(triangles, options)).collect()
}

/// Compares all trees and traversals with the predicate for each ray; how many rays hit.
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

#[test]
fn random_rays_hit_what_the_predicate_says() {
    let mut random = Random(1);
    let mesh = scene(&mut random);
    for reach in [0.5, 3.0, 40.0, 3e6, 1e15] {
        let rays: Vec<_> = (0..80).map(|_| random_ray(&mut random, reach)).collect();
        let hits = check(&mesh, &rays);
        assert!(hits > 20, "{hits} hits from {reach}");
    }
}

#[test]
fn intervals_are_kept() {
    let mut random = Random(2);
    let mesh = scene(&mut random);
    let rays = support::rays_with_intervals(mesh.triangles(), &mut random, 60);
    assert!(check(&mesh, &rays) > 60);
}

#[test]
fn rays_in_planes_and_along_axes_hit_what_the_predicate_says() {
    let mut random = Random(3);
    let mesh = blocks(&mut random, 80);
    let rays = support::rays_in_planes(&mut random, 150);
    assert!(check(&mesh, &rays) > 300);
}

#[test]
fn triangles_that_end_where_cells_meet_are_hit() {
    let (mesh, rays) = support::corners_of_cells();
    let rays: Vec<_> = rays.into_iter().step_by(7).collect();
    assert!(check(&mesh, &rays) > rays.len() / 2);
}

#[test]
fn grazing_rays_and_shared_edges_hit_what_the_predicate_says() {
    let mut random = Random(4);
    let mesh = scene(&mut random);
    let rays = support::grazing_rays(mesh.triangles(), &mut random, 100);
    assert!(check(&mesh, &rays) > 100);
}

#[test]
fn any_number_of_triangles_is_hit_and_rebuilt() {
    let mut random = Random(5);
    for builder in BUILDERS {
        let mut tree = KdTree::default();
        tree.set_options(with(builder)).expect("possible options");
        assert!(tree.nearest(Triangles::default(), &Ray::new(DVec3::ZERO, DVec3::X), &|_| true).is_none());
        for count in (0..40).chain([300, 0, 5]) {
            let mesh = Mesh::soup(&mut random, count, 0.1);
            tree.build(mesh.triangles());
            tree.check(mesh.triangles()).expect("a valid tree");
            for _ in 0..10 {
                let ray = random_ray(&mut random, 3.0);
                let found = tree.nearest(mesh.triangles(), &ray, &|_| true);
                assert_eq!(found, nearest(mesh.triangles(), &ray, |_| true), "{count} triangles, {ray:?}");
            }
        }
    }
}

#[test]
fn flat_huge_tiny_and_far_scenes_hit_what_the_predicate_says() {
    let mut random = Random(6);
    let mut line = Mesh::default();
    line.push([Vec3::ZERO, Vec3::X, Vec3::X * 2.0]);
    let mut coplanar = Mesh::default();
    coplanar.quad([Vec3::ZERO, Vec3::X, Vec3::new(1.0, 0.0, 1.0), Vec3::Z]);
    let mut slivers = Mesh::default();
    for _ in 0..40 {
        let (a, b) = (random.point(), random.point());
        slivers.push([a, b, a + (b - a) * 0.4 + random.point() * 1e-6]);
    }
    slivers.append(&Mesh::floor(1, 1.0));
    let soup = Mesh::soup(&mut random, 60, 0.05);
    let flat = Mesh::floor(9, 2.0);
    let mut two_sizes = Mesh::soup(&mut random, 100, 0.1).moved(1e-4, Vec3::ZERO);
    two_sizes.append(&Mesh::floor(2, 1000.0));
    let meshes =
        [(&flat, true), (&line, false), (&coplanar, true), (&slivers, true), (&soup, true), (&two_sizes, true)];
    for (mesh, must_hit) in meshes {
        for (scale, offset) in [
            (1.0, Vec3::ZERO),
            (1e-30, Vec3::ZERO),
            (1e30, Vec3::ZERO),
            (1e38, Vec3::ZERO),
            (1.0, Vec3::new(148_376.0, 1234.0, -223_423.0)),
            (1.0, Vec3::new(3e8, 0.0, 0.0)),
        ] {
            let mesh = mesh.moved(scale, offset);
            let rays: Vec<_> = (0..40)
                .map(|_| {
                    let Ray { origin, direction, .. } = random_ray(&mut random, 3.0);
                    let scale = f64::from(scale);
                    Ray::new(origin * scale + offset.as_dvec3(), direction * scale)
                })
                .collect();
            let hits = check(&mesh, &rays);
            // Where coordinates overflow hardly anything is left.
            assert!(hits > 0 || !must_hit || offset.x > 1e8 || scale > 1e37, "{scale} {offset}");
        }
    }
}

#[test]
fn equal_t_goes_to_the_lowest_id() {
    let mut random = Random(9);
    let mut mesh = blocks(&mut random, 30);
    // Each triangle twice more, elsewhere in the order.
    let twins = mesh.clone();
    mesh.append(&twins);
    mesh.indices.reverse();
    mesh.append(&twins);
    let rays: Vec<_> = (0..100)
        .map(|_| {
            let target = (random.point() * 5.0).round().as_dvec3();
            let origin = (random.point() * 12.0).round().as_dvec3();
            Ray::new(origin, target - origin)
        })
        .filter(|ray| ray.direction != DVec3::ZERO)
        .collect();
    assert!(check(&mesh, &rays) > 50);
}

#[test]
fn hits_that_do_not_count_are_passed_through() {
    let mut random = Random(7);
    let mesh = scene(&mut random);
    let counts = |hit: &Hit| hit.triangle.is_multiple_of(3) && hit.barycentric[0] < 0.7;
    let mut tree = tree(mesh.triangles(), KdTreeOptions::DEFAULT);
    let mut hits = 0;
    for step in 0..300 {
        let options = KdTreeOptions { traversal: TRAVERSALS[step % TRAVERSALS.len()], ..KdTreeOptions::DEFAULT };
        tree.set_options(options).expect("possible options");
        let ray = random_ray(&mut random, 3.0);
        let expected = nearest(mesh.triangles(), &ray, counts);
        assert_eq!(tree.nearest(mesh.triangles(), &ray, &counts), expected, "{ray:?}");
        hits += usize::from(expected.is_some());
    }
    assert!(hits > 30, "{hits}");
}

#[test]
fn points_are_shadowed_as_the_predicate_says() {
    let mut random = Random(8);
    let mesh = scene(&mut random);
    let triangles = mesh.triangles();
    let lights = [
        LightSource::Point { position: Vec3::new(3.0, 5.0, 2.0) },
        LightSource::Point { position: Vec3::new(0.1, 0.3, 0.2) },
        LightSource::Directional { direction: Vec3::new(0.3, -0.9, 0.1).normalize() },
        LightSource::Directional { direction: Vec3::NEG_Y },
    ];
    let (mut lit, mut shadowed) = (0, 0);
    for mut tree in trees(triangles) {
        for step in 0..180 {
            let traversal = TRAVERSALS[step % TRAVERSALS.len()];
            tree.set_options(KdTreeOptions { traversal, ..tree.options() }).expect("possible options");
            let ray = random_ray(&mut random, 4.0);
            let Some(seen) = nearest(triangles, &ray, |_| true) else { continue };
            let shadow_ray = ShadowRay::new(&lights[step % 4], HitPoint::new(&ray, seen.t));
            let counts = |id: u32, barycentric: [f32; 2]| !id.is_multiple_of(5) || barycentric[1] < 0.5;
            let expected = blocked_by_any(triangles, &shadow_ray, seen.triangle, counts);
            assert_eq!(tree.blocked(triangles, &shadow_ray, seen.triangle, &counts), expected, "{ray:?}");
            if expected { shadowed += 1 } else { lit += 1 }
        }
    }
    assert!(lit > 50 && shadowed > 50, "{lit} {shadowed}");
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
        for clipping in [Clipping::Boxes, Clipping::Triangles] {
            for mailbox in [false, true] {
                let costs = SahCosts { mailbox, ..KdTreeOptions::DEFAULT.costs };
                let [one, nested, in_place] = [KdBuilder::Presorted, KdBuilder::Nested, KdBuilder::InPlace]
                    .map(|builder| tree(mesh.triangles(), KdTreeOptions { clipping, costs, ..with(builder) }));
                assert!(nested.is_same_as(&one), "{clipping:?} {:?} {:?}", nested.counts(), one.counts());
                assert!(in_place.is_same_as(&one), "{clipping:?} {:?} {:?}", in_place.counts(), one.counts());
            }
        }
    }
}

#[test]
fn trees_do_not_depend_on_threads_or_on_what_was_built_before() {
    let mut random = Random(14);
    // Large enough for clusters and for nodes whose children are built on two threads.
    let mut mesh = Mesh::bumpy_ball(Vec3::ZERO, 1.0, 90);
    mesh.append(&Mesh::soup(&mut random, 2000, 0.01));
    for builder in BUILDERS.into_iter().filter(|&builder| builder != KdBuilder::Naive) {
        let first = tree(mesh.triangles(), with(builder));
        let mut again = tree(Mesh::soup(&mut random, 500, 0.1).triangles(), with(builder));
        for threads in [1, 2, 3, 7] {
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
    let [first, second] = [KdLayout::DepthFirst, KdLayout::Subtrees]
        .map(|layout| tree(mesh.triangles(), KdTreeOptions { layout, ..KdTreeOptions::DEFAULT }));
    assert_eq!(first.counts(), second.counts());
    assert!(!first.is_same_as(&second));
}

#[test]
fn many_triangles_in_one_place_do_not_fill_memory() {
    const COUNT: usize = 100_000;
    let mut random = Random(16);
    let mut equal = Mesh::default();
    equal.push([Vec3::ZERO, Vec3::new(1.0, 2.0, 0.5), Vec3::new(-1.0, 0.5, 3.0)]);
    equal.indices = vec![equal.indices[0]; COUNT];
    let mut large = Mesh::default();
    (0..COUNT / 10).for_each(|_| large.push([random.point(), random.point(), random.point()]));
    for builder in BUILDERS.into_iter().filter(|&builder| builder != KdBuilder::Naive) {
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
    // The whole has an area of 18, the rest without one of the squares too, and the flat leaves of two each.
    let SahCosts { step, test, .. } = tree.options().costs;
    assert_eq!(counts.sah_cost, 2.0 * step + 2.0 * 2.0 * test * 2.0 / 18.0);
}

#[test]
fn omitted_triangles_are_named() {
    let mesh = scene(&mut Random(18));
    let tree = tree(mesh.triangles(), KdTreeOptions::DEFAULT);
    assert_eq!(tree.omitted(), &mesh.triangles().omitted());
    assert!(tree.omitted().total() >= 3);
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
