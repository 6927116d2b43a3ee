//! kd-trees that are built from hierarchies, against the predicate asked about every triangle.

use glam::{DVec3, Vec3};
use umbrage_papers::{Clipping, HierarchyKdTree, KdBuilder, KdLayout, KdTree, KdTreeOptions};
use umbrage_rays::predicate::hit;
use umbrage_rays::{Hit, Ray, SingleRays as _, Structure as _, Triangles};

use crate::support::{self, Mesh, Random, blocks, is_usable};

fn scene(random: &mut Random) -> Mesh {
    let mut mesh = Mesh::soup(random, 300, 0.02);
    mesh.append(&Mesh::bumpy_ball(Vec3::ZERO, 1.0, 30));
    mesh.append(&Mesh::floor(15, 3.0));
    mesh.positions[5].x = f32::NAN;
    mesh.indices.push([0, 1, u32::MAX]);
    mesh.indices.push([7, 7, 8]);
    mesh
}

/// Scenes for a first frame: the same positions, and unrelated ones.
fn first_frames(mesh: &Mesh) -> [Mesh; 2] {
    let mut random = Random(50);
    let mut elsewhere = mesh.clone();
    elsewhere.positions.iter_mut().for_each(|position| *position = random.point());
    [mesh.clone(), elsewhere]
}

/// Builds a tree from the groups of the first frame.
fn build(triangles: Triangles<'_>, first: &Mesh, options: KdTreeOptions) -> HierarchyKdTree {
    let mut tree = HierarchyKdTree::default();
    tree.set_options(options).expect("possible options");
    tree.build(Triangles { positions: &first.positions, ..triangles });
    tree.build(triangles);
    tree.tree().check(triangles).unwrap_or_else(|broken| panic!("{options:?}: {broken}"));
    tree
}

fn options() -> Vec<KdTreeOptions> {
    let with = |builder| KdTreeOptions { builder, ..KdTreeOptions::DEFAULT };
    vec![
        KdTreeOptions::DEFAULT,
        with(KdBuilder::Binned),
        KdTreeOptions { clipping: Clipping::Boxes, layout: KdLayout::Subtrees, ..with(KdBuilder::Adaptive) },
        KdTreeOptions { lazy_below: 100, ..with(KdBuilder::Presorted) },
        KdTreeOptions { lazy_below: 400, ..with(KdBuilder::Binned) },
    ]
}

fn nearest(triangles: Triangles<'_>, ray: &Ray) -> Option<Hit> {
    let hits = (0..triangles.len() as u32).filter(|&id| is_usable(triangles, id));
    let hits = hits.filter_map(|id| hit(ray, triangles, id));
    hits.min_by(|a, b| (a.t, a.triangle).partial_cmp(&(b.t, b.triangle)).expect("no t is NaN"))
}

/// Compares trees of all hierarchies and options with the predicate. Returns the number of hits.
fn check(mesh: &Mesh, first_frames: &[Mesh], rays: &[Ray]) -> usize {
    let triangles = mesh.triangles();
    let expected: Vec<_> = rays.iter().map(|ray| nearest(triangles, ray)).collect();
    for first in first_frames {
        for options in options() {
            let tree = build(triangles, first, options);
            let tree = tree.tree();
            assert_eq!(tree.omitted(), &triangles.omitted());
            for (ray, expected) in rays.iter().zip(&expected) {
                assert_eq!(tree.nearest(triangles, ray, &|_| true), *expected, "{ray:?}, {options:?}");
            }
            tree.check(triangles).unwrap_or_else(|broken| panic!("traced, {options:?}: {broken}"));
        }
    }
    expected.iter().flatten().count()
}

fn random_rays(random: &mut Random, count: usize, reach: f32) -> Vec<Ray> {
    let mut ray = || {
        let [origin, to] = [random.point() * reach, random.point() * 1.5].map(Vec3::as_dvec3);
        Ray::new(origin, to - origin)
    };
    (0..count).map(|_| ray()).collect()
}

#[test]
fn rays_hit_what_the_predicate_says() {
    let mut random = Random(51);
    let mesh = scene(&mut random);
    let mut rays = random_rays(&mut random, 100, 4.0);
    rays.extend(support::grazing_rays(mesh.triangles(), &mut random, 60));
    assert!(check(&mesh, &first_frames(&mesh), &rays) > 150);
}

#[test]
fn rays_in_planes_and_along_axes_hit_what_the_predicate_says() {
    let mut random = Random(52);
    let mesh = blocks(&mut random, 400);
    assert!(mesh.indices.len() > 1200);
    let mut rays = Vec::new();
    for step in 0..120 {
        let origin = (random.point() * 6.0).round().as_dvec3();
        let axis = [DVec3::X, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Z][step % 6];
        rays.push(Ray::new(origin - axis * 16.0, axis));
        rays.push(Ray::new(origin, axis * DVec3::new(1.0, -1.0, 1.0)));
        let diagonal = (random.point() * 2.0).round().as_dvec3();
        if diagonal != DVec3::ZERO {
            rays.push(Ray::new(origin - diagonal * 8.0, diagonal));
        }
    }
    assert!(check(&mesh, &first_frames(&mesh), &rays) > 200);
}

/// A hierarchy of one frame serves another with other positions, in which other triangles can be hit.
#[test]
fn hierarchies_of_earlier_frames_serve_later_ones() {
    let mut random = Random(53);
    let mut mesh = scene(&mut random);
    let first_frames = first_frames(&mesh);
    for position in &mut mesh.positions {
        *position = Vec3::new(position.y, position.z * 0.5, position.x + position.y * position.y);
    }
    mesh.positions[5] = Vec3::new(0.3, 0.2, -0.5);
    mesh.positions[70].z = f32::INFINITY;
    let rays = random_rays(&mut random, 100, 4.0);
    assert!(check(&mesh, &first_frames, &rays) > 30);
}

#[test]
fn any_number_of_triangles_is_hit_and_rebuilt() {
    let mut random = Random(54);
    let mut tree = HierarchyKdTree::default();
    for count in (0..20).chain([700, 0, 1500, 5]) {
        let mesh = Mesh::soup(&mut random, count, 0.1);
        for first in first_frames(&mesh).iter().chain([&mesh]) {
            tree.build(first.triangles());
            tree.tree().check(first.triangles()).expect("a valid tree");
            for ray in random_rays(&mut random, 10, 3.0) {
                assert_eq!(tree.tree().nearest(first.triangles(), &ray, &|_| true), nearest(first.triangles(), &ray));
            }
        }
    }
}

#[test]
fn flat_huge_and_equal_triangles_are_hit() {
    let mut random = Random(55);
    let mut equal = Mesh::default();
    equal.push([Vec3::ZERO, Vec3::new(1.0, 2.0, 0.5), Vec3::new(-1.0, 0.5, 3.0)]);
    equal.indices = vec![equal.indices[0]; 3000];
    let mut line = Mesh::default();
    (0..2000).for_each(|step| line.push([Vec3::ZERO, Vec3::X, Vec3::X * step as f32]));
    let mut large = Mesh::default();
    (0..1000).for_each(|_| large.push([random.point(), random.point(), random.point()]));
    let flat = Mesh::floor(20, 2.0);
    let [huge, tiny] = [1e38, 1e-30].map(|scale| flat.moved(scale, Vec3::ZERO));
    // A hierarchy holds no sizes.
    for (mesh, like) in
        [&equal, &line, &large, &flat].map(|mesh| (mesh, mesh)).into_iter().chain([(&huge, &flat), (&tiny, &flat)])
    {
        let rays = random_rays(&mut random, 20, 3.0);
        check(mesh, &first_frames(like), &rays);
    }
}

#[test]
fn trees_are_as_good_as_the_exact_one_and_do_not_depend_on_threads() {
    let mut random = Random(56);
    let mut mesh = Mesh::bumpy_ball(Vec3::ZERO, 1.0, 80);
    mesh.append(&Mesh::bumpy_ball(Vec3::X, 0.5, 60));
    mesh.append(&Mesh::soup(&mut random, 500, 0.01));
    let triangles = mesh.triangles();
    let mut exact = KdTree::default();
    exact.build(triangles);
    for (first_frame, most) in first_frames(&mesh).iter().zip([1.08, 1.08]) {
        let first = build(triangles, first_frame, KdTreeOptions::DEFAULT);
        let [cost, best] = [first.tree().counts().sah_cost, exact.counts().sah_cost];
        assert!(cost < best * most, "{cost} {best}");
        for threads in [1, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            let again = pool.install(|| build(triangles, first_frame, KdTreeOptions::DEFAULT));
            assert!(again.tree().is_same_as(first.tree()), "{threads} threads");
        }
    }
}
