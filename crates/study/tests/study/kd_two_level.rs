//! The two-level kd-tree, frame after frame, against the predicate asked about every triangle.

use glam::{DAffine3, DMat3, DQuat, DVec3, Vec3};
use umbrage_rays::predicate::{HitPoint, ShadowRay};
use umbrage_rays::{Hit, KdBuilder, KdTraversal, KdTreeOptions, LightSource, Ray, SingleRays as _, Triangles};
use umbrage_study::kdtree::{ImpossibleObjects, KdMotion, KdObject, TwoLevelKdTree};

use crate::support::{self, Mesh, Random, blocked_by_any, is_usable, nearest_of_all as nearest};

/// What moves in which way, and as it is in some space of its own.
struct Part {
    mesh: Mesh,
    motion: Motion,
}

#[derive(Clone, Copy)]
enum Motion {
    Static,
    Rigid(fn(f64) -> DAffine3),
    /// As the above, with vertices displaced by so much of their coordinates.
    Shaken(f32, fn(f64) -> DAffine3),
    Deforming,
}

/// The world at a time, with positions in f32 as frames have them.
fn frame(parts: &[Part], time: f64) -> (Mesh, Vec<KdObject>) {
    let (mut world, mut objects) = (Mesh::default(), Vec::new());
    for Part { mesh, motion } in parts {
        let mut random = Random(time.to_bits());
        let mut moved = mesh.clone();
        let mut affine = |map: DAffine3, shake: f32| {
            for position in &mut moved.positions {
                let at = map.transform_point3(position.as_dvec3()).as_vec3();
                *position = at * (Vec3::ONE + random.point() * shake);
            }
            KdMotion::Rigid { world_from_object: map }
        };
        let motion = match *motion {
            Motion::Static => KdMotion::Static,
            Motion::Rigid(map) => affine(map(time), 0.0),
            Motion::Shaken(shake, map) => affine(map(time), shake),
            Motion::Deforming => {
                for position in &mut moved.positions {
                    *position += (*position * 3.0 + time as f32)
                        .to_array()
                        .map(f32::sin)
                        .map(|by| by * 0.1)
                        .into_iter()
                        .enumerate()
                        .map(|(axis, by)| Vec3::AXES[axis] * by)
                        .sum::<Vec3>();
                }
                KdMotion::Deforming
            }
        };
        let start = world.indices.len() as u32;
        world.append(&moved);
        objects.push(KdObject { triangles: start..world.indices.len() as u32, motion });
    }
    (world, objects)
}

fn turning(time: f64) -> DAffine3 {
    let turned = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), time * 2.0);
    DAffine3::from_scale_rotation_translation(DVec3::new(1.0, 0.5, 1.5), turned, DVec3::new(time.sin(), 0.3, -time))
}

/// By quarters, so that axes stay axes.
fn quarters(time: f64) -> DAffine3 {
    let (x, y) = if (time as i64) % 2 == 0 { (DVec3::X, DVec3::Y) } else { (DVec3::Y, DVec3::NEG_X) };
    DAffine3::from_mat3_translation(DMat3::from_cols(x, y, DVec3::Z), DVec3::new(time.floor(), -1.0, 0.5))
}

/// A shear, mirrored and far away.
fn far(time: f64) -> DAffine3 {
    let matrix = DMat3::from_cols(DVec3::new(-1.0, 0.0, 0.0), DVec3::new(0.4, 1.0, 0.0), DVec3::new(0.0, 0.2, 1.0));
    DAffine3::from_mat3_translation(matrix, DVec3::new(300.0 + time, -200.0, 0.0))
}

fn parts() -> Vec<Part> {
    let mut random = Random(41);
    let ball = Mesh::bumpy_ball(Vec3::ZERO, 0.7, 8);
    let mut broken = Mesh::soup(&mut random, 40, 0.05);
    broken.positions[4].y = f32::NAN;
    broken.indices.push([0, 1, u32::MAX - 1_000_000]);
    broken.indices.push([7, 7, 8]);
    let part = |mesh: &Mesh, motion: Motion| Part { mesh: mesh.clone(), motion };
    vec![
        part(&Mesh::floor(5, 3.0), Motion::Static),
        part(&ball, Motion::Rigid(turning)),
        part(&Mesh::default(), Motion::Deforming),
        part(&ball, Motion::Rigid(quarters)),
        part(&broken, Motion::Deforming),
        part(&broken.clone(), Motion::Rigid(turning)),
        part(&ball, Motion::Rigid(far)),
        part(&ball, Motion::Shaken(1e-4, turning)),
        part(&Mesh::floor(3, 1.0), Motion::Rigid(quarters)),
    ]
}

fn check(trees: &TwoLevelKdTree, triangles: Triangles<'_>, rays: &[Ray]) -> usize {
    let bits = |hit: &Option<Hit>| hit.map(|hit| (hit.triangle, hit.t.to_bits(), hit.barycentric));
    let mut hits = 0;
    for ray in rays {
        let expected = nearest(triangles, ray, |_| true);
        assert_eq!(bits(&trees.nearest(triangles, ray, &|_| true)), bits(&expected), "{ray:?}");
        hits += usize::from(expected.is_some());
    }
    hits
}

/// Rays through points near triangles, along axes, in planes, and with bounds.
fn rays(mesh: &Mesh, random: &mut Random) -> Vec<Ray> {
    let mut rays = support::grazing_rays(mesh.triangles(), random, 60);
    for step in 0..120 {
        let id = (random.bits() % mesh.indices.len() as u64) as u32;
        if !is_usable(mesh.triangles(), id) {
            continue;
        }
        let [a, b, c] = mesh.triangles().corners(id).map(Vec3::as_dvec3);
        let target = [a, (a + b) * 0.5, (a + b + c) / 3.0][step % 3];
        let axis = [DVec3::X, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Z][step % 6];
        for away in [0.0, 2.0, 1e6] {
            let mut ray = Ray::new(target - axis * away, axis);
            rays.push(ray);
            (ray.t_min, ray.t_max) = (-1.0, 0.5);
            rays.push(ray);
            rays.push(Ray::new(ray.origin, axis + random.point().as_dvec3() * 10.0_f64.powi(-(step as i32 % 40) * 8)));
        }
        let origin = (random.point() * 4.0).as_dvec3();
        rays.push(Ray::new(origin, (target - origin) * 10.0_f64.powi(step as i32 % 9 - 4)));
    }
    rays.push(Ray::new(DVec3::ZERO, DVec3::new(1e-320, 1.0, 1e-310)));
    rays.push(Ray::new(DVec3::splat(1e300), DVec3::splat(-1e99)));
    rays
}

#[test]
fn frames_hit_what_the_predicate_says() {
    let parts = parts();
    let mut random = Random(42);
    let options = [
        KdTreeOptions::DEFAULT,
        KdTreeOptions { builder: KdBuilder::Binned, traversal: KdTraversal::ShortStack(2), ..KdTreeOptions::DEFAULT },
        KdTreeOptions { builder: KdBuilder::Adaptive, lazy_below: 100, ..KdTreeOptions::DEFAULT },
    ];
    for options in options {
        let mut trees = TwoLevelKdTree::default();
        trees.set_options(options).expect("possible options");
        let mut hits = 0;
        for (step, time) in [0.0, 1.0, 1.3, 2.0, 2.9].into_iter().enumerate() {
            let (mesh, objects) = frame(&parts, time);
            trees.update(mesh.triangles(), &objects).expect("objects in order");
            trees.validate(mesh.triangles()).unwrap_or_else(|broken| panic!("{time}: {broken}"));
            let counts = trees.counts();
            // The two that deform; where one that is rigid has vertices that are nowhere, they stay there.
            assert_eq!(counts.rebuilt, if step == 0 { 9 } else { 2 }, "{time}: {counts:?}");
            // Corners that meet only where the object is now are still in its tree.
            let (found, expected) = (trees.omitted(), mesh.triangles().omitted());
            assert_eq!(
                (&found.not_finite, &found.index_out_of_range),
                (&expected.not_finite, &expected.index_out_of_range)
            );
            assert!(step > 0 || *found == expected, "{found:?} {expected:?}");
            hits += check(&trees, mesh.triangles(), &rays(&mesh, &mut random));
        }
        assert!(hits > 2000, "{hits}");
    }
}

#[test]
fn points_are_shadowed_and_hits_pass_through() {
    let parts = parts();
    let mut random = Random(43);
    let mut trees = TwoLevelKdTree::default();
    let lights = [
        LightSource::Point { position: Vec3::new(3.0, 5.0, 2.0) },
        LightSource::Directional { direction: Vec3::new(0.3, -0.9, 0.1).normalize() },
        LightSource::Directional { direction: Vec3::NEG_Y },
    ];
    let (mut lit, mut shadowed) = (0, 0);
    for time in [0.0, 0.5, 1.7] {
        let (mesh, objects) = frame(&parts, time);
        let triangles = mesh.triangles();
        trees.update(triangles, &objects).expect("objects in order");
        for (step, ray) in rays(&mesh, &mut random).iter().enumerate() {
            let counts = |hit: &Hit| hit.triangle.is_multiple_of(3) && hit.barycentric[0] < 0.7;
            let seen = nearest(triangles, ray, counts);
            assert_eq!(trees.nearest(triangles, ray, &counts), seen, "{ray:?}");
            let Some(seen) = seen else { continue };
            let shadow_ray = ShadowRay::new(&lights[step % 3], HitPoint::new(ray, seen.t));
            let counts = |id: u32, barycentric: [f32; 2]| !id.is_multiple_of(5) || barycentric[1] < 0.5;
            let expected = blocked_by_any(triangles, &shadow_ray, seen.triangle, counts);
            assert_eq!(trees.blocked(triangles, &shadow_ray, seen.triangle, &counts), expected, "{ray:?}");
            if expected { shadowed += 1 } else { lit += 1 }
        }
    }
    assert!(lit > 100 && shadowed > 100, "{lit} {shadowed}");
}

/// Vertices may be off by what trees bear, which grows cells by much more than roundings do.
#[test]
fn vertices_that_are_a_little_off_are_hit_where_they_are() {
    let mut random = Random(44);
    let ball = Mesh::bumpy_ball(Vec3::ZERO, 1.0, 24);
    let parts = [Part { mesh: ball, motion: Motion::Shaken(2e-4, DAffine3::from_rotation_y) }];
    let mut trees = TwoLevelKdTree::default();
    for time in [0.0, 0.7, 1.4, 2.1] {
        let (mesh, objects) = frame(&parts, time);
        trees.update(mesh.triangles(), &objects).expect("objects in order");
        assert_eq!(trees.counts().rebuilt, u64::from(time == 0.0));
        // To corners, where the triangles that are off lie beside what the tree's cells hold.
        let rays: Vec<_> = (0..4000)
            .map(|step| {
                let triangle = step % mesh.indices.len();
                let target = mesh.triangles().corners(triangle as u32)[step / 7 % 3].as_dvec3();
                Ray::new(target * 0.5 + random.point().as_dvec3() * 1e-3, target)
            })
            .collect();
        assert!(check(&trees, mesh.triangles(), &rays) > 3900);
    }
}

#[test]
fn what_is_not_where_its_map_says_is_built_again() {
    let ball = Mesh::bumpy_ball(Vec3::ZERO, 1.0, 8);
    let parts = [Part { mesh: ball, motion: Motion::Rigid(turning) }];
    let mut trees = TwoLevelKdTree::default();
    let mut random = Random(45);
    let (mut mesh, mut objects) = frame(&parts, 0.0);
    // What is changed, and whether the tree serves as it was built last.
    let changes: [(&str, bool); 7] = [
        ("nothing", true),
        ("a vertex", false),
        ("a vertex becomes none", false),
        ("it becomes one again", false),
        ("the map has no inverse", false),
        ("the map is none", false),
        ("nothing", false),
    ];
    trees.update(mesh.triangles(), &objects).expect("objects in order");
    for (step, (change, is_kept)) in changes.into_iter().enumerate() {
        (mesh, objects) = frame(&parts, step as f64 * 0.3);
        match change {
            "a vertex" => mesh.positions[20] *= 1.1,
            "a vertex becomes none" => mesh.positions[30] = Vec3::NAN,
            "the map has no inverse" => {
                objects[0].motion =
                    KdMotion::Rigid { world_from_object: DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0)) };
            }
            "the map is none" => {
                objects[0].motion = KdMotion::Rigid { world_from_object: DAffine3::from_scale(DVec3::NAN) };
            }
            _ => {}
        }
        trees.update(mesh.triangles(), &objects).expect("objects in order");
        trees.validate(mesh.triangles()).unwrap_or_else(|broken| panic!("{change}: {broken}"));
        assert_eq!(trees.counts().rebuilt, u64::from(!is_kept), "{change} at {step}");
        assert!(check(&trees, mesh.triangles(), &rays(&mesh, &mut random)) > 300);
    }
}

/// Two corners in one place are in no tree; apart, they must be.
#[test]
fn triangles_that_get_an_area_are_hit() {
    let mut mesh = Mesh::floor(2, 1.0);
    mesh.push([Vec3::Y, Vec3::Y, Vec3::Y + Vec3::X]);
    let objects = [KdObject {
        triangles: 0..mesh.indices.len() as u32,
        motion: KdMotion::Rigid { world_from_object: DAffine3::IDENTITY },
    }];
    let mut trees = TwoLevelKdTree::default();
    trees.update(mesh.triangles(), &objects).expect("objects in order");
    assert_eq!(trees.omitted().zero_area.count, 1);
    let place = mesh.indices[8][1] as usize;
    mesh.positions[place].z += 1e-4;
    trees.update(mesh.triangles(), &objects).expect("objects in order");
    assert_eq!((trees.omitted().total(), trees.counts().rebuilt), (0, 1));
    let ray = Ray::new(DVec3::new(0.2, 3.0, 0.00005), DVec3::NEG_Y);
    assert_eq!(trees.nearest(mesh.triangles(), &ray, &|_| true).map(|hit| hit.triangle), Some(8));
}

#[test]
fn trees_do_not_depend_on_threads() {
    let parts = parts();
    let mut first: Option<TwoLevelKdTree> = None;
    for threads in [1, 2, 3, 7] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let mut trees = TwoLevelKdTree::default();
        for time in [0.0, 0.4, 1.0] {
            let (mesh, objects) = frame(&parts, time);
            pool.install(|| trees.update(mesh.triangles(), &objects)).expect("objects in order");
        }
        assert!(first.as_ref().is_none_or(|first| trees.is_same_as(first)), "{threads} threads");
        first.get_or_insert(trees);
    }
}

#[test]
fn objects_come_and_go() {
    let mut random = Random(46);
    let mut trees = TwoLevelKdTree::default();
    assert_eq!(trees.nearest(Triangles::default(), &Ray::new(DVec3::ZERO, DVec3::X), &|_| true), None);
    trees.update(Triangles::default(), &[]).expect("no objects");
    assert_eq!(trees.nearest(Triangles::default(), &Ray::new(DVec3::ZERO, DVec3::X), &|_| true), None);
    for count in [0, 1, 60, 30, 400, 2] {
        let mut mesh = Mesh::default();
        let mut objects = Vec::new();
        for object in 0..count {
            let start = mesh.indices.len() as u32;
            mesh.append(&Mesh::soup(&mut random, object % 4, 0.1).moved(0.5, random.point() * 3.0));
            objects.push(KdObject { triangles: start..mesh.indices.len() as u32, motion: KdMotion::Deforming });
        }
        trees.update(mesh.triangles(), &objects).expect("objects in order");
        trees.validate(mesh.triangles()).expect("valid trees");
        assert_eq!((trees.counts().objects, trees.counts().rebuilt), (count as u64, count as u64));
        let rays = (0..50).map(|_| {
            let origin = (random.point() * 4.0).as_dvec3();
            Ray::new(origin, (random.point() * 3.0).as_dvec3() - origin)
        });
        check(&trees, mesh.triangles(), &rays.collect::<Vec<_>>());
    }
}

#[test]
fn impossible_objects_are_refused() {
    let mesh = Mesh::floor(2, 1.0);
    let object = |triangles: std::ops::Range<u32>| KdObject { triangles, motion: KdMotion::Static };
    let mut trees = TwoLevelKdTree::default();
    for (objects, expected) in [
        (vec![object(0..3), object(4..8)], ImpossibleObjects::Order(1)),
        (vec![object(1..8)], ImpossibleObjects::Order(0)),
        (vec![object(0..5), object(3..8)], ImpossibleObjects::Order(1)),
        (vec![object(0..5)], ImpossibleObjects::Count(5, 8)),
        (vec![object(0..9)], ImpossibleObjects::Count(9, 8)),
        (vec![], ImpossibleObjects::Count(0, 8)),
    ] {
        assert_eq!(trees.update(mesh.triangles(), &objects), Err(expected.clone()));
        assert!(expected.to_string().contains("object"));
    }
    let lazy = KdTreeOptions { lazy_below: u32::MAX, ..KdTreeOptions::DEFAULT };
    assert!(trees.set_options(lazy).is_err());
}
