//! Rays of all kinds, by each traversal.

use glam::{DVec3, Vec3};
use umbrage_gpu::rays::{RayRecords, RayTracer, RayTracerWork};
use umbrage_papers::{KdLayout, KdTracerOptions, KdTreeOptions};
use umbrage_rays::predicate::{HitPoint, ShadowRay};
use umbrage_rays::{LightSource, Ray, SingleRays as _};

use super::support::{Mesh, Random, blocks, grazing_rays, random_ray, rays_in_planes, rays_with_intervals, scene};
use super::{Device, Scene, bits, blocked, check, device, free, nearest_of, walks};

#[test]
fn nearest_hits_are_those_of_the_cpu_each_way() {
    let Some(mut device) = device() else { return };
    let Device { gpu, frame } = &mut *device;
    let tracer = frame.tracer_mut();
    let mut random = Random(1);
    let options = KdTreeOptions::DEFAULT;
    let mixed = Scene::new(gpu, scene(&mut random), options);
    let flat = Scene::new(gpu, blocks(&mut random, 80), KdTreeOptions { layout: KdLayout::Subtrees, ..options });
    let mut of_mixed = Vec::new();
    for reach in [0.5, 3.0, 40.0, 3e6, 1e15] {
        of_mixed.extend((0..80).map(|_| random_ray(&mut random, reach)));
    }
    of_mixed.extend(grazing_rays(mixed.mesh.triangles(), &mut random, 60));
    of_mixed.extend(rays_with_intervals(mixed.mesh.triangles(), &mut random, 40));
    let of_flat = free(rays_in_planes(&mut random, 150));
    // From a hit on, without its triangle.
    let mut of_mixed = free(of_mixed);
    for step in 0..200 {
        let (ray, _) = of_mixed[step];
        if let Some(hit) = mixed.tree.nearest(mixed.mesh.triangles(), &ray, &|_| true) {
            let direction = random.point().as_dvec3();
            of_mixed.push((Ray::new(ray.origin + ray.direction * hit.t, direction), Some(hit.triangle)));
        }
    }
    for options in walks() {
        tracer.set_options(gpu, options);
        let (hits, work) = check(gpu, tracer, &mixed, &of_mixed);
        assert!(hits > 400, "{hits} hits");
        assert!(work.visits.nodes > 5000 && work.visits.leaves > 1000 && work.visits.tests > 1000, "{work:?}");
        let (hits, work) = check(gpu, tracer, &flat, &of_flat);
        assert!(hits > 300 && work.undecided_hits > 300, "{hits} hits, {work:?}");
    }
}

/// The queries of mirrors and glass: triangles whose planes touch the point's box aren't hit.
#[test]
fn rays_from_triangles_hit_what_those_of_the_cpu_do() {
    let Some(device) = device() else { return };
    let gpu = &device.gpu;
    let mut random = Random(21);
    let options = KdTracerOptions { from_triangles: true, ..KdTracerOptions::DEFAULT };
    let mut tracer = RayTracer::new(gpu, options);
    let mut touched = 0;
    for mesh in [scene(&mut random), blocks(&mut random, 80)] {
        let scene = Scene::new(gpu, mesh, KdTreeOptions::DEFAULT);
        let triangles = scene.mesh.triangles();
        let mut rays = Vec::new();
        for reach in [0.5, 3.0, 40.0, 3e6] {
            for step in 0..400 {
                let mut ray = random_ray(&mut random, reach);
                if step % 2 == 0 {
                    // To an edge, where the neighbour's plane is within rounding errors.
                    let [a, b, _] = triangles.corners(step / 2 % triangles.len() as u32).map(Vec3::as_dvec3);
                    ray.direction = a + (b - a) * f64::from(random.point().x.abs()) - ray.origin;
                }
                let hit = match step % 2 {
                    0 => Some((1.0, step / 2 % triangles.len() as u32)),
                    _ => scene.tree.nearest(triangles, &ray, &|_| true).map(|hit| (hit.t, hit.triangle)),
                };
                let Some((t, id)) = hit else { continue };
                let [a, b, c] = triangles.corners(id).map(Vec3::as_dvec3);
                // In any direction, along the triangle, and nearly along it.
                let along = (b - a) * f64::from(random.point().x) + (c - a) * f64::from(random.point().y);
                let direction = match step / 2 % 3 {
                    0 => random.point().as_dvec3(),
                    1 => along,
                    _ => along + random.point().as_dvec3() * 1e-12,
                };
                rays.push((HitPoint::new(&ray, t), direction, id));
            }
        }
        rays.retain(|(_, direction, _)| *direction != DVec3::ZERO);
        let mut records = RayRecords::new(gpu);
        records.write_rays_from(gpu, rays.iter().copied(), tracer.options().lanes()).expect("room");
        let found = nearest_of(gpu, &mut tracer, &scene, &records, rays.len());
        let mut hits = 0;
        for ((point, direction, own), found) in rays.iter().zip(found) {
            let ray = Ray::new(point.position, *direction);
            let expected =
                scene.tree.nearest_from(triangles, &ray, *own, &|hit| !point.is_on(triangles.corners(hit.triangle)));
            assert_eq!(bits(found), bits(expected), "{ray:?} from {point:?} of {own}");
            let other = scene.tree.nearest(triangles, &ray, &|hit| hit.triangle != *own);
            hits += usize::from(expected.is_some());
            touched += usize::from(bits(other) != bits(expected));
        }
        assert!(hits > 200, "{hits} hits");
    }
    assert!(touched > 30, "{touched} rays touch another triangle");
}

#[test]
fn invocations_in_step_take_as_many_steps_as_the_slowest() {
    let Some(mut device) = device() else { return };
    let Device { gpu, frame } = &mut *device;
    let tracer = frame.tracer_mut();
    let mut random = Random(3);
    let scene = Scene::new(gpu, scene(&mut random), KdTreeOptions::DEFAULT);
    let rays = free((0..75).map(|_| random_ray(&mut random, 3.0)).collect::<Vec<_>>());
    let used = |work: &RayTracerWork| work.visits.nodes + work.visits.tests;
    for options in walks() {
        tracer.set_options(gpu, options);
        let (_, together) = check(gpu, tracer, &scene, &rays);
        if options.packet.is_some() {
            let share = together.share_in_use().expect("counted");
            assert!(share > 0.02 && share <= 1.0 && together.steps % u64::from(options.lanes()) == 0, "{together:?}");
            continue;
        }
        let alone: Vec<u64> = rays.iter().map(|ray| used(&check(gpu, tracer, &scene, &[*ray]).1)).collect();
        assert_eq!(used(&together), alone.iter().sum::<u64>());
        let slowest = alone.chunks(32).map(|rays| 32 * rays.iter().max().expect("not empty"));
        assert_eq!(together.steps, slowest.sum::<u64>(), "{options:?}");
    }
}

#[test]
fn shadows_are_those_of_the_cpu_each_way() {
    let Some(mut device) = device() else { return };
    let Device { gpu, frame } = &mut *device;
    let tracer = frame.tracer_mut();
    let mut random = Random(8);
    let lights = [
        LightSource::Point { position: Vec3::new(3.0, 5.0, 2.0) },
        LightSource::Point { position: Vec3::new(0.1, 0.3, 0.2) },
        LightSource::Directional { direction: Vec3::new(0.3, -0.9, 0.1).normalize() },
        LightSource::Directional { direction: Vec3::NEG_Y },
    ];
    for mesh in [scene(&mut random), blocks(&mut random, 60)] {
        let scene = Scene::new(gpu, mesh, KdTreeOptions::DEFAULT);
        let triangles = scene.mesh.triangles();
        let mut rays: Vec<Ray> = (0..500).map(|_| random_ray(&mut random, 4.0)).collect();
        rays.extend(rays_in_planes(&mut random, 40));
        let rays = free(rays);
        let seen = rays.iter().filter_map(|(ray, _)| Some((ray, scene.tree.nearest(triangles, ray, &|_| true)?)));
        let questions: Vec<_> = seen
            .enumerate()
            .map(|(step, (ray, hit))| {
                let mut point = HitPoint::new(ray, hit.t);
                if step % 3 == 0 {
                    // Triangles within this distance of the point don't shadow it.
                    point.error = [0.001, 0.02, 0.3][step / 3 % 3];
                }
                (lights[step % 4], point, hit.triangle)
            })
            .collect();
        let expected: Vec<bool> = questions
            .iter()
            .map(|&(light, point, own)| {
                scene.tree.blocked(triangles, &ShadowRay::new(&light, point), own, &|_, _| true)
            })
            .collect();
        let shadowed = expected.iter().filter(|&&blocked| blocked).count();
        assert!(shadowed > 100 && expected.len() - shadowed > 20, "{shadowed} of {}", expected.len());
        for options in walks() {
            tracer.set_options(gpu, options);
            let found = blocked(gpu, tracer, &scene, &questions);
            for ((question, expected), found) in questions.iter().zip(&expected).zip(&found) {
                assert_eq!(found, expected, "{question:?}, {options:?}");
            }
            let work = tracer.work()[0];
            assert!(
                work.undecided_hits < 4 * questions.len() as u32 && work.is_shadow && work.visits.tests > 1000,
                "{work:?}"
            );
        }
    }
}

#[test]
fn flat_huge_tiny_and_far_scenes_are_those_of_the_cpu() {
    let Some(mut device) = device() else { return };
    let Device { gpu, frame } = &mut *device;
    let tracer = frame.tracer_mut();
    let mut random = Random(6);
    let mut line = Mesh::default();
    line.push([Vec3::ZERO, Vec3::X, Vec3::X * 2.0]);
    let mut two_sizes = Mesh::soup(&mut random, 100, 0.1).moved(1e-4, Vec3::ZERO);
    two_sizes.append(&Mesh::floor(2, 1000.0));
    let meshes = [Mesh::default(), line, Mesh::floor(9, 2.0), Mesh::soup(&mut random, 60, 0.05), two_sizes];
    for mesh in &meshes {
        for (scale, offset) in [
            (1.0, Vec3::ZERO),
            (1e-26, Vec3::ZERO),
            (1e-30, Vec3::ZERO),
            (1e30, Vec3::ZERO),
            (1e38, Vec3::ZERO),
            (1.0, Vec3::new(148_376.0, 1234.0, -223_423.0)),
            (1.0, Vec3::new(3e8, 0.0, 0.0)),
        ] {
            let scene = Scene::new(gpu, mesh.moved(scale, offset), KdTreeOptions::DEFAULT);
            let rays = (0..60).map(|_| {
                let Ray { origin, direction, .. } = random_ray(&mut random, 3.0);
                let scale = f64::from(scale);
                Ray::new(origin * scale + offset.as_dvec3(), direction * scale)
            });
            let rays = free(rays.collect::<Vec<_>>());
            let (hits, _) = check(gpu, tracer, &scene, &rays);
            assert!(hits > 0 || mesh.indices.len() < 2 || offset.x > 1e8 || scale > 1e37, "{scale} {offset}");
        }
    }
}

#[test]
fn trees_are_taken_over_again_for_each_frame() {
    let Some(mut device) = device() else { return };
    let Device { gpu, frame } = &mut *device;
    let tracer = frame.tracer_mut();
    let mut random = Random(4);
    let mut scene = Scene::new(gpu, Mesh::default(), KdTreeOptions::DEFAULT);
    for (count, layout) in [(30, KdLayout::Subtrees), (300, KdLayout::DepthFirst), (40, KdLayout::Subtrees)] {
        let options = KdTreeOptions { layout, ..KdTreeOptions::DEFAULT };
        scene.mesh = Mesh::soup(&mut random, count, 0.2);
        scene.tree.set_options(options).expect("possible options");
        scene.tree.build(scene.mesh.triangles());
        scene.geometry.write(gpu, scene.mesh.triangles(), |_| 0).expect("room");
        scene.nodes.write(gpu, &scene.tree).expect("room");
        let rays = free((0..100).map(|_| random_ray(&mut random, 3.0)).collect::<Vec<_>>());
        let (hits, _) = check(gpu, tracer, &scene, &rays);
        assert!(hits > 2, "{hits} hits of {count} triangles");
    }
}

#[test]
fn lists_that_overflow_are_done_again() {
    let Some(mut device) = device() else { return };
    let Device { gpu, frame } = &mut *device;
    let tracer = frame.tracer_mut();
    // So many triangles in one place that each ray leaves hundreds undecided.
    let mut mesh = Mesh::default();
    mesh.push([Vec3::ZERO, Vec3::new(1.0, 2.0, 0.5), Vec3::new(-1.0, 0.5, 3.0)]);
    mesh.indices = vec![mesh.indices[0]; 300];
    let scene = Scene::new(gpu, mesh, KdTreeOptions::DEFAULT);
    let rays =
        (0..100).map(|step| Ray::new(DVec3::new(0.1, 0.9, -5.0), DVec3::new(-0.0001 * f64::from(step), 0.0, 1.0)));
    let (hits, work) = check(gpu, tracer, &scene, &free(rays));
    assert!(hits > 20 && work.undecided_hits > 20 * 300, "{hits} {work:?}");
}

#[test]
fn any_number_of_rays_is_answered() {
    let Some(mut device) = device() else { return };
    let Device { gpu, frame } = &mut *device;
    let tracer = frame.tracer_mut();
    let mut random = Random(5);
    let scene = Scene::new(gpu, scene(&mut random), KdTreeOptions::DEFAULT);
    for options in [walks()[4], walks()[7]] {
        tracer.set_options(gpu, options);
        for count in [0, 1, 63, 64, 65, 1000, 3] {
            let rays = free((0..count).map(|_| random_ray(&mut random, 3.0)).collect::<Vec<_>>());
            check(gpu, tracer, &scene, &rays);
        }
    }
}
