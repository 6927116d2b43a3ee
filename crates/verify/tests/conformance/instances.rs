//! Rays and lights among placed meshes find what they find among the flattened triangles, which the oracle says.

use glam::{DAffine3, DMat3, DQuat, DVec3, Vec3};
use rayon::prelude::*;
use umbrage_rays::{
    Hit, InstanceTree, InstancedTriangles, Lit, LitBits, Placement, Ray, RayMasks, Receivers, Scanned, SimdLevel,
    Triangles,
};
use umbrage_verify::{Oracle, Random, TestMesh};

use crate::frames::on_threads;
use crate::lit::{self, Truth};
use crate::scan::{self, meshes};
use crate::single_rays::bits;

/// Transforms of all kinds: rigid, scaled, mirrored, sheared, flat, nearly flat, far away, and without numbers.
fn transform(random: &mut Random) -> DAffine3 {
    let turn = DQuat::from_axis_angle(random.point().as_dvec3().normalize(), f64::from(random.unit()) * 6.0);
    let at = random.point().as_dvec3() * 3.0;
    let power = |most: f64, random: &mut Random| f64::powf(10.0, most * f64::from(random.point().x));
    let placed = |scale: DVec3| DAffine3::from_scale_rotation_translation(scale, turn, at);
    match random.below(12) {
        0 => DAffine3::from_translation(at),
        1 => placed(DVec3::splat(power(3.0, random))),
        2 => placed(DVec3::new(power(1.0, random), -power(1.0, random), power(1.0, random))),
        3 => DAffine3 { matrix3: DMat3::from_cols_array(&[0; 9].map(|_| random.point().x.into())), translation: at },
        4 => placed(DVec3::new(1.0, 0.0, 1.0)),
        5 => placed(DVec3::new(1.0, power(9.0, random), 1.0)),
        6 => DAffine3 { translation: at * power(8.0, random), ..placed(DVec3::ONE) },
        7 => placed(DVec3::splat(power(25.0, random))),
        8 => match random.below(3) {
            0 => DAffine3 { translation: DVec3::NAN, ..DAffine3::IDENTITY },
            1 => DAffine3 { matrix3: DMat3::ZERO, translation: at },
            _ => placed(DVec3::INFINITY),
        },
        9 => DAffine3::IDENTITY,
        _ => placed(DVec3::ONE),
    }
}

/// Placements of meshes, and their triangles in the world.
struct World {
    placements: Vec<Placement>,
    flattened: TestMesh,
    /// The mask of each triangle.
    masks: Vec<u32>,
}

impl World {
    fn new(meshes: &[Triangles<'_>], count: usize, random: &mut Random) -> Self {
        let placements: Vec<_> = (0..count)
            .map(|_| Placement {
                mask: [u32::MAX, 1, 2][random.below(3)],
                ..Placement::new(random.below(meshes.len()) as u32, transform(random))
            })
            .collect();
        let (mut flattened, mut masks) = (TestMesh::default(), Vec::new());
        for placement in &placements {
            let mesh = meshes[placement.mesh as usize];
            let pose = |position: &Vec3| placement.world_from_mesh.transform_point3(position.as_dvec3()).as_vec3();
            let positions: Vec<Vec3> = mesh.positions.iter().map(pose).collect();
            // An index past the last vertex stays past all of them.
            let first = flattened.positions.len() as u32;
            let moved = |vertex: u32| if (vertex as usize) < positions.len() { first + vertex } else { u32::MAX };
            flattened.indices.extend(mesh.indices.iter().map(|corners| corners.map(moved)));
            flattened.positions.extend(positions);
            masks.resize(flattened.indices.len(), placement.mask);
        }
        Self { placements, flattened, masks }
    }
}

/// Rays to what is there, from anywhere; some from a triangle, which they don't hit.
fn rays(world: &World, random: &mut Random) -> Vec<(Ray, u32)> {
    let mut rays = Vec::new();
    for origin in scan::origins(&world.flattened, 3.0, Vec3::ZERO, random) {
        for direction in scan::directions(&world.flattened, origin, 3.0, random, 60) {
            let ray = Ray::new(origin, direction.as_dvec3());
            let part = Ray { t_min: -0.5, t_max: 1.5, ..ray };
            rays.push((if random.below(4) == 0 { part } else { ray }, Scanned::NONE));
        }
    }
    for _ in 0..100 {
        let id = random.below(world.flattened.indices.len().max(1)) as u32;
        let corners = world.flattened.indices.get(id as usize).map(|_| world.flattened.triangles().usable_corners(id));
        let Some(Ok(corners)) = corners else { continue };
        let middle = corners.iter().map(|corner| corner.as_dvec3()).sum::<DVec3>() / 3.0;
        rays.push((Ray::new(middle, random.point().as_dvec3()), id));
    }
    rays
}

#[test]
fn rays_hit_placed_meshes_where_the_oracle_says() {
    let mut random = Random::new(62);
    let all = meshes();
    let triangles: Vec<Triangles<'_>> = all.iter().map(|(_, mesh, ..)| mesh.triangles()).collect();
    let levels = SimdLevel::available();
    let mut trees: Vec<_> = levels.iter().map(|&level| InstanceTree::with_level(level)).collect();
    let (mut met, mut traced) = (0, Scanned::default());
    for round in 0..60_usize {
        let world = World::new(&triangles, [0, 1, 2, 7, 30][round % 5], &mut random);
        let scene = InstancedTriangles { meshes: &triangles, placements: &world.placements };
        let oracle = Oracle::new(world.flattened.triangles());
        let rays = rays(&world, &mut random);
        let may_hit = |hit: &Hit| round % 2 == 0 || !hit.triangle.is_multiple_of(3);
        let masks: Vec<u32> = rays.iter().map(|_| [u32::MAX, 2][random.below(2)]).collect();
        let sees = |mask: u32, hit: &Hit| world.masks[hit.triangle as usize] & mask != 0;
        let truth: Vec<Option<Hit>> = rays
            .par_iter()
            .zip(&masks)
            .map(|((ray, own), mask)| {
                let is_sound = ray.direction.is_finite() && ray.direction != DVec3::ZERO;
                let stops = |hit: &Hit| hit.triangle != *own && sees(*mask, hit) && may_hit(hit);
                oracle.nearest(ray, stops).filter(|_| is_sound)
            })
            .collect();
        met += truth.iter().flatten().count();
        for tree in &mut trees {
            tree.build(&scene);
            for (((ray, own), mask), truth) in rays.iter().zip(&masks).zip(&truth) {
                let found = tree.nearest_from(&scene, (ray, *mask), *own, &|hit| may_hit(hit));
                assert_eq!(bits(&found), bits(truth), "round {round}: {ray:?}, {:?}", world.placements);
            }
            if round % 2 == 0 {
                let plain: Vec<Ray> =
                    rays.iter().filter(|(_, own)| *own == Scanned::NONE).map(|(ray, _)| *ray).collect();
                on_threads(3, || tree.trace(&scene, &plain, RayMasks::Each(&masks), &mut traced));
                for (index, truth) in truth[..plain.len()].iter().enumerate() {
                    assert_eq!(bits(&traced.hits(index).next()), bits(truth), "round {round}: {:?}", plain[index]);
                }
            }
        }
    }
    assert!(met > 5_000, "{met} hits");
}

#[test]
fn lights_reach_placed_meshes_where_the_oracle_says() {
    let mut random = Random::new(63);
    let all = meshes();
    let triangles: Vec<Triangles<'_>> = all.iter().map(|(_, mesh, ..)| mesh.triangles()).collect();
    let mut bits = LitBits::default();
    let mut trees: Vec<_> = SimdLevel::available().iter().map(|&level| InstanceTree::with_level(level)).collect();
    for round in 0..4_usize {
        let world = World::new(&triangles, [1, 2, 3, 6][round % 4], &mut random);
        let scene = InstancedTriangles { meshes: &triangles, placements: &world.placements };
        let lights = lit::lights(&world.flattened, 3.0, Vec3::ZERO, &mut random);
        let (positions, own) = lit::points(&world.flattened, 3.0, Vec3::ZERO, &mut random);
        for receivers in
            [Receivers::Points { positions: &positions, own: &own }, Receivers::Faces, Receivers::Samples(2)]
        {
            let mask = [u32::MAX, 2][round % 2];
            let is_seen = |id: u32, _: [f32; 2]| world.masks[id as usize] & mask != 0;
            let lit = Lit { opacity: &is_seen, ..Lit::new(world.flattened.triangles(), receivers) };
            let every = receivers.count(lit.triangles).div_ceil(30).max(1);
            let truth = Truth::of(&lit, &lights, every);
            for tree in &mut trees {
                tree.build(&scene);
                on_threads(2, || tree.lit(&scene, receivers, &lights, RayMasks::All(mask), &mut bits));
                truth.compare(&format!("round {round}, {receivers:?}"), &bits);
            }
        }
    }
}

/// Meshes that change are rebuilt once they are forgotten, and placements may come and go.
#[test]
fn changed_meshes_and_placements_are_found() {
    let mut random = Random::new(64);
    let mut tree = InstanceTree::default();
    for step in 0..8_u8 {
        let ball = TestMesh::ball(2).placed(1.0 + f32::from(step), Vec3::ZERO);
        let meshes = [TestMesh::floor(2), ball];
        let meshes: Vec<_> = meshes.iter().map(TestMesh::triangles).collect();
        let world = World::new(&meshes, 1 + 3 * usize::from(step % 4), &mut random);
        let scene = InstancedTriangles { meshes: &meshes, placements: &world.placements };
        tree.forget(1);
        tree.build(&scene);
        let oracle = Oracle::new(world.flattened.triangles());
        for (ray, own) in rays(&world, &mut random) {
            let is_sound = ray.direction.is_finite() && ray.direction != DVec3::ZERO;
            let truth = oracle.nearest(&ray, |hit| hit.triangle != own).filter(|_| is_sound);
            let found = tree.nearest_from(&scene, (&ray, u32::MAX), own, &|_| true);
            assert_eq!(bits(&found), bits(&truth), "step {step}: {ray:?}");
            if let Some(hit) = found {
                let [placement, triangle] = tree.of_triangle(hit.triangle);
                let before = world.placements[..placement as usize].iter();
                let first: usize = before.map(|placement| meshes[placement.mesh as usize].len()).sum();
                assert_eq!(first + triangle as usize, hit.triangle as usize);
            }
        }
    }
}
