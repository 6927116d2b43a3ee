//! Packets through the kd-tree, with each width and traversal, against the predicate asked about every triangle.

use glam::{DVec3, Vec3, Vec3Swizzles};
use umbrage_papers::{
    KdBuilder, KdMailbox, KdPacketOptions, KdPacketWidth, KdTraversal, KdTree, KdTreeOptions, SahCosts,
};
use umbrage_rays::predicate::{HitPoint, ShadowRay};
use umbrage_rays::{Choice as _, Hit, LightSource, Ray, SimdLevel, Triangles};

use crate::support::{self, Mesh, Random, blocked_by_any, blocks, nearest_of_all, random_ray, scene};

const TRAVERSALS: [KdTraversal; 5] = [
    KdTraversal::Stack,
    KdTraversal::Restart,
    KdTraversal::PushDown,
    KdTraversal::ShortStack(1),
    KdTraversal::ShortStack(4),
];

/// Each width with each traversal.
fn forms() -> Vec<(KdTraversal, KdPacketOptions)> {
    let mut forms = Vec::new();
    for width in KdPacketWidth::all() {
        let options = KdPacketOptions { width, ..KdPacketOptions::default() };
        forms.extend(TRAVERSALS.map(|traversal| (traversal, options)));
    }
    for (place, (_, options)) in forms.iter_mut().enumerate() {
        options.mailbox = [KdMailbox::None, KdMailbox::Ring, KdMailbox::Hashed][place % 3];
    }
    forms
}

fn tree(level: SimdLevel, triangles: Triangles<'_>, options: KdTreeOptions) -> KdTree {
    let mut tree = KdTree::with_level(level);
    tree.set_options(options).expect("possible options");
    tree.build(triangles);
    tree
}

/// Trees with small and with large leaves.
fn trees(triangles: Triangles<'_>) -> [KdTree; 2] {
    let large = SahCosts { step: 10.0, test: 1.0, ..KdTreeOptions::DEFAULT.costs };
    let binned = KdTreeOptions { builder: KdBuilder::Binned, costs: large, ..KdTreeOptions::DEFAULT };
    let level = SimdLevel::default();
    [tree(level, triangles, KdTreeOptions::DEFAULT), tree(level, triangles, binned)]
}

fn bits(hits: &[Option<Hit>]) -> Vec<Option<(u32, u64, [f32; 2])>> {
    hits.iter().map(|hit| hit.map(|hit| (hit.triangle, hit.t.to_bits(), hit.barycentric))).collect()
}

/// Compares packets of all forms with the predicate. Returns the number of hits.
fn check(mesh: &Mesh, rays: &[Ray]) -> usize {
    let triangles = mesh.triangles();
    let expected: Vec<_> = rays.iter().map(|ray| nearest_of_all(triangles, ray, |_| true)).collect();
    for mut tree in trees(triangles) {
        for (traversal, options) in forms() {
            tree.set_options(KdTreeOptions { traversal, packets: options, ..tree.options() })
                .expect("possible options");
            let mut hits = vec![None; rays.len()];
            tree.nearest_of_packet(triangles, rays, |_| true, &mut hits);
            if let Some(wrong) = (0..rays.len()).find(|&place| bits(&hits)[place] != bits(&expected)[place]) {
                let (ray, found, expected) = (&rays[wrong], &hits[wrong], &expected[wrong]);
                panic!("{found:?} instead of {expected:?} for {ray:?}, number {wrong}, {traversal:?}, {options:?}");
            }
        }
    }
    expected.iter().flatten().count()
}

/// Rays of a small picture, from one point or along one direction.
fn fan(random: &mut Random, side: u32, width: f32) -> Vec<Ray> {
    let (origin, target) = (random.point() * 4.0, random.point() * 0.5);
    let forward = (target - origin).normalize();
    let right = forward.any_orthonormal_vector();
    let up = forward.cross(right);
    let is_parallel = random.unit() < 0.3;
    let mut rays = Vec::new();
    for y in 0..side {
        for x in 0..side {
            let [x, y] = [x, y].map(|at| (at as f32 / side as f32 - 0.5) * width);
            let beside = (right * x + up * y).as_dvec3();
            rays.push(if is_parallel {
                Ray::new(origin.as_dvec3() + beside * 4.0, forward.as_dvec3())
            } else {
                Ray::new(origin.as_dvec3(), forward.as_dvec3() + beside)
            });
        }
    }
    rays
}

#[test]
fn coherent_rays_hit_what_the_predicate_says() {
    let mut random = Random(1);
    let mesh = scene(&mut random);
    let mut hits = 0;
    for (side, width) in [(16, 0.4), (17, 1.5), (9, 0.01), (4, 0.3), (3, 4.0)] {
        for _ in 0..3 {
            hits += check(&mesh, &fan(&mut random, side, width));
        }
    }
    assert!(hits > 600, "{hits}");
}

#[test]
fn bounced_rays_hit_what_the_predicate_says() {
    let mut random = Random(2);
    let mesh = scene(&mut random);
    let mut rays = Vec::new();
    for ray in fan(&mut random, 16, 0.8) {
        if let Some(hit) = nearest_of_all(mesh.triangles(), &ray, |_| true) {
            let origin = ray.origin + ray.direction * hit.t;
            rays.push(Ray::new(origin, (random.point() + Vec3::Y * 0.7).as_dvec3()));
            // All in about one direction, from different places.
            rays.push(Ray::new(origin, (random.point() * 0.1).as_dvec3() - ray.direction));
        }
    }
    assert!(rays.len() > 100);
    assert!(check(&mesh, &rays) > 50);
    rays.sort_by(|a, b| a.direction.x.total_cmp(&b.direction.x));
    assert!(check(&mesh, &rays) > 50);
}

#[test]
fn incoherent_rays_hit_what_the_predicate_says() {
    let mut random = Random(3);
    let mesh = scene(&mut random);
    for (reach, least) in [(0.5, 10), (3.0, 10), (40.0, 10), (3e6, 10), (1e15, 10)] {
        let rays: Vec<_> = (0..48).map(|_| random_ray(&mut random, reach)).collect();
        let hits = check(&mesh, &rays);
        assert!(hits > least, "{hits} hits from {reach}");
    }
    // Some from far away among the others, and numbers that can't be trusted.
    let mut rays: Vec<_> = (0..60).map(|step| random_ray(&mut random, [2.0, 3.0, 1e9, 1e38][step % 4])).collect();
    rays[7].direction *= 1e90;
    rays[17].direction *= 1e-90;
    assert!(check(&mesh, &rays) > 10);
}

#[test]
fn intervals_are_kept() {
    let mut random = Random(4);
    let mesh = scene(&mut random);
    let rays = support::rays_with_intervals(mesh.triangles(), &mut random, 60);
    assert!(check(&mesh, &rays) > 60);
}

#[test]
fn rays_in_planes_and_along_axes_hit_what_the_predicate_says() {
    let mut random = Random(5);
    let mesh = blocks(&mut random, 80);
    let mut rays = support::rays_in_planes(&mut random, 60);
    assert!(check(&mesh, &rays) > 100);
    // Rays along the same axis side by side.
    rays.sort_by_key(|ray| ray.direction.to_array().map(|component| component == 0.0));
    assert!(check(&mesh, &rays) > 100);
    // Bundles along an axis, and in a plane across it.
    for axis in [DVec3::X, DVec3::NEG_Y, DVec3::Z] {
        let mut rays = Vec::new();
        for y in -8..8 {
            for x in -8..8 {
                let place = axis.zxy() * f64::from(x) * 0.5 + axis.yzx() * f64::from(y) * 0.5;
                rays.push(Ray::new(place - axis * 9.0, axis));
            }
        }
        assert!(check(&mesh, &rays) > 100);
        let fan = |(place, ray): (usize, &Ray)| Ray::new(axis * -9.0, ray.origin + axis * (9.0 + (place % 5) as f64));
        let mut fan: Vec<_> = rays.iter().enumerate().map(fan).collect();
        fan.retain(|ray| ray.direction != DVec3::ZERO);
        check(&mesh, &fan);
        for ray in &mut rays {
            (ray.origin, ray.direction) = (ray.origin + axis * 9.0, axis.zxy());
        }
        check(&mesh, &rays);
    }
}

#[test]
fn triangles_that_end_where_cells_meet_are_hit() {
    let (mesh, rays) = support::corners_of_cells();
    let rays: Vec<_> = rays.into_iter().step_by(23).collect();
    assert!(check(&mesh, &rays) > rays.len() / 2);
}

#[test]
fn grazing_rays_and_shared_edges_hit_what_the_predicate_says() {
    let mut random = Random(6);
    let mesh = scene(&mut random);
    let rays = support::grazing_rays(mesh.triangles(), &mut random, 60);
    assert!(check(&mesh, &rays) > 60);
}

#[test]
fn any_number_of_triangles_and_rays_is_answered() {
    let mut random = Random(7);
    let mut tree = KdTree::default();
    tree.nearest_of_packet(Triangles::default(), &[Ray::new(DVec3::ZERO, DVec3::X)], |_| true, &mut [None]);
    let forms = forms();
    for count in (0..12).chain([60]) {
        let mesh = Mesh::soup(&mut random, count, 0.1);
        tree.build(mesh.triangles());
        for rays in [0, 1, 2, 5, 15, 17, 33, 257, 300] {
            let rays: Vec<_> = (0..rays).map(|_| random_ray(&mut random, 3.0)).collect();
            let (traversal, options) = forms[(random.bits() % forms.len() as u64) as usize];
            tree.set_options(KdTreeOptions { traversal, packets: options, ..KdTreeOptions::DEFAULT })
                .expect("possible options");
            // Former values are overwritten.
            let mut hits = vec![Some(Hit { t: 0.0, triangle: 0, barycentric: [0.0; 2] }); rays.len()];
            tree.nearest_of_packet(mesh.triangles(), &rays, |_| true, &mut hits);
            let expected: Vec<_> = rays.iter().map(|ray| nearest_of_all(mesh.triangles(), ray, |_| true)).collect();
            assert_eq!(bits(&hits), bits(&expected), "{count} triangles, {traversal:?}, {options:?}");
        }
    }
}

#[test]
fn flat_huge_tiny_and_far_scenes_hit_what_the_predicate_says() {
    let mut random = Random(8);
    let mut line = Mesh::default();
    line.push([Vec3::ZERO, Vec3::X, Vec3::X * 2.0]);
    let mut two_sizes = Mesh::soup(&mut random, 60, 0.1).moved(1e-4, Vec3::ZERO);
    two_sizes.append(&Mesh::floor(2, 1000.0));
    let soup = Mesh::soup(&mut random, 40, 0.05);
    let flat = Mesh::floor(5, 2.0);
    for (mesh, must_hit) in [(&flat, true), (&line, false), (&soup, true), (&two_sizes, true)] {
        for (scale, offset) in [
            (1e-30, Vec3::ZERO),
            (1e-43, Vec3::ZERO),
            (1e30, Vec3::ZERO),
            (1e38, Vec3::ZERO),
            (1.0, Vec3::new(148_376.0, 1234.0, -223_423.0)),
            (1.0, Vec3::new(3e8, 0.0, 0.0)),
        ] {
            let moved = mesh.moved(scale, offset);
            let mut rays = fan(&mut random, 6, 0.5);
            rays.extend((0..15).map(|_| random_ray(&mut random, 3.0)));
            for ray in &mut rays {
                let scale = f64::from(scale);
                (ray.origin, ray.direction) = (ray.origin * scale + offset.as_dvec3(), ray.direction * scale);
            }
            let hits = check(&moved, &rays);
            let is_resolved = scale < 1e37 && scale > 1e-40 && offset.x < 1e8;
            assert!(hits > 0 || !must_hit || !is_resolved, "{scale} {offset}");
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
    let mut rays: Vec<_> = (0..100)
        .map(|_| {
            let target = (random.point() * 5.0).round().as_dvec3();
            let origin = (random.point() * 12.0).round().as_dvec3();
            Ray::new(origin, target - origin)
        })
        .filter(|ray| ray.direction != DVec3::ZERO)
        .collect();
    rays.extend(fan(&mut random, 12, 1.0));
    assert!(check(&mesh, &rays) > 50);
}

#[test]
fn all_levels_hit_what_the_predicate_says() {
    let mut random = Random(10);
    let mesh = scene(&mut random);
    let mut rays = fan(&mut random, 16, 0.7);
    rays.extend((0..50).map(|_| random_ray(&mut random, 3.0)));
    let expected: Vec<_> = rays.iter().map(|ray| nearest_of_all(mesh.triangles(), ray, |_| true)).collect();
    for level in SimdLevel::available() {
        let mut tree = tree(level, mesh.triangles(), KdTreeOptions::DEFAULT);
        for (traversal, options) in forms() {
            tree.set_options(KdTreeOptions { traversal, packets: options, ..KdTreeOptions::DEFAULT })
                .expect("possible options");
            let mut hits = vec![None; rays.len()];
            tree.nearest_of_packet(mesh.triangles(), &rays, |_| true, &mut hits);
            assert_eq!(bits(&hits), bits(&expected), "{level}, {traversal:?}, {options:?}");
        }
    }
}

#[test]
fn hits_that_do_not_count_are_passed_through() {
    let mut random = Random(11);
    let mesh = scene(&mut random);
    let counts = |hit: &Hit| hit.triangle.is_multiple_of(3) && hit.barycentric[0] < 0.7;
    let mut tree = tree(SimdLevel::default(), mesh.triangles(), KdTreeOptions::DEFAULT);
    let mut hits = 0;
    for (traversal, options) in forms() {
        tree.set_options(KdTreeOptions { traversal, packets: options, ..KdTreeOptions::DEFAULT })
            .expect("possible options");
        let rays = fan(&mut random, 8, 0.6);
        let expected: Vec<_> = rays.iter().map(|ray| nearest_of_all(mesh.triangles(), ray, counts)).collect();
        let mut found = vec![None; rays.len()];
        tree.nearest_of_packet(mesh.triangles(), &rays, counts, &mut found);
        assert_eq!(bits(&found), bits(&expected), "{traversal:?}, {options:?}");
        hits += expected.iter().flatten().count();
    }
    assert!(hits > 300, "{hits}");
}

#[test]
fn points_are_shadowed_as_the_predicate_says() {
    let mut random = Random(12);
    let mesh = scene(&mut random);
    let triangles = mesh.triangles();
    let lights = [
        LightSource::Point { position: Vec3::new(3.0, 5.0, 2.0) },
        LightSource::Point { position: Vec3::new(0.1, 0.3, 0.2) },
        LightSource::Directional { direction: Vec3::new(0.3, -0.9, 0.1).normalize() },
        LightSource::Directional { direction: Vec3::NEG_Y },
    ];
    let counts = |id: u32, barycentric: [f32; 2]| !id.is_multiple_of(5) || barycentric[1] < 0.5;
    let blocks = |shadow_ray: &ShadowRay, own: u32| blocked_by_any(triangles, shadow_ray, own, counts);
    let (mut lit, mut shadowed) = (0, 0);
    for light in &lights {
        let (mut rays, mut own) = (Vec::new(), Vec::new());
        for seen in fan(&mut random, 12, 0.9).into_iter().chain((0..40).map(|_| random_ray(&mut random, 4.0))) {
            if let Some(hit) = nearest_of_all(triangles, &seen, |_| true) {
                rays.push(ShadowRay::new(light, HitPoint::new(&seen, hit.t)));
                own.push(hit.triangle);
            }
        }
        let expected: Vec<_> = rays.iter().zip(&own).map(|(ray, &own)| blocks(ray, own)).collect();
        for mut tree in trees(triangles) {
            for (traversal, options) in forms() {
                tree.set_options(KdTreeOptions { traversal, packets: options, ..tree.options() })
                    .expect("possible options");
                let mut blocked = vec![true; rays.len()];
                tree.blocked_of_packet(triangles, &rays, &own, counts, &mut blocked);
                assert_eq!(blocked, expected, "{light:?}, {traversal:?}, {options:?}");
            }
        }
        shadowed += expected.iter().filter(|&&blocked| blocked).count();
        lit += expected.iter().filter(|&&blocked| !blocked).count();
    }
    assert!(lit > 50 && shadowed > 50, "{lit} {shadowed}");
}

#[test]
fn packets_take_nothing_from_the_heap() {
    let mut random = Random(15);
    let mesh = scene(&mut random);
    let rays = fan(&mut random, 26, 1.0);
    let mut tree = tree(SimdLevel::default(), mesh.triangles(), KdTreeOptions::DEFAULT);
    for (traversal, options) in forms() {
        tree.set_options(KdTreeOptions { traversal, packets: options, ..KdTreeOptions::DEFAULT })
            .expect("possible options");
        let mut hits = vec![None; rays.len()];
        let before = allocations::on_this_thread();
        tree.nearest_of_packet(mesh.triangles(), &rays, |_| true, &mut hits);
        assert_eq!(allocations::on_this_thread() - before, 0, "{traversal:?}, {options:?}");
        assert!(hits.iter().flatten().count() > 50);
    }
}

#[cfg(feature = "statistics")]
#[test]
fn packets_share_what_single_rays_do_alone() {
    let mut random = Random(13);
    let mut mesh = Mesh::bumpy_ball(Vec3::ZERO, 1.0, 60);
    mesh.append(&Mesh::soup(&mut random, 3000, 0.01));
    // Tiles of 16² rays of a picture of 64².
    let (origin, forward) = (Vec3::new(0.3, 0.4, 4.0), Vec3::NEG_Z);
    let tiles = (0..16).flat_map(|tile| (0..256).map(move |ray| [tile % 4 * 16 + ray % 16, tile / 4 * 16 + ray / 16]));
    let rays: Vec<_> = tiles
        .map(|place| {
            let [x, y] = place.map(|at| at as f32 / 64.0 - 0.5);
            Ray::new(origin.as_dvec3(), (forward + Vec3::new(x, y, 0.0)).as_dvec3())
        })
        .collect();
    let mut tree = tree(SimdLevel::default(), mesh.triangles(), KdTreeOptions::DEFAULT);
    let mut visits = |traversal, options| {
        tree.set_options(KdTreeOptions { traversal, packets: options, ..KdTreeOptions::DEFAULT })
            .expect("possible options");
        let mut hits = vec![None; rays.len()];
        tree.nearest_of_packet(mesh.triangles(), &rays, |_| true, &mut hits);
        assert!(hits.iter().flatten().count() > 1000);
        tree.take_visits()
    };
    let default = KdPacketOptions::default();
    let [four, eight, sixteen] = [KdPacketWidth::Four, KdPacketWidth::Eight, KdPacketWidth::Sixteen]
        .map(|width| visits(KdTraversal::Stack, KdPacketOptions { width, ..default }));
    let fall = |visits: [u64; 4]| assert!(visits.is_sorted_by(|a, b| a > b), "{visits:?}");
    fall([four, eight, sixteen, umbrage_rays::Counts::default()].map(|visits| visits.nodes));
    fall([four, eight, sixteen, umbrage_rays::Counts::default()].map(|visits| visits.packets));
    // As with single rays; with a whole stack nothing starts again from above.
    let [restart, push_down, three, whole] = [
        KdTraversal::Restart,
        KdTraversal::PushDown,
        KdTraversal::ShortStack(3),
        KdTraversal::ShortStack(KdTraversal::MOST_ENTRIES),
    ]
    .map(|traversal| visits(traversal, default));
    fall([restart, push_down, three, whole].map(|visits| visits.nodes));
    assert!(restart.restarts > three.restarts && whole.restarts == 0 && sixteen.restarts == 0, "{whole:?}");
    // More than with single rays, since packets spread near the leaves (Horn et al. 2007, §3.3).
    assert!(three.nodes as f64 <= 1.7 * sixteen.nodes as f64, "{three:?} {sixteen:?}");
    let [none, ring, hashed] = [KdMailbox::None, KdMailbox::Ring, KdMailbox::Hashed]
        .map(|mailbox| visits(KdTraversal::Stack, KdPacketOptions { mailbox, ..default }));
    assert!(none.tests > ring.tests && ring.tests >= hashed.tests, "{none:?} {ring:?} {hashed:?}");
}
