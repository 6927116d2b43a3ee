use glam::{DVec3, Vec3};
use umbrage_papers::on_demand::{Answers, Costs, Error, Order, Question, Scene};
use umbrage_rays::predicate::{HitPoint, ShadowRay};
use umbrage_rays::{Hit, LightSource, Ray};

use crate::support::{Mesh, Random, blocked_by_any, blocks, grazing_rays, nearest_of_all, random_ray, scene};

const LIGHT: LightSource = LightSource::Point { position: Vec3::new(1.5, 2.5, 0.7) };

/// A ray in some direction from a hit; none for every fifth.
fn scatter(index: usize, ray: &Ray, hit: &Hit, corners: [Vec3; 3]) -> Option<Ray> {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    let normal = (b - a).cross(c - a).normalize_or(DVec3::Y);
    let turn = DVec3::new((index as f64).sin(), (2.0 * index as f64).cos(), (3.0 * index as f64).sin());
    (!index.is_multiple_of(5)).then(|| Ray::new(HitPoint::new(ray, hit.t).position + normal * 1e-3, normal + turn))
}

/// The answers of a test of every triangle.
fn truth(mesh: &Mesh, rays: &[Ray]) -> Answers {
    let nothing = || [vec![None; rays.len()], vec![None; rays.len()]];
    let mut answers = Answers { hits: nothing(), lit: nothing().map(|all| all.iter().map(Option::is_some).collect()) };
    for (index, ray) in rays.iter().enumerate() {
        let mut next = Some(*ray);
        for bounce in 0..2 {
            let Some(ray) = next.take() else { continue };
            let Some(hit) = nearest_of_all(mesh.triangles(), &ray, |_| true) else { continue };
            let shadow = ShadowRay::new(&LIGHT, HitPoint::new(&ray, hit.t));
            answers.hits[bounce][index] = Some(hit);
            answers.lit[bounce][index] = !blocked_by_any(mesh.triangles(), &shadow, hit.triangle, |_, _| true);
            next = scatter(index, &ray, &hit, mesh.triangles().corners(hit.triangle));
        }
    }
    answers
}

fn trace(scene: &Scene, rays: &[Ray], budget: u64, order: Order) -> Result<(Answers, Costs), Error> {
    scene.trace(&Question { rays, light: LIGHT, scatter: &scatter }, budget, order)
}

/// Asserts that all orders find the truth with all budgets, in parts of several sizes.
#[track_caller]
fn check(mesh: &Mesh, rays: &[Ray]) -> Answers {
    let truth = truth(mesh, rays);
    for part_bytes in [1, 1000, 5000, 1 << 20] {
        let scene = Scene::write(mesh.triangles(), part_bytes).expect("room for a file");
        assert!(scene.largest() <= (part_bytes as u64).max(72), "{} of {part_bytes}", scene.largest());
        for order in Order::ALL {
            for budget in [scene.largest(), scene.largest().max(scene.bytes() / 3), scene.bytes()] {
                let (answers, costs) = trace(&scene, rays, budget, order).expect("enough memory");
                assert_eq!(answers, truth, "{order:?}, parts of {part_bytes}, {budget} of {}", scene.bytes());
                assert!(costs.most_resident_bytes <= budget, "{order:?}: {costs:?}, {budget}");
                assert!(costs.loads <= costs.visits && costs.bytes_read >= costs.most_resident_bytes, "{costs:?}");
                if budget == scene.bytes() {
                    assert!(costs.loads <= scene.parts() as u64, "nothing is read twice: {costs:?}");
                }
            }
        }
    }
    truth
}

fn random_rays(seed: u64, count: usize) -> Vec<Ray> {
    let mut random = Random(seed);
    (0..count).map(|_| random_ray(&mut random, 2.0)).collect()
}

#[test]
fn all_orders_and_budgets_find_what_the_predicate_says() {
    let mesh = scene(&mut Random(3));
    let truth = check(&mesh, &random_rays(4, 300));
    let count = |found: &[bool]| found.iter().filter(|&&found| found).count();
    let hits = truth.hits.each_ref().map(|hits| hits.iter().flatten().count());
    assert!(hits[0] > 150 && hits[1] > 50, "{hits:?}");
    let lit = truth.lit.each_ref().map(|lit| count(lit));
    assert!((20..hits[0] - 20).contains(&lit[0]) && (10..hits[1] - 10).contains(&lit[1]), "{lit:?} of {hits:?}");
}

#[test]
fn equal_hits_go_to_the_lowest_id_and_rays_along_faces_are_not_lost() {
    let mut mesh = blocks(&mut Random(5), 60);
    // Everything twice, so that each hit is one of two.
    mesh.append(&mesh.clone());
    let mut rays = grazing_rays(mesh.triangles(), &mut Random(6), 80);
    for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
        for step in 0..20 {
            let from = DVec3::new(f64::from(step % 5) - 2.0, f64::from(step / 5) - 2.0, f64::from(step % 3) - 1.0);
            rays.push(Ray::new(from - axis * 10.0, axis));
        }
    }
    let truth = check(&mesh, &rays);
    let ids: Vec<u32> = truth.hits[0].iter().flatten().map(|hit| hit.triangle).collect();
    assert!(ids.len() > 60 && ids.iter().all(|&id| id < mesh.indices.len() as u32 / 2), "{ids:?}");
}

#[test]
fn nothing_one_triangle_and_what_is_none() {
    let rays = random_rays(7, 50);
    check(&Mesh::default(), &rays);
    check(&Mesh::default(), &[]);
    let mut mesh = Mesh::default();
    mesh.push([Vec3::new(-3.0, -3.0, 0.0), Vec3::new(3.0, -3.0, 0.0), Vec3::new(0.0, 3.0, 0.0)]);
    check(&mesh, &rays);
    let scene = Scene::write(mesh.triangles(), 1).expect("room for a file");
    assert_eq!((scene.parts(), scene.triangles(), scene.bytes()), (1, 1, 72));
    mesh.positions[0].x = f32::NAN;
    check(&mesh, &rays);
    let scene = Scene::write(mesh.triangles(), 1).expect("room for a file");
    assert_eq!((scene.parts(), scene.triangles(), scene.bytes()), (0, 0, 0));
    let broken = [
        Ray::new(DVec3::NAN, DVec3::X),
        Ray::new(DVec3::ZERO, DVec3::ZERO),
        Ray { t_max: -1.0, ..Ray::new(DVec3::ZERO, DVec3::X) },
    ];
    let mesh = Mesh::bumpy_ball(Vec3::ZERO, 1.0, 6);
    let scene = Scene::write(mesh.triangles(), 1000).expect("room for a file");
    for order in Order::ALL {
        let (answers, costs) = trace(&scene, &broken, scene.bytes(), order).expect("enough memory");
        assert!(answers.hits[0].iter().all(Option::is_none) && costs.loads == 0, "{order:?}");
    }
}

#[test]
fn less_memory_than_a_part_takes_is_refused() {
    let mesh = Mesh::bumpy_ball(Vec3::ZERO, 1.0, 6);
    let scene = Scene::write(mesh.triangles(), 1000).expect("room for a file");
    let error = trace(&scene, &random_rays(8, 3), scene.largest() - 1, Order::FirstCome).unwrap_err();
    assert!(matches!(error, Error::TooLittleMemory { largest, .. } if largest == scene.largest()), "{error}");
}

#[test]
fn queues_read_less_than_single_rays() {
    let mesh = Mesh::bumpy_ball(Vec3::ZERO, 1.0, 24);
    let rays = random_rays(9, 1500);
    let scene = Scene::write(mesh.triangles(), 4000).expect("room for a file");
    let loads = Order::ALL.map(|order| trace(&scene, &rays, scene.bytes() / 4, order).expect("enough memory").1.loads);
    let [single, first_come, benefit, generations] = loads;
    assert!(first_come < single / 4 && benefit <= first_come && generations < single / 4, "{loads:?}");
}

#[test]
fn the_same_file_is_written_for_any_order_of_triangles() {
    let mesh = Mesh::soup(&mut Random(10), 200, 0.1);
    let mut turned = mesh.clone();
    turned.indices.reverse();
    let [one, other] = [&mesh, &turned].map(|mesh| Scene::write(mesh.triangles(), 2000).expect("room for a file"));
    assert_eq!((one.parts(), one.bytes()), (other.parts(), other.bytes()));
}
