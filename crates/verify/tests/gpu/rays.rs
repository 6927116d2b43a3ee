//! Rays through the hierarchy on the GPU against the CPU's, which uses the predicate: equal bit for bit.

use glam::{DVec3, Vec3};
use umbrage_gpu::rays::{Hierarchy, RayRecords, RayTracer, RayTracerOptions, RayTracerWork};
use umbrage_gpu::{Geometry, Gpu, Recorder};
use umbrage_rays::predicate::{HitPoint, ShadowRay};
use umbrage_rays::{Bvh, Hit, LightSource, Ray, SingleRays as _, Triangles};

use crate::common;
use crate::support::{
    Mesh, Random, blocks, grazing_rays, is_usable, random_ray, rays_in_planes, rays_with_intervals, scene,
};

/// A scene with its hierarchy, on CPU and GPU, and a tracer.
struct Traced {
    gpu: Gpu,
    mesh: Mesh,
    bvh: Bvh,
    geometry: Geometry,
    hierarchy: Hierarchy,
    tracer: RayTracer,
}

impl Traced {
    /// `None` without an adapter.
    fn new() -> Option<Self> {
        let gpu = common::gpu()?;
        let options = RayTracerOptions { counts: true, from_triangles: true, ..RayTracerOptions::DEFAULT };
        Some(Self {
            mesh: Mesh::default(),
            bvh: Bvh::default(),
            geometry: Geometry::new(&gpu),
            hierarchy: Hierarchy::new(&gpu),
            tracer: RayTracer::new(&gpu, options),
            gpu,
        })
    }

    /// Replaces the scene. Builds over patches follow the first one over a mesh.
    fn build(&mut self, mesh: Mesh, builds: usize) {
        self.mesh = mesh;
        let Self { gpu, mesh, bvh, geometry, hierarchy, .. } = self;
        (0..builds).for_each(|_| bvh.build(mesh.triangles()));
        geometry.write(gpu, mesh.triangles(), |_| 0).expect("room");
        hierarchy.write(gpu, bvh).expect("room");
    }

    fn triangles(&self) -> Triangles<'_> {
        self.mesh.triangles()
    }

    fn nearest_of(&mut self, records: &RayRecords, count: usize) -> Vec<Option<Hit>> {
        let Self { gpu, geometry, hierarchy, tracer, .. } = self;
        loop {
            tracer.prepare(gpu, count as u32, 1).expect("room");
            let mut recorder = Recorder::new(gpu);
            tracer.record_nearest(gpu, &mut recorder, geometry, hierarchy, records);
            let done = recorder.submit_and_wait().expect("done");
            if tracer.finish(gpu, &done).expect("done") {
                return tracer.read_hits(gpu, count).expect("read");
            }
        }
    }

    /// Compares rays, each of which passes through a triangle, with the CPU's; returns the number of hits, and the work.
    fn check(&mut self, rays: &[(Ray, Option<u32>)]) -> (usize, RayTracerWork) {
        let mut records = RayRecords::new(&self.gpu);
        records.write_rays(&self.gpu, rays.iter().copied(), 1).expect("room");
        let found = self.nearest_of(&records, rays.len());
        let mut hits = 0;
        for ((ray, own), found) in rays.iter().zip(found) {
            let expected = self.bvh.nearest(self.triangles(), ray, &|hit| Some(hit.triangle) != *own);
            assert_eq!(bits(found), bits(expected), "{ray:?} without {own:?}");
            hits += usize::from(expected.is_some());
        }
        (hits, self.tracer.work()[0])
    }

    fn blocked(&mut self, questions: &[(LightSource, HitPoint, u32)]) -> Vec<bool> {
        let Self { gpu, geometry, hierarchy, tracer, .. } = self;
        let mut records = RayRecords::new(gpu);
        records.write_shadows(gpu, questions.iter().copied(), 1).expect("room");
        loop {
            tracer.prepare(gpu, questions.len() as u32, 1).expect("room");
            let mut recorder = Recorder::new(gpu);
            tracer.record_blocked(gpu, &mut recorder, geometry, hierarchy, &records);
            let done = recorder.submit_and_wait().expect("done");
            if tracer.finish(gpu, &done).expect("done") {
                return tracer.read_shadows(gpu, questions.len()).expect("read");
            }
        }
    }

    /// Compares shadows of points with the CPU's; returns the number of shadowed ones, and the work.
    fn check_shadows(&mut self, questions: &[(LightSource, HitPoint, u32)]) -> (usize, RayTracerWork) {
        let found = self.blocked(questions);
        let mut shadowed = 0;
        for ((light, point, own), found) in questions.iter().zip(found) {
            let expected = self.bvh.blocked(self.triangles(), &ShadowRay::new(light, *point), *own, &|_, _| true);
            assert_eq!(found, expected, "{point:?} of {own}, {light:?}");
            shadowed += usize::from(expected);
        }
        (shadowed, self.tracer.work()[0])
    }

    /// A question about each ray's hit.
    fn questions(&self, rays: &[(Ray, Option<u32>)]) -> Vec<(LightSource, HitPoint, u32)> {
        const LIGHTS: [LightSource; 4] = [
            LightSource::Point { position: Vec3::new(3.0, 5.0, 2.0) },
            LightSource::Point { position: Vec3::ZERO },
            LightSource::Directional { direction: Vec3::new(0.3, -0.9, 0.1) },
            LightSource::Directional { direction: Vec3::NEG_Y },
        ];
        let hits = rays.iter().filter_map(|(ray, _)| Some((ray, self.bvh.nearest(self.triangles(), ray, &|_| true)?)));
        let questions = hits.enumerate().map(|(step, (ray, hit))| {
            let mut point = HitPoint::new(ray, hit.t);
            if step % 3 == 0 {
                // Triangles within this distance of the point don't shadow it.
                point.error = [0.001, 0.02, 0.3][step / 3 % 3];
            }
            (LIGHTS[step % 4], point, hit.triangle)
        });
        questions.collect()
    }
}

fn bits(hit: Option<Hit>) -> Option<(u32, u64, [u32; 2])> {
    hit.map(|hit| (hit.triangle, hit.t.to_bits(), hit.barycentric.map(f32::to_bits)))
}

/// Rays without a triangle of their own.
fn free(rays: impl IntoIterator<Item = Ray>) -> Vec<(Ray, Option<u32>)> {
    rays.into_iter().filter(|ray| ray.direction != DVec3::ZERO).map(|ray| (ray, None)).collect()
}

#[test]
fn hits_and_shadows_are_those_of_the_cpu() {
    let Some(mut traced) = Traced::new() else { return };
    let mut random = Random(31);
    for (mesh, builds) in [(scene(&mut random), 1), (scene(&mut random), 2), (blocks(&mut random, 80), 2)] {
        traced.build(mesh, builds);
        let mut rays = Vec::new();
        for reach in [0.5, 3.0, 40.0, 3e6, 1e15] {
            rays.extend((0..80).map(|_| random_ray(&mut random, reach)));
        }
        rays.extend(grazing_rays(traced.triangles(), &mut random, 60));
        rays.extend(rays_with_intervals(traced.triangles(), &mut random, 40));
        rays.extend(rays_in_planes(&mut random, 60));
        let mut rays = free(rays);
        for step in 0..200 {
            // From a hit on, without its triangle.
            let (ray, _) = rays[step];
            if let Some(hit) = traced.bvh.nearest(traced.triangles(), &ray, &|_| true) {
                let direction = random.point().as_dvec3();
                rays.push((Ray::new(ray.origin + ray.direction * hit.t, direction), Some(hit.triangle)));
            }
        }
        let (hits, work) = traced.check(&rays);
        assert!(hits > 400, "{hits} hits");
        assert!(work.visits.nodes > 1500 && work.visits.leaves > 1000 && work.visits.tests > 1000, "{work:?}");
        let questions = traced.questions(&rays);
        let (shadowed, work) = traced.check_shadows(&questions);
        assert!(shadowed > 100 && questions.len() - shadowed > 20, "{shadowed} of {}", questions.len());
        assert!(work.undecided_hits < 4 * questions.len() as u32 && work.is_shadow, "{work:?}");
    }
}

/// The queries of mirrors and glass: triangles whose planes touch the point's box aren't hit.
#[test]
fn rays_from_triangles_hit_what_those_of_the_cpu_do() {
    let Some(mut traced) = Traced::new() else { return };
    let mut random = Random(21);
    let mut touched = 0;
    for mesh in [scene(&mut random), blocks(&mut random, 80)] {
        traced.build(mesh, 2);
        let triangles = traced.triangles();
        let mut rays = Vec::new();
        let usable: Vec<u32> = (0..triangles.len() as u32).filter(|&id| is_usable(triangles, id)).collect();
        for step in 0..1200 {
            let id = usable[step % usable.len()];
            let [a, b, c] = triangles.corners(id).map(Vec3::as_dvec3);
            let mut ray = random_ray(&mut random, [0.5, 3.0, 40.0, 3e6][step % 4]);
            // To an edge, where the neighbour's plane is within rounding errors.
            ray.direction = a + (b - a) * f64::from(random.point().x.abs()) - ray.origin;
            // In any direction, along the triangle, and nearly along it.
            let along = (b - a) * f64::from(random.point().x) + (c - a) * f64::from(random.point().y);
            let direction = match step % 3 {
                0 => random.point().as_dvec3(),
                1 => along,
                _ => along + random.point().as_dvec3() * 1e-12,
            };
            if direction != DVec3::ZERO {
                rays.push((HitPoint::new(&ray, 1.0), direction, id));
            }
        }
        let mut records = RayRecords::new(&traced.gpu);
        records.write_rays_from(&traced.gpu, rays.iter().copied(), 1).expect("room");
        let found = traced.nearest_of(&records, rays.len());
        let triangles = traced.triangles();
        for ((point, direction, own), found) in rays.iter().zip(found) {
            let ray = Ray::new(point.position, *direction);
            let is_off = |hit: &Hit| !point.is_on(triangles.corners(hit.triangle));
            let expected = traced.bvh.nearest_from(triangles, &ray, *own, &is_off);
            assert_eq!(bits(found), bits(expected), "{ray:?} from {point:?} of {own}");
            let other = traced.bvh.nearest(triangles, &ray, &|hit| hit.triangle != *own);
            touched += usize::from(bits(other) != bits(expected));
        }
    }
    assert!(touched > 30, "{touched} rays touch another triangle");
}

#[test]
fn odd_scenes_are_those_of_the_cpu() {
    let Some(mut traced) = Traced::new() else { return };
    let mut random = Random(6);
    let of = |triangles: &[[Vec3; 3]]| {
        let mut mesh = Mesh::default();
        triangles.iter().for_each(|corners| mesh.push(*corners));
        mesh
    };
    let one = [Vec3::new(-1.0, -1.0, 0.2), Vec3::new(1.0, -1.0, 0.1), Vec3::new(0.0, 1.0, 0.0)];
    let flat = [one[0], one[1], (one[0] + one[1]) * 0.5];
    let wide = one.map(|corner| corner * 1e4);
    let through_origin = [Vec3::new(-1.0, 0.5, -1.0), Vec3::new(2.0, -1.0, 2.0), Vec3::new(-0.5, 0.5, -0.5)];
    let not_finite = [one[0], Vec3::new(f32::NAN, 0.0, f32::INFINITY), one[2]];
    let mut two_sizes = Mesh::soup(&mut random, 100, 0.1).moved(1e-4, Vec3::ZERO);
    two_sizes.append(&Mesh::floor(2, 1000.0));
    for (name, mesh, least) in [
        ("nothing", Mesh::default(), 0),
        ("one triangle", of(&[one]), 1),
        ("two in one plane", of(&[one, one]), 1),
        ("one without an area", of(&[flat]), 0),
        ("one that covers everything", of(&[wide, one]), 30),
        ("one whose plane has the origin", of(&[through_origin, one]), 1),
        ("one that isn't finite", of(&[not_finite, one]), 1),
        ("nothing that is finite", of(&[not_finite]), 0),
        ("two sizes", two_sizes, 20),
        ("tiny", Mesh::soup(&mut random, 60, 0.05).moved(1e-30, Vec3::ZERO), 0),
        ("huge", Mesh::soup(&mut random, 60, 0.05).moved(1e37, Vec3::ZERO), 0),
        ("far away", Mesh::soup(&mut random, 60, 0.05).moved(1.0, Vec3::new(148_376.0, 1234.0, -223_423.0)), 0),
    ] {
        let middle = traced_middle(&mesh);
        let size =
            mesh.positions.iter().filter(|at| at.is_finite()).map(|at| (at.as_dvec3() - middle).abs().max_element());
        let size = size.fold(0.0, f64::max).clamp(1e-37, 3e37);
        let rays = (0..60).map(|_| {
            let Ray { origin, direction, .. } = random_ray(&mut random, 3.0);
            let scale = if name == "one that covers everything" { 1.0 } else { size };
            Ray::new(origin * scale + middle, direction * scale)
        });
        let mut rays = free(rays.collect::<Vec<_>>());
        rays.extend(free((0..8).map(|step| {
            // Along axes, and in their planes.
            let direction = [DVec3::X, DVec3::NEG_Y, DVec3::Z, DVec3::new(1.0, -1.0, 0.0)][step % 4];
            Ray::new(middle - direction * size * [0.0, 2.0][step / 4], direction * size)
        })));
        traced.build(mesh, 2);
        let (hits, _) = traced.check(&rays);
        assert!(hits >= least, "{name}: {hits} hits");
        let questions = traced.questions(&rays);
        traced.check_shadows(&questions);
    }
}

/// The middle of all vertices that are finite.
fn traced_middle(mesh: &Mesh) -> DVec3 {
    let finite = mesh.positions.iter().filter(|at| at.is_finite()).map(|at| at.as_dvec3());
    let (sum, count) = finite.fold((DVec3::ZERO, 0.0), |(sum, count), at| (sum + at, count + 1.0));
    sum / f64::max(count, 1.0)
}

#[test]
fn very_many_triangles_in_one_place() {
    let Some(mut traced) = Traced::new() else { return };
    let mut mesh = Mesh::default();
    mesh.push([Vec3::ZERO, Vec3::new(1.0, 2.0, 0.5), Vec3::new(-1.0, 0.5, 3.0)]);
    // A ray tests each: lavapipe ends an invocation's loops after 65,535 turns.
    mesh.indices = vec![mesh.indices[0]; 1 << 15];
    traced.build(mesh, 1);
    let rays = [0.0, 0.001].map(|x| Ray::new(DVec3::new(0.1 + x, 0.9, -5.0), DVec3::Z));
    let (hits, work) = traced.check(&free(rays));
    assert!(hits == 2 && work.visits.tests == 2 << 15, "{hits} {work:?}");
}

#[test]
fn one_far_vertex_leaves_little_more_to_the_predicate() {
    let Some(mut traced) = Traced::new() else { return };
    let mut random = Random(11);
    let mut mesh = Mesh::default();
    for _ in 0..2000 {
        let at = random.point();
        mesh.push([at, at + 0.05 * Vec3::X, at + 0.05 * Vec3::Y]);
    }
    let rays = free((0..1000).map(|_| {
        let [origin, target] = [0; 2].map(|_| random.point().as_dvec3());
        Ray::new(origin, target - origin)
    }));
    let mut usual = None;
    for distance in [1.0, 1e6, 1e12, 1e25, 1e37] {
        let mut damaged = mesh.clone();
        damaged.positions[999] = Vec3::new(-1.0, 0.2, 0.1) * distance;
        traced.build(damaged, 2);
        let (hits, work) = traced.check(&rays);
        let (usual_work, usual_hits) = *usual.get_or_insert((work, hits));
        assert!(hits > 100 && hits.abs_diff(usual_hits) < 10, "{distance}: {hits} hits");
        let counts = |work: &RayTracerWork| [work.visits.tests, work.visits.leaves, u64::from(work.undecided_hits)];
        let (now, before) = (counts(&work), counts(&usual_work));
        let is_like = now.iter().zip(before).all(|(now, before)| *now < before + before / 4 + 600);
        assert!(is_like, "{distance}: {now:?} instead of {before:?}");
        println!("{distance}: {work:?}");
        let questions = traced.questions(&rays);
        traced.check_shadows(&questions);
    }
}
