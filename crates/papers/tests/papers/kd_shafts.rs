//! Shafts through the kd-tree, with each entry, culling and mailbox, against the predicate for every triangle.

use glam::{DVec3, Vec3, Vec3Swizzles};
use umbrage_papers::shaft::{
    EntryPoint, KdCulling, KdEntry, ShaftLead, ShaftOptions, blocked_of_shafts, nearest_of_shafts,
    nearest_of_shafts_below,
};
use umbrage_papers::{
    KdBuilder, KdMailbox, KdPacketOptions, KdPacketWidth, KdTraversal, KdTree, KdTreeOptions, SahCosts,
};
use umbrage_rays::predicate::{HitPoint, ShadowRay};
use umbrage_rays::{Hit, LightSource, Ray, SimdLevel, Triangles};

use crate::support::{self, Mesh, Random, blocked_by_any, blocks, nearest_of_all, random_ray, scene};

/// Each lead with each entry, and mailboxes in turns.
fn forms() -> Vec<ShaftOptions> {
    let leads = || KdCulling::ALL.into_iter().map(ShaftLead::Shaft).chain([ShaftLead::Packets]);
    let forms = KdEntry::ALL.into_iter().flat_map(|entry| leads().map(move |lead| (entry, lead)));
    let mailboxes = [KdMailbox::None, KdMailbox::Ring, KdMailbox::Hashed].into_iter().cycle();
    forms.zip(mailboxes).map(|((entry, lead), mailbox)| ShaftOptions { entry, lead, mailbox }).collect()
}

/// A tree with small leaves for packets of 16 with a stack, and one with large leaves for packets of 4 without.
fn trees(triangles: Triangles<'_>, level: SimdLevel) -> [KdTree; 2] {
    let large = SahCosts { step: 10.0, test: 1.0, ..KdTreeOptions::DEFAULT.costs };
    let traversal = KdTraversal::ShortStack(1);
    let binned = KdTreeOptions { builder: KdBuilder::Binned, costs: large, traversal, ..KdTreeOptions::DEFAULT };
    let ways = [(KdPacketWidth::Sixteen, KdTreeOptions::DEFAULT), (KdPacketWidth::Four, binned)];
    ways.map(|(width, options)| {
        let mut tree = KdTree::with_level(level);
        let packets = KdPacketOptions { width, ..KdPacketOptions::DEFAULT };
        tree.set_options(KdTreeOptions { packets, ..options }).expect("possible options");
        tree.build(triangles);
        tree
    })
}

fn bits(hits: &[Option<Hit>]) -> Vec<Option<(u32, u64, [f32; 2])>> {
    hits.iter().map(|hit| hit.map(|hit| (hit.triangle, hit.t.to_bits(), hit.barycentric))).collect()
}

/// Compares all forms with the predicate, on each of the levels; returns the number of hits.
fn check_levels(mesh: &Mesh, rays: &[Ray], levels: &[SimdLevel], counts: impl Fn(&Hit) -> bool + Copy) -> usize {
    let triangles = mesh.triangles();
    let expected: Vec<_> = rays.iter().map(|ray| nearest_of_all(triangles, ray, counts)).collect();
    for tree in levels.iter().flat_map(|&level| trees(triangles, level)) {
        for options in forms() {
            // Old contents are overwritten.
            let mut hits = vec![Some(Hit { t: 0.0, triangle: 0, barycentric: [0.0; 2] }); rays.len()];
            let _ = nearest_of_shafts(&tree, triangles, rays, options, counts, &mut hits);
            if let Some(wrong) = (0..rays.len()).find(|&index| bits(&hits)[index] != bits(&expected)[index]) {
                let (ray, found, expected) = (&rays[wrong], &hits[wrong], &expected[wrong]);
                panic!("{found:?} instead of {expected:?} for {ray:?}, number {wrong}, {options:?}");
            }
        }
    }
    expected.iter().flatten().count()
}

fn check(mesh: &Mesh, rays: &[Ray]) -> usize {
    check_levels(mesh, rays, &[SimdLevel::default()], |_| true)
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
    let counts = |hit: &Hit| !hit.triangle.is_multiple_of(3) || hit.barycentric[0] < 0.7;
    let mut hits = 0;
    for (side, width) in [(16, 0.4), (17, 1.5), (9, 0.01), (3, 4.0)] {
        hits += check(&mesh, &fan(&mut random, side, width));
        hits += check_levels(&mesh, &fan(&mut random, side, width), &SimdLevel::available(), counts);
    }
    assert!(hits > 400, "{hits}");
}

/// Tiles of four packets of 16×16 rays, which begin at the entry of their tile's corners, and again at that of their own.
#[test]
fn rays_that_begin_with_their_tile_hit_what_the_predicate_says() {
    const SIDE: usize = 32;
    let mut random = Random(21);
    let meshes = [scene(&mut random), Mesh::floor(3, 2.0), Mesh::soup(&mut random, 3, 0.2), Mesh::default()];
    let (mut hits, mut lower, mut nothing) = (0, 0, 0);
    let corners = |rays: &[Ray], [left, top]: [usize; 2], side: usize| -> [Ray; 4] {
        [[0, 0], [1, 0], [0, 1], [1, 1]]
            .map(|[right, down]| rays[(top + down * (side - 1)) * SIDE + left + right * (side - 1)])
    };
    for (mesh, width, seen_from) in meshes.iter().flat_map(|mesh| {
        let (from, far) = (Vec3::ZERO, Vec3::new(1e6, -3e5, 2e6));
        [(mesh, 0.3, from), (mesh, 1.2, from), (mesh, 0.02, from), (mesh, 0.4, far), (mesh, 9.0, from)]
    }) {
        let mut rays = fan(&mut random, SIDE as u32, width);
        if seen_from != Vec3::ZERO {
            rays.iter_mut().for_each(|ray| ray.origin -= ray.direction * 1e5);
        }
        let triangles = mesh.triangles();
        for (tree, kind) in trees(triangles, SimdLevel::default()).iter().zip([1, 2].map(|kind| KdEntry::ALL[kind])) {
            let root = EntryPoint::root(tree);
            let mut visits = umbrage_rays::Counts::default();
            let mut of_tile = |entry: &EntryPoint, corners| entry.of_tile(tree, triangles, &corners, kind, &mut visits);
            let whole = of_tile(&root, corners(&rays, [0, 0], SIDE));
            for part in [[0, 0], [16, 0], [0, 16], [16, 16]] {
                let entry = whole.and_then(|whole| of_tile(&whole, corners(&rays, part, 16)));
                let of_part = |index: usize| rays[(part[1] + index / 16) * SIDE + part[0] + index % 16];
                let packet: Vec<_> = (0..256).map(of_part).collect();
                let expected: Vec<_> = packet.iter().map(|ray| nearest_of_all(triangles, ray, |_| true)).collect();
                hits += expected.iter().flatten().count();
                let Some(entry) = entry else {
                    assert_eq!(bits(&expected), vec![None; 256], "{kind:?}");
                    nothing += 1;
                    continue;
                };
                lower += usize::from(entry.is_below(&root));
                for options in forms() {
                    let mut found = vec![None; 256];
                    let _ = nearest_of_shafts_below(&entry, tree, triangles, &packet, options, |_| true, &mut found);
                    assert_eq!(bits(&found), bits(&expected), "{kind:?} {options:?}");
                }
            }
        }
    }
    assert!(hits > 3000 && lower > 5 && nothing > 10, "{hits} {lower} {nothing}");
}

#[test]
fn incoherent_rays_hit_what_the_predicate_says() {
    let mut random = Random(3);
    let mesh = scene(&mut random);
    let mut rays = Vec::new();
    for ray in fan(&mut random, 16, 0.8) {
        if let Some(hit) = nearest_of_all(mesh.triangles(), &ray, |_| true) {
            let origin = ray.origin + ray.direction * hit.t;
            rays.push(Ray::new(origin, (random.point() + Vec3::Y * 0.7).as_dvec3()));
            // All in about one direction, from different origins.
            rays.push(Ray::new(origin, (random.point() * 0.1).as_dvec3() - ray.direction));
        }
    }
    rays.sort_by(|a, b| a.direction.x.total_cmp(&b.direction.x));
    assert!(check(&mesh, &rays) > 50);
    // Some from far away among the others, and extreme lengths.
    let mut rays: Vec<_> = (0..60).map(|step| random_ray(&mut random, [2.0, 3.0, 1e9, 1e38][step % 4])).collect();
    rays[7].direction *= 1e90;
    rays[17].direction *= 1e-90;
    assert!(check(&mesh, &rays) > 10);
    let rays = support::rays_with_intervals(mesh.triangles(), &mut random, 60);
    assert!(check(&mesh, &rays) > 60);
    let rays = support::grazing_rays(mesh.triangles(), &mut random, 60);
    assert!(check(&mesh, &rays) > 60);
}

#[test]
fn rays_in_planes_and_along_axes_hit_what_the_predicate_says() {
    let mut random = Random(5);
    let mesh = blocks(&mut random, 80);
    let mut rays = support::rays_in_planes(&mut random, 60);
    // Rays along the same axis side by side.
    rays.sort_by_key(|ray| ray.direction.to_array().map(|component| component == 0.0));
    assert!(check(&mesh, &rays) > 100);
    for axis in [DVec3::X, DVec3::NEG_Y, DVec3::Z] {
        let mut rays = Vec::new();
        for y in -8..8 {
            for x in -8..8 {
                let place = axis.as_vec3().zxy() * x as f32 * 0.5 + axis.as_vec3().yzx() * y as f32 * 0.5;
                rays.push(Ray::new(place.as_dvec3() - axis * 9.0, axis));
            }
        }
        assert!(check(&mesh, &rays) > 100);
        for ray in &mut rays {
            (ray.origin, ray.direction) = (axis * -9.0, ray.origin + axis * 12.0);
        }
        check(&mesh, &rays);
    }
}

#[test]
fn flat_huge_tiny_and_far_scenes_hit_what_the_predicate_says() {
    let mut random = Random(8);
    let mut two_sizes = Mesh::soup(&mut random, 60, 0.1).moved(1e-4, Vec3::ZERO);
    two_sizes.append(&Mesh::floor(2, 1000.0));
    for mesh in [Mesh::floor(5, 2.0), Mesh::soup(&mut random, 40, 0.05), two_sizes, Mesh::default()] {
        let far = Vec3::new(148_376.0, 1234.0, -223_423.0);
        for (scale, offset) in [(1e-30, Vec3::ZERO), (1e30, Vec3::ZERO), (1.0, far)] {
            let moved = mesh.moved(scale, offset);
            let mut rays = fan(&mut random, 6, 0.5);
            rays.extend((0..15).map(|_| random_ray(&mut random, 3.0)));
            for ray in &mut rays {
                let scale = f64::from(scale);
                (ray.origin, ray.direction) = (ray.origin * scale + offset.as_dvec3(), ray.direction * scale);
            }
            assert!(check(&moved, &rays) > 0 || mesh.indices.is_empty(), "{scale} {offset}");
        }
    }
}

#[test]
fn points_are_shadowed_as_the_predicate_says() {
    let mut random = Random(12);
    let mesh = scene(&mut random);
    let triangles = mesh.triangles();
    let counts = |id: u32, barycentric: [f32; 2]| !id.is_multiple_of(5) || barycentric[1] < 0.5;
    let (mut lit, mut shadowed) = (0, 0);
    for light in [
        LightSource::Point { position: Vec3::new(3.0, 5.0, 2.0) },
        LightSource::Directional { direction: Vec3::new(0.3, -0.9, 0.1).normalize() },
    ] {
        let (mut rays, mut own) = (Vec::new(), Vec::new());
        for seen in fan(&mut random, 12, 0.9).into_iter().chain((0..40).map(|_| random_ray(&mut random, 4.0))) {
            if let Some(hit) = nearest_of_all(triangles, &seen, |_| true) {
                rays.push(ShadowRay::new(&light, HitPoint::new(&seen, hit.t)));
                own.push(hit.triangle);
            }
        }
        let expected: Vec<_> =
            rays.iter().zip(&own).map(|(ray, &own)| blocked_by_any(triangles, ray, own, counts)).collect();
        for tree in trees(triangles, SimdLevel::default()) {
            for options in forms() {
                let mut blocked = vec![true; rays.len()];
                let _ = blocked_of_shafts(&tree, triangles, (&rays, &own), options, counts, &mut blocked);
                assert_eq!(blocked, expected, "{light:?}, {options:?}");
            }
        }
        shadowed += expected.iter().filter(|&&blocked| blocked).count();
        lit += expected.iter().filter(|&&blocked| !blocked).count();
    }
    assert!(lit > 30 && shadowed > 30, "{lit} {shadowed}");
}

#[test]
fn shafts_begin_lower_and_leave_triangles_out() {
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
    let [tree, _] = trees(mesh.triangles(), SimdLevel::default());
    let visits = |options| -> umbrage_rays::Counts {
        let mut hits = vec![None; rays.len()];
        let visits = nearest_of_shafts(&tree, mesh.triangles(), &rays, options, |_| true, &mut hits);
        assert!(hits.iter().flatten().count() > 1000);
        visits
    };
    let [root, multi_level, accelerated] =
        KdEntry::ALL.map(|entry| visits(ShaftOptions { entry, ..ShaftOptions::default() }));
    assert!(root.packets <= 16 && root.searched == 0, "{root:?}");
    assert!(
        multi_level.nodes < root.nodes && accelerated.nodes <= multi_level.nodes,
        "{multi_level:?} {accelerated:?}"
    );
    assert!(accelerated.searched > 0 && accelerated.searched <= multi_level.searched, "{accelerated:?}");
    let [none, intervals, corner_rays, vertices, transient] = KdCulling::ALL
        .map(|culling| visits(ShaftOptions { lead: ShaftLead::Shaft(culling), ..ShaftOptions::default() }));
    let culled = [intervals, corner_rays, vertices, transient].map(|visits| visits.frustum_culls);
    assert!(none.frustum_culls == 0 && !culled.contains(&0), "{culled:?}");
    assert!(vertices.tests <= none.tests && transient.tests < vertices.tests, "{vertices:?} {transient:?}");
}
