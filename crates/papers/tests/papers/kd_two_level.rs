//! The two-level kd-tree in its three forms, frame after frame, against the predicate asked about every triangle.

use glam::{DAffine3, DMat3, DQuat, DVec3, Vec3};
use umbrage_papers::{KdBuilder, KdMoved, KdTraversal, KdTreeOptions, TwoLevelKdTree};
use umbrage_rays::predicate::{HitPoint, ShadowRay};
use umbrage_rays::{Hit, LightSource, Parts, Ray, SingleRays as _, Structure as _, Triangles};

use crate::support::{self, Mesh, Random, blocked_by_any, is_usable, nearest_of_all as nearest};

/// A mesh in a space of its own, and its motion.
struct Part {
    mesh: Mesh,
    motion: Motion,
}

#[derive(Clone, Copy)]
enum Motion {
    Static,
    Rigid(fn(f64) -> DAffine3),
    /// As `Rigid`, with vertices displaced by this fraction of their coordinates.
    Shaken(f32, fn(f64) -> DAffine3),
    Deforming,
}

/// The world at a time, with positions in f32 as frames have them, and the part of each triangle.
fn frame(parts: &[Part], time: f64) -> (Mesh, Vec<u32>) {
    let (mut world, mut of_triangle) = (Mesh::default(), Vec::new());
    for (part, Part { mesh, motion }) in (0..).zip(parts) {
        let mut random = Random(time.to_bits());
        let mut moved = mesh.clone();
        let mut affine = |map: DAffine3, shake: f32| {
            for position in &mut moved.positions {
                let at = map.transform_point3(position.as_dvec3()).as_vec3();
                *position = at * (Vec3::ONE + random.point() * shake);
            }
        };
        match *motion {
            Motion::Static => {}
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
            }
        }
        world.append(&moved);
        of_triangle.resize(world.indices.len(), part);
    }
    (world, of_triangle)
}

fn turning(time: f64) -> DAffine3 {
    let turned = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), time * 2.0);
    DAffine3::from_scale_rotation_translation(DVec3::new(1.0, 0.5, 1.5), turned, DVec3::new(time.sin(), 0.3, -time))
}

/// A turn by quarters, so that axes stay axes.
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

const ALL_MOVED: [KdMoved; 3] = [KdMoved::Rebuild, KdMoved::Transform, KdMoved::Enclose];

/// Each part is an object.
fn update(trees: &mut TwoLevelKdTree, mesh: &Mesh, of_triangle: &[u32]) {
    trees.update(mesh.triangles(), Parts { of_triangle, objects: &[] });
    trees.check(mesh.triangles()).unwrap_or_else(|broken| panic!("{broken}"));
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
    for (options, moved) in options.into_iter().flat_map(|options| ALL_MOVED.map(|moved| (options, moved))) {
        let mut trees = TwoLevelKdTree::new(moved);
        trees.set_options(options).expect("possible options");
        let mut hits = 0;
        for (step, time) in [0.0, 1.0, 1.3, 2.0, 2.9].into_iter().enumerate() {
            let (mesh, of_triangle) = frame(&parts, time);
            update(&mut trees, &mesh, &of_triangle);
            let counts = trees.counts();
            // The deforming part. Vertices of a rigid part that have no position never get one.
            let rebuilt = if step == 0 { 8 } else { 1 };
            assert!(moved != KdMoved::Transform || counts.rebuilt == rebuilt, "{time}: {counts:?}");
            assert!(moved != KdMoved::Rebuild || counts.moved == 0, "{time}: {counts:?}");
            assert_eq!(*trees.omitted(), mesh.triangles().omitted());
            hits += check(&trees, mesh.triangles(), &rays(&mesh, &mut random));
        }
        assert!(hits > 2000, "{hits}");
    }
}

#[test]
fn points_are_shadowed_and_hits_pass_through() {
    let parts = parts();
    let mut random = Random(43);
    let lights = [
        LightSource::Point { position: Vec3::new(3.0, 5.0, 2.0) },
        LightSource::Directional { direction: Vec3::new(0.3, -0.9, 0.1).normalize() },
        LightSource::Directional { direction: Vec3::NEG_Y },
    ];
    for moved in ALL_MOVED {
        let mut trees = TwoLevelKdTree::new(moved);
        let (mut lit, mut shadowed) = (0, 0);
        for time in [0.0, 0.5, 1.7] {
            let (mesh, of_triangle) = frame(&parts, time);
            let triangles = mesh.triangles();
            update(&mut trees, &mesh, &of_triangle);
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
}

/// Rays to corners: displaced triangles there lie outside of the tree's cells.
fn to_corners(mesh: &Mesh, random: &mut Random) -> Vec<Ray> {
    let ray = |step: usize| {
        let triangle = step % mesh.indices.len();
        let target = mesh.triangles().corners(triangle as u32)[step / 7 % 3].as_dvec3();
        Ray::new(target * 0.5 + random.point().as_dvec3() * 1e-3, target)
    };
    (0..4000).map(ray).collect()
}

/// Vertices may be displaced as far as trees allow, which grows cells by much more than roundings do.
#[test]
fn vertices_that_are_a_little_off_are_hit_where_they_are() {
    let mut random = Random(44);
    let ball = Mesh::bumpy_ball(Vec3::ZERO, 1.0, 24);
    let parts = [Part { mesh: ball, motion: Motion::Shaken(2e-4, DAffine3::from_rotation_y) }];
    let mut trees = TwoLevelKdTree::new(KdMoved::Transform);
    for time in [0.0, 0.7, 1.4, 2.1] {
        let (mesh, of_triangle) = frame(&parts, time);
        update(&mut trees, &mesh, &of_triangle);
        assert_eq!(trees.counts().rebuilt, u64::from(time == 0.0));
        assert!(check(&trees, mesh.triangles(), &to_corners(&mesh, &mut random)) > 3900);
    }
}

/// Boxes that were prepared serve the poses between, and are enlarged if vertices leave them.
#[test]
fn what_waves_stays_in_its_boxes_or_is_enclosed() {
    let mut random = Random(47);
    let ball = Mesh::bumpy_ball(Vec3::ZERO, 1.0, 24);
    let at = |time: f32| {
        let mut mesh = ball.clone();
        for position in &mut mesh.positions {
            let wave = Vec3::new((position.y * 2.0 + time).sin(), 0.0, (position.x + time * 2.0).cos()) * 0.02;
            *position = glam::Quat::from_rotation_y(time) * (*position + wave) + Vec3::X * time;
        }
        mesh
    };
    let whole = vec![0; ball.indices.len()];
    let poses: Vec<_> = (0..40).map(|step| at(step as f32 * 0.16).positions).collect();
    let mut prepared = TwoLevelKdTree::new(KdMoved::Enclose);
    prepared.prepare(ball.triangles(), Parts { of_triangle: &whole, objects: &[] }, &poses);
    let mut learning = TwoLevelKdTree::new(KdMoved::Enclose);
    let mut learnt = 0;
    for step in 0..60 {
        let mesh = at(step as f32 * 0.11);
        for trees in [&mut prepared, &mut learning] {
            update(trees, &mesh, &whole);
            assert!(check(trees, mesh.triangles(), &to_corners(&mesh, &mut random)[..200]) > 100);
        }
        let counts = prepared.counts();
        assert_eq!((counts.rebuilt, counts.moved), (0, 1), "{step}");
        learnt += learning.counts().rebuilt;
    }
    assert!((2..30).contains(&learnt), "{learnt}");
}

#[test]
fn what_no_map_takes_back_is_built_again() {
    let ball = Mesh::bumpy_ball(Vec3::ZERO, 1.0, 8);
    let parts = [Part { mesh: ball, motion: Motion::Rigid(turning) }];
    for moved in [KdMoved::Transform, KdMoved::Enclose] {
        let mut trees = TwoLevelKdTree::new(moved);
        let mut random = Random(45);
        let (mesh, of_triangle) = frame(&parts, 0.0);
        update(&mut trees, &mesh, &of_triangle);
        // The change, and whether the tree still serves.
        let changes: [(&str, bool); 7] = [
            ("nothing", true),
            ("a vertex", false),
            ("a vertex becomes none", false),
            ("it becomes one again", false),
            ("all is flat", false),
            ("all is one point", false),
            ("nothing", false),
        ];
        for (step, (change, is_kept)) in changes.into_iter().enumerate() {
            let (mut mesh, _) = frame(&parts, step as f64 * 0.3);
            match change {
                "a vertex" => mesh.positions[20] *= 1.1,
                "a vertex becomes none" => mesh.positions[30] = Vec3::NAN,
                "all is flat" => mesh.positions.iter_mut().for_each(|position| position.z = 0.0),
                "all is one point" => mesh.positions.fill(Vec3::ONE),
                _ => {}
            }
            update(&mut trees, &mesh, &of_triangle);
            assert_eq!(trees.counts().rebuilt, u64::from(!is_kept), "{change} at {step}");
            if change != "all is one point" {
                assert!(check(&trees, mesh.triangles(), &rays(&mesh, &mut random)) > 200, "{change}");
            }
        }
    }
}

/// Triangles with two corners in one place are in no tree; once the corners part, they must be.
#[test]
fn triangles_that_get_an_area_are_hit() {
    let mut mesh = Mesh::floor(2, 1.0);
    mesh.push([Vec3::Y, Vec3::Y, Vec3::Y + Vec3::X]);
    let mut trees = TwoLevelKdTree::new(KdMoved::Transform);
    update(&mut trees, &mesh, &[]);
    assert_eq!(trees.omitted().zero_area.count, 1);
    let place = mesh.indices[8][1] as usize;
    mesh.positions[place].z += 1e-4;
    update(&mut trees, &mesh, &[]);
    assert_eq!((trees.omitted().total(), trees.counts().rebuilt), (0, 1));
    let ray = Ray::new(DVec3::new(0.2, 3.0, 0.00005), DVec3::NEG_Y);
    assert_eq!(trees.nearest(mesh.triangles(), &ray, &|_| true).map(|hit| hit.triangle), Some(8));
}

#[test]
fn trees_do_not_depend_on_threads() {
    let parts = parts();
    for moved in ALL_MOVED {
        let mut first: Option<TwoLevelKdTree> = None;
        for threads in [1, 2, 3, 7] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            let mut trees = TwoLevelKdTree::new(moved);
            for time in [0.0, 0.4, 1.0] {
                let (mesh, of_triangle) = frame(&parts, time);
                pool.install(|| update(&mut trees, &mesh, &of_triangle));
            }
            assert!(first.as_ref().is_none_or(|first| trees.is_same_as(first)), "{threads} threads");
            first.get_or_insert(trees);
        }
    }
}

#[test]
fn objects_come_and_go() {
    let mut random = Random(46);
    let mut trees = TwoLevelKdTree::new(KdMoved::Transform);
    assert_eq!(trees.nearest(Triangles::default(), &Ray::new(DVec3::ZERO, DVec3::X), &|_| true), None);
    update(&mut trees, &Mesh::default(), &[]);
    assert_eq!(trees.nearest(Triangles::default(), &Ray::new(DVec3::ZERO, DVec3::X), &|_| true), None);
    for count in [0, 1, 60, 30, 400, 2] {
        let mut mesh = Mesh::default();
        let mut of_triangle = Vec::new();
        for object in 0..count {
            mesh.append(&Mesh::soup(&mut random, object % 4 + 1, 0.1).moved(0.5, random.point() * 3.0));
            of_triangle.resize(mesh.indices.len(), object as u32);
        }
        // Ids of parts in reverse order.
        of_triangle.reverse();
        update(&mut trees, &mesh, &of_triangle);
        assert_eq!((trees.counts().objects, trees.counts().rebuilt), (count as u64, count as u64));
        let rays = (0..50).map(|_| {
            let origin = (random.point() * 4.0).as_dvec3();
            Ray::new(origin, (random.point() * 3.0).as_dvec3() - origin)
        });
        check(&trees, mesh.triangles(), &rays.collect::<Vec<_>>());
    }
}

/// Odd parts: too few, none of an object, or others than before.
#[test]
fn any_parts_will_do() {
    let mut random = Random(48);
    let mesh = Mesh::bumpy_ball(Vec3::ZERO, 1.0, 8);
    let some: Vec<u32> = (0..mesh.indices.len() as u32).map(|id| id * 7 % 5).collect();
    for moved in ALL_MOVED {
        let mut trees = TwoLevelKdTree::new(moved);
        let is_by_part = moved == KdMoved::Enclose;
        for (of_triangle, objects, expected) in [
            (&some[..], &[0, 1, 0, 1, 0][..], if is_by_part { 5 } else { 2 }),
            (&some[..9], &[], 1),
            (&some[..], &[3], 5 - u64::from(!is_by_part)),
            (&[], &[1, 2], 1),
        ] {
            trees.update(mesh.triangles(), Parts { of_triangle, objects });
            trees.check(mesh.triangles()).expect("valid trees");
            assert_eq!(trees.counts().objects, expected);
            check(&trees, mesh.triangles(), &rays(&mesh, &mut random));
        }
        let lazy = KdTreeOptions { lazy_below: u32::MAX, ..KdTreeOptions::DEFAULT };
        assert!(trees.set_options(lazy).is_err());
    }
}
