//! Lights reach exactly the points that the oracle says, for all points and lights.

use std::f32::consts::FRAC_PI_4;

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use umbrage_papers::ListedGrids;
use umbrage_rays::predicate::{HitPoint, ShadowRay};
use umbrage_rays::{
    Cone, DirectGrids, LightSource, Lit, LitBits, Masks, Receivers, Scanned, Scanner, Sides, SimdLevel, Structure as _,
    Triangles,
};
use umbrage_verify::{MIXED_SIDES, Oracle, Random, TestMesh};

use crate::frames::on_threads;
use crate::scan::meshes;

/// Point lights at points, on faces, inside, outside and far away; suns along axes and in any direction; a spot; and
/// invalid lights.
pub(crate) fn lights(mesh: &TestMesh, size: f32, middle: Vec3, random: &mut Random) -> Vec<LightSource> {
    let mut positions =
        vec![middle, middle + Vec3::new(0.3, 3.0, 0.2) * size, middle + Vec3::new(0.7, 0.4, -0.6) * (size * 1e6)];
    if let Some(&[a, b, c]) = mesh.indices.first() {
        let [a, b, c] = [a, b, c].map(|vertex| mesh.positions[vertex as usize]);
        positions.extend([a, a.midpoint(b), (a + b + c) / 3.0, a + (a - b) * 0.5]);
    }
    let mut lights: Vec<_> = positions.into_iter().map(|position| LightSource::Point { position }).collect();
    let suns = [Vec3::NEG_Y, Vec3::X, Vec3::new(1.0, -1.0, 0.0), Vec3::new(-0.3, -0.8, 0.5), random.point()];
    lights.extend(suns.map(|direction| LightSource::Directional { direction: direction.normalize() }));
    let spot = LightSource::Spot {
        position: middle + Vec3::Y * (2.0 * size),
        direction: Vec3::NEG_Y,
        inner_radians: 0.1,
        outer_radians: FRAC_PI_4,
    };
    lights.push(spot);
    let nowhere = [Vec3::NAN, Vec3::new(1.0, f32::INFINITY, 0.0)];
    lights.extend(nowhere.map(|position| LightSource::Point { position }));
    lights.extend([Vec3::ZERO, Vec3::NAN].map(|direction| LightSource::Directional { direction }));
    lights
}

/// Points on triangles in f32, with the triangle's id or without, and points beside them.
pub(crate) fn points(mesh: &TestMesh, size: f32, middle: Vec3, random: &mut Random) -> (Vec<Vec3>, Vec<u32>) {
    let (mut positions, mut own) = (vec![middle, Vec3::NAN], vec![Scanned::NONE; 2]);
    for _ in 0..200 {
        if mesh.indices.is_empty() || random.below(4) == 0 {
            positions.push(middle + random.point() * size);
            own.push(Scanned::NONE);
            continue;
        }
        let id = random.below(mesh.indices.len()) as u32;
        let Ok([a, b, c]) = mesh.triangles().usable_corners(id) else { continue };
        let (u, v) = (random.unit(), random.unit());
        positions.push(if random.below(4) == 0 { a } else { a.lerp(b, u).lerp(c, v) });
        own.push(if random.below(3) == 0 { Scanned::NONE } else { id });
    }
    (positions, own)
}

/// Points far apart among the slots of two tiles with no other points, and a tile without any.
fn in_slots(positions: &[Vec3], own: &[u32]) -> (Vec<Vec3>, Vec<u32>) {
    let (mut spread, mut of_spread) = (vec![Vec3::NAN; 3 * 4096], vec![Scanned::NONE; 3 * 4096]);
    for (number, (position, own)) in positions.iter().zip(own).enumerate() {
        (spread[number * 37], of_spread[number * 37]) = (*position, *own);
    }
    (spread, of_spread)
}

/// The oracle's answers for every n-th point.
pub(crate) struct Truth<'a> {
    lit: &'a Lit<'a>,
    lights: &'a [LightSource],
    every: usize,
    /// For each of these points whether each light reaches it.
    is_lit: Vec<Vec<bool>>,
    /// Number of points that are NaN.
    nowhere: usize,
}

impl<'a> Truth<'a> {
    pub(crate) fn of(lit: &'a Lit<'a>, lights: &'a [LightSource], every: usize) -> Self {
        let triangles = lit.triangles;
        let (oracle, count) = (Oracle::new(triangles), lit.receivers.count(triangles));
        let reaches = |light: &LightSource, at: HitPoint, own: u32| {
            let stops = |id: u32, at: [f32; 2]| {
                let is_there = lit.sides.stop_light(light, id, triangles.corners(id));
                is_there && (lit.opacity.is_opaque(id) || lit.opacity.stops(id, at))
            };
            let in_cone = Cone::of(light).is_none_or(|cone| cone.contains(at.position));
            in_cone && !oracle.blocked(&ShadowRay::new(light, at), own, stops)
        };
        let of_point = |point: usize| {
            let receiver = lit.receivers.point(triangles, point);
            lights.iter().map(|light| receiver.is_some_and(|(at, own)| reaches(light, at, own))).collect()
        };
        let is_lit = (0..count).step_by(every).collect::<Vec<_>>().into_par_iter().map(of_point).collect();
        let nowhere = (0..count).filter(|&point| lit.receivers.point(triangles, point).is_none()).count();
        Self { lit, lights, every, is_lit, nowhere }
    }

    /// Compares a scanner's answer with it.
    fn check(&self, name: &str, scanner: &mut Scanner) {
        let mut bits = LitBits::default();
        scanner.lit(self.lit, self.lights, &mut bits);
        self.compare(name, &bits);
    }

    /// Compares an answer with it.
    pub(crate) fn compare(&self, name: &str, bits: &LitBits) {
        let Self { lit, lights, .. } = self;
        assert_eq!((bits.points(), bits.lights()), (lit.receivers.count(lit.triangles), lights.len()), "{name}");
        for (number, expected) in self.is_lit.iter().enumerate() {
            let point = number * self.every;
            for (light, &expected) in expected.iter().enumerate() {
                let found = bits.is_lit(light, point);
                let (light, receiver) = (lights[light], || lit.receivers.point(lit.triangles, point));
                assert_eq!(found, expected, "{name}: {light:?} and {:?}, number {point}", receiver());
            }
        }
        assert_eq!(bits.nowhere, self.nowhere, "{name}");
    }

    /// Numbers of dark and lit pairs of a light and a point.
    fn count(&self) -> [usize; 2] {
        let lit = self.is_lit.iter().flatten().filter(|&&is_lit| is_lit).count();
        [self.is_lit.len() * self.lights.len() - lit, lit]
    }
}

#[test]
fn lights_reach_what_the_oracle_says() {
    let mut random = Random::new(21);
    let mut found = [0, 0];
    for (name, mesh, size, middle) in meshes() {
        let triangles = mesh.triangles();
        let lights = lights(&mesh, size, middle, &mut random);
        let (positions, own) = points(&mesh, size, middle, &mut random);
        let receivers = Receivers::Points { positions: &positions, own: &own };
        let mask = |id: u32, [u, v]: [f32; 2]| !id.is_multiple_of(5) || u + v < 0.5;
        let mut add = |[dark, lit]: [usize; 2]| found = [found[0] + dark, found[1] + lit];
        let plain = Lit::new(triangles, receivers);
        let truth = Truth::of(&plain, &lights, 1);
        add(truth.count());
        for level in SimdLevel::available() {
            let mut scanner = Scanner::with_level(level);
            for threads in [1, 3] {
                // In the second frame patches are others.
                on_threads(threads, || {
                    scanner.build(triangles);
                    truth.check(name, &mut scanner);
                });
            }
        }
        let mut scanner = Scanner::default();
        (0..2).for_each(|_| scanner.build(triangles));
        let mut check = |lit: Lit<'_>, lights: &[LightSource]| {
            let truth = Truth::of(&lit, lights, 1);
            truth.check(name, &mut scanner);
            add(truth.count());
        };
        check(plain, &lights[..1]);
        check(Lit { opacity: &mask, sides: MIXED_SIDES, ..plain }, &lights);
        check(Lit { sides: Sides::Front, ..plain }, &lights);
        let (positions, own) = in_slots(&positions, &own);
        check(Lit::new(triangles, Receivers::Pixels { positions: &positions, own: &own }), &lights);
        if triangles.len() < 500 {
            check(Lit::new(triangles, Receivers::Faces), &lights);
            check(Lit::new(triangles, Receivers::Samples(2)), &lights);
        }
    }
    assert!(found[0] > 10_000 && found[1] > 10_000, "{found:?} dark and lit");
}

#[test]
fn patches_of_a_structure_serve_as_well() {
    let mut random = Random::new(25);
    let (mut grids, mut listed) = (DirectGrids::default(), ListedGrids::default());
    for (name, mesh, size, middle) in meshes() {
        let triangles = mesh.triangles();
        let lights = lights(&mesh, size, middle, &mut random);
        let (positions, own) = points(&mesh, size, middle, &mut random);
        let lit = Lit::new(triangles, Receivers::Points { positions: &positions, own: &own });
        let (mut scanner, mut expected) = (Scanner::default(), LitBits::default());
        scanner.build(triangles);
        scanner.lit(&lit, &lights, &mut expected);
        grids.build(triangles);
        assert!(grids.patches().is_some() && listed.patches().is_none());
        listed.build(triangles);
        for patches in [grids.patches(), listed.patches()] {
            let mut found = LitBits::default();
            Scanner::default().lit_with(patches, &lit, &lights, &mut found);
            assert_eq!(found, expected, "{name}");
        }
    }
}

#[test]
fn so_do_they_of_many_tiles_of_points() {
    let mut random = Random::new(23);
    let mesh = TestMesh::bad_shapes(&mut random);
    let triangles = mesh.triangles();
    let each = (3 * 4096_u32).div_ceil(triangles.len() as u32);
    // Few lights, so that all threads share a light's tiles; and so many that threads take lights one by one.
    let lights = lights(&mesh, 1.0, Vec3::ZERO, &mut random);
    for (threads, lights) in [(3, &lights[..2]), (2, &lights[7..])] {
        let lit = Lit::new(triangles, Receivers::Samples(each));
        let truth = Truth::of(&lit, lights, 5);
        on_threads(threads, || {
            let mut scanner = Scanner::default();
            scanner.build(triangles);
            truth.check("bad shapes", &mut scanner);
        });
        let [dark, lit] = truth.count();
        assert!(dark > 1000 && lit > 1000, "{dark} dark, {lit} lit");
    }
}

#[test]
fn lit_bits_do_not_depend_on_threads() {
    let mut random = Random::new(22);
    let mesh = TestMesh::bad_shapes(&mut random);
    let lights = lights(&mesh, 1.0, Vec3::ZERO, &mut random);
    let mut expected: Option<LitBits> = None;
    for threads in [1, 2, 3, 7] {
        let found = on_threads(threads, || {
            let (mut scanner, mut bits) = (Scanner::default(), LitBits::default());
            scanner.build(mesh.triangles());
            scanner.lit(&Lit::new(mesh.triangles(), Receivers::Samples(8)), &lights, &mut bits);
            bits
        });
        assert!(*expected.get_or_insert_with(|| found.clone()) == found, "{threads} threads");
    }
}

/// A square in the plane y = 1 over half of a square in the plane y = 0, on which the sun falls from above.
#[test]
fn shares_of_area_are_those_of_a_half_covered_square() {
    let corners = |low: DVec3, size: [f64; 2]| {
        [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
            .map(|[x, z]| (low + DVec3::new(x * size[0], 0.0, z * size[1])).as_vec3())
    };
    let positions =
        [corners(DVec3::ZERO, [1.0, 1.0]), corners(DVec3::new(-1.0, 1.0, -1.0), [1.5, 3.0])].as_flattened().to_vec();
    let indices = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
    let triangles = Triangles { positions: &positions, indices: &indices };
    let (mut scanner, mut shares) = (Scanner::default(), Vec::new());
    scanner.build(triangles);
    let sun = LightSource::Directional { direction: Vec3::NEG_Y };
    scanner.lit_areas(triangles, Masks::default(), &[sun], 4096, &mut shares);
    // x < 1/2 is covered: a quarter of the triangle (0, 0), (1, 0), (1, 1), three quarters of the other.
    for (share, expected) in shares.iter().zip([0.75, 0.25, 1.0, 1.0]) {
        assert!((share.share - expected).abs() < 0.005, "{share:?}, not {expected}");
        assert!((0.0..0.008).contains(&share.standard_error), "{share:?}");
    }
    assert_eq!(shares[2].share.to_bits(), 1.0_f64.to_bits());
}
