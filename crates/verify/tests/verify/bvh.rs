//! The hierarchy against the oracle, ray by ray.

use glam::{DVec3, Vec3};
use umbrage_rays::predicate::{HitPoint, ShadowRay};
use umbrage_rays::{Bvh, Hit, LightSource, Ray, SingleRays as _, Structure as _};
use umbrage_verify::{Oracle, Random, TestMesh};

/// Meshes that structures get wrong when they are built or walked carelessly.
fn meshes() -> Vec<(String, TestMesh)> {
    let mut random = Random::new(7);
    let mut meshes = Vec::new();
    for size in (0..=9).chain([16, 33, 100]) {
        let mut soup = TestMesh::default();
        (0..size).for_each(|_| soup.push([(); 3].map(|()| random.point())));
        meshes.push((format!("{size} random triangles"), soup));
    }
    let mut identical = TestMesh::default();
    (0..300).for_each(|_| identical.push([Vec3::new(-1.0, -1.0, 0.0), Vec3::X, Vec3::Y]));
    meshes.push(("300 identical triangles".into(), identical));

    let mut uneven = TestMesh::ball(1);
    uneven.push([Vec3::new(-1e6, -0.5, -1e6), Vec3::new(1e6, -0.5, -1e6), Vec3::new(0.0, -0.5, 1e6)]);
    (0..50).for_each(|_| {
        let place = random.point();
        uneven.push([place, place + random.point() * 1e-4, place + Vec3::X * 3.0]);
    });
    meshes.push(("a ball, a huge floor and needles".into(), uneven));

    let mut flat = TestMesh::default();
    (0..100).for_each(|_| flat.push([(); 3].map(|()| random.point().with_y(0.25))));
    meshes.push(("coplanar triangles".into(), flat));

    for (name, scale, offset) in [
        ("a tiny ball", 1e-6, Vec3::ZERO),
        ("a huge ball", 1e6, Vec3::ZERO),
        ("a ball far away", 1.0, Vec3::new(148_376.0, 1_234.0, -223_423.0)),
    ] {
        meshes.push((name.into(), TestMesh::ball(2).placed(scale, offset)));
    }

    let mut broken = TestMesh::ball(1);
    broken.push([Vec3::NAN, Vec3::X, Vec3::Y]);
    broken.push([Vec3::X, Vec3::new(f32::INFINITY, 0.0, 0.0), Vec3::Y]);
    broken.push([Vec3::X; 3]);
    broken.push([Vec3::X, Vec3::X, Vec3::Y]);
    meshes.push(("a ball with broken triangles".into(), broken));
    meshes
}

/// Rays of every kind at a mesh.
fn rays(mesh: &TestMesh, random: &mut Random) -> Vec<Ray> {
    let bounds = mesh.triangles().bounds();
    let (center, size) = (bounds.center().as_dvec3(), f64::from(bounds.size().max_element()).max(1e-30));
    let usable: Vec<Vec3> = mesh.positions.iter().copied().filter(|position| position.is_finite()).collect();
    (0..400)
        .map(|kind| {
            let point = |random: &mut Random| center + random.point().as_dvec3() * size;
            let corner = |random: &mut Random| match usable.len() {
                0 => DVec3::ZERO,
                count => usable[random.below(count)].as_dvec3(),
            };
            match kind % 6 {
                0 => Ray::new(point(random), random.point().as_dvec3()),
                // Along an axis, through corners, from corners to corners.
                1 => Ray::new(point(random), DVec3::AXES[random.below(3)] * size),
                2 => {
                    let from = point(random);
                    Ray::new(from, corner(random) - from)
                }
                3 => {
                    let from = corner(random);
                    Ray::new(from, corner(random) - from)
                }
                4 => {
                    let from = point(random);
                    Ray { t_min: 0.5, t_max: 1.0, ..Ray::new(from, corner(random) - from) }
                }
                _ => Ray::new(point(random) * 100.0, random.point().as_dvec3() * 1e-20),
            }
        })
        .filter(|ray| ray.direction != DVec3::ZERO)
        .collect()
}

#[test]
fn nearest_hits_and_shadows_are_the_oracles() {
    let mut random = Random::new(11);
    let mut bvh = Bvh::default();
    for (name, mesh) in meshes() {
        let triangles = mesh.triangles();
        bvh.build(triangles);
        bvh.check(triangles).unwrap_or_else(|broken| panic!("{name}: {broken}"));
        let oracle = Oracle::new(triangles);
        for ray in rays(&mesh, &mut random) {
            for counts in [|_: &Hit| true, |hit: &Hit| hit.triangle % 3 != 1] {
                let (found, truth) = (bvh.nearest(triangles, &ray, &counts), oracle.nearest(&ray, counts));
                assert_eq!(found, truth, "{name}: {ray:?}");
            }
            let Some(hit) = oracle.nearest(&ray, |_| true) else { continue };
            let point = HitPoint::new(&ray, hit.t);
            let position = (mesh.triangles().bounds().center() + random.point() * 2.0).with_y(random.unit() * 3.0);
            for light in [LightSource::Point { position }, LightSource::Directional { direction: random.point() }] {
                let shadow_ray = ShadowRay::new(&light, point);
                for counts in [|_: u32, _: [f32; 2]| true, |id: u32, _: [f32; 2]| id.is_multiple_of(2)] {
                    let found = bvh.blocked(triangles, &shadow_ray, hit.triangle, &counts);
                    assert_eq!(found, oracle.blocked(&shadow_ray, hit.triangle, counts), "{name}: {shadow_ray:?}");
                }
            }
        }
    }
}

#[test]
fn what_is_left_out_is_counted_and_named() {
    let (_, broken) = meshes().pop().expect("the last mesh is the broken one");
    let mut bvh = Bvh::default();
    bvh.build(broken.triangles());
    let count = broken.indices.len() as u32;
    assert_eq!(bvh.omitted().not_finite.first_ids, [count - 4, count - 3]);
    assert_eq!(bvh.omitted().zero_area.first_ids, [count - 2, count - 1]);
    assert_eq!(bvh.omitted().total(), 4);
}

#[test]
fn of_equally_near_triangles_the_lowest_id_is_hit() {
    let mut mesh = TestMesh::default();
    (0..40).for_each(|_| mesh.push([Vec3::new(-1.0, -1.0, 0.0), Vec3::X, Vec3::Y]));
    let mut bvh = Bvh::default();
    bvh.build(mesh.triangles());
    let ray = Ray::new(DVec3::new(0.1, 0.1, 1.0), DVec3::NEG_Z);
    assert_eq!(bvh.nearest(mesh.triangles(), &ray, &|_| true).map(|hit| hit.triangle), Some(0));
    assert_eq!(bvh.nearest(mesh.triangles(), &ray, &|hit| hit.triangle > 6).map(|hit| hit.triangle), Some(7));
}

#[test]
fn a_hit_exactly_at_the_end_of_the_interval_does_not_count() {
    let mut mesh = TestMesh::default();
    mesh.push([Vec3::new(-1.0, -1.0, 0.0), Vec3::X, Vec3::Y]);
    let mut bvh = Bvh::default();
    bvh.build(mesh.triangles());
    let hit = |t_min: f64, t_max: f64| {
        let ray = Ray { t_min, t_max, ..Ray::new(DVec3::new(0.0, 0.0, 1.0), DVec3::NEG_Z) };
        bvh.nearest(mesh.triangles(), &ray, &|_| true).is_some()
    };
    assert!(hit(0.5, 1.5));
    assert!(!hit(0.5, 1.0));
    assert!(!hit(1.0, 1.5));
}

#[test]
fn validation_notices_a_moved_triangle() {
    let mut mesh = TestMesh::ball(1);
    let mut bvh = Bvh::default();
    bvh.build(mesh.triangles());
    assert_eq!(bvh.check(mesh.triangles()), Ok(()));
    mesh.positions[3] *= 1.5;
    assert!(bvh.check(mesh.triangles()).is_err());
}
