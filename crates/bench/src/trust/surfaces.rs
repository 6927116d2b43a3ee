//! Surfaces that are close, tiny, far or seen along: each has to be where it is.

use anyhow::Result;
use glam::{DVec3, Vec3};
use umbrage::Structure;
use umbrage::rays::predicate::{HitPoint, ShadowRay};
use umbrage::rays::{Camera, LightSource, Projection, Ray, SeenPixels, Shot, Sides, SingleRays, Triangles, View};
use umbrage_verify::structures::STRUCTURES;
use umbrage_verify::{Oracle, TestMesh};

use super::rays::{asked, number, single_rays, sums};
use super::{Effort, Finding};

pub(super) fn layers(effort: &Effort) -> Result<Finding> {
    const LAYERS: u64 = 10;
    let rays = effort.of(10_000);
    let mut text = format!(
        "Of {LAYERS} layers, one behind the other in a scene of size one, those that are found by going on from hit to hit \
         ({} rays for each gap and structure):\n\n| gap |",
        number(rays)
    );
    let (mut found_all, mut line) = (true, "| found |".to_owned());
    for exponent in 1..=8 {
        let gap = 10.0_f32.powi(-exponent);
        let mut mesh = TestMesh::default();
        for layer in 0..LAYERS {
            let at = |x: f32, y: f32| Vec3::new(x, y, -(layer as f32) * gap);
            mesh.quad([at(-2.0, -2.0), at(2.0, -2.0), at(2.0, 2.0), at(-2.0, 2.0)]);
        }
        let found = sums(&mesh, effort, rays, |structure, triangles, random| {
            let origin = DVec3::new(f64::from(random.unit()) - 0.5, 0.3, 1.0);
            let ray = Ray::new(origin, (random.point() * 0.2 - Vec3::Z).as_dvec3());
            met_in_turn(structure, triangles, ray)
        })?;
        let mean = found as f64 / (4 * rays) as f64;
        found_all &= found == 4 * LAYERS * rays;
        text += &format!(" 1e-{exponent} |");
        line += &format!(" {mean} |");
    }
    text += &format!("\n|---|{}\n{line}", "---|".repeat(8));
    Ok(Finding::new(found_all, text))
}

/// Number of hits of a ray, each found behind the last.
fn met_in_turn(structure: &dyn SingleRays, triangles: Triangles<'_>, mut ray: Ray) -> u64 {
    let mut met = 0;
    while let Some(hit) = structure.nearest(triangles, &ray, &|_| true) {
        (met, ray.t_min) = (met + 1, hit.t);
    }
    met
}

pub(super) fn shells(effort: &Effort) -> Result<Finding> {
    const GAP: f32 = 4e-5;
    let (mut shells, outer) = (TestMesh::ball(3), TestMesh::ball(3).placed(1.0 + GAP, Vec3::ZERO));
    let (inner, rays) = (shells.indices.len() as u32, effort.of(100_000));
    shells.append(&outer);
    let light = LightSource::Point { position: Vec3::new(0.0, 5.0, 0.0) };
    let wrong = sums(&shells, effort, rays, |structure, triangles, random| {
        let camera = DVec3::new(0.0, 4.0, 0.0);
        let ray = Ray::new(camera, (random.point() * 0.35).with_y(0.8).as_dvec3() - camera);
        let Some(hit) = structure.nearest(triangles, &ray, &|_| true) else { return 1 };
        let is_lit = |t: f64, own: u32| {
            !structure.blocked(triangles, &ShadowRay::new(&light, HitPoint::new(&ray, t)), own, &|_, _| true)
        };
        let below = structure.nearest(triangles, &ray, &|hit| hit.triangle < inner);
        let is_dark_below = below.is_some_and(|below| !is_lit(below.t, below.triangle));
        u64::from(hit.triangle < inner || !is_lit(hit.t, hit.triangle) || !is_dark_below)
    })?;
    let text = format!(
        "Two balls of size one, 4e-5 apart. For {wrong} of {} rays and four structures the inner one shows through, or is \
         lit, or the outer one shadows itself.",
        number(rays)
    );
    Ok(Finding::new(wrong == 0, text))
}

pub(super) fn far_and_tiny(effort: &Effort) -> Result<Finding> {
    const AWAY: f64 = 1e6;
    let (mut mesh, mut random) = (TestMesh::default(), effort.random());
    for _ in 0..1000 {
        let at = random.point();
        mesh.push([(); 3].map(|()| at + random.point() * 1e-6));
    }
    let (oracle, rays) = (Oracle::new(mesh.triangles()), effort.of(100_000));
    let wrong = sums(&mesh, effort, rays, |structure, triangles, random| {
        let origin = random.point().as_dvec3().normalize() * AWAY;
        let corners = triangles.corners(random.below(triangles.len()) as u32).map(Vec3::as_dvec3);
        let target = (corners[0] + corners[1] + corners[2]) / 3.0;
        let ray = Ray::new(origin, target - origin);
        u64::from(structure.nearest(triangles, &ray, &|_| true) != oracle.nearest(&ray, |_| true))
    })?;
    let text = format!(
        "{wrong} of {} rays at the middles of triangles of a size of 1e-6, from 1e6 away, through four structures, hit \
         anything but what the oracle says, at its t to the last bit.",
        number(rays)
    );
    Ok(Finding::new(wrong == 0, text))
}

pub(super) fn closed(effort: &Effort) -> Result<Finding> {
    let side = effort.side(512, 16);
    let (mut holes, mut pixels, mut seen) = (0, 0, SeenPixels::default());
    let places =
        [(1.0, Vec3::ZERO), (1e-6, Vec3::ZERO), (1e6, Vec3::ZERO), (50.0, Vec3::new(148_376.0, 1_234.0, -223_423.0))];
    for (scale, position) in places {
        for mesh in [TestMesh::ball(4), TestMesh::bumpy_ball(1.0, 64)] {
            let mesh = mesh.placed(scale, position);
            for (_, make) in STRUCTURES {
                let mut structure = make(umbrage::rays::SimdLevel::default());
                structure.build(mesh.triangles());
                for (right, up) in
                    [(Vec3::X, Vec3::Y), (Vec3::NEG_Z, Vec3::Y), (Vec3::X, Vec3::Z), (Vec3::NEG_X, Vec3::Y)]
                {
                    let projection = Projection::Perspective { tan_half_height: 1.0 };
                    let position = position + Vec3::new(0.1, -0.2, 0.05) * scale;
                    let camera = Camera { position, right, up, forward: -right.cross(up), projection };
                    let view = View { camera, width: side, height: side };
                    let shot = Shot { sides: Sides::Both, ..Shot::new(mesh.triangles(), view) };
                    structure.see(&shot, &mut seen)?;
                    holes += (0..side * side)
                        .filter(|at| seen.triangle_at(at % side, at / side) == SeenPixels::NONE)
                        .count();
                    pixels += u64::from(side * side);
                }
            }
        }
    }
    let text = format!(
        "{holes} of {} pixels show a hole in closed bodies of four scales, near and far, seen from their insides through {} \
         structures and options.",
        number(pixels),
        STRUCTURES.len()
    );
    Ok(Finding::new(holes == 0, text))
}

pub(super) fn in_planes(effort: &Effort) -> Result<Finding> {
    let mut mesh = TestMesh::floor(8);
    // Walls on the floor's lattice, along both other axes.
    for step in -4..=4 {
        let at = |x: f32, y: f32, z: f32| Vec3::new(x, y, z) * 0.5;
        let step = step as f32;
        mesh.quad([at(step, -2.0, -4.0), at(step, -2.0, 4.0), at(step, 2.0, 4.0), at(step, 2.0, -4.0)]);
        mesh.quad([at(-4.0, -2.0, step), at(4.0, -2.0, step), at(4.0, 2.0, step), at(-4.0, 2.0, step)]);
    }
    let (oracle, rays) = (Oracle::new(mesh.triangles()), effort.of(200_000));
    let wrong = sums(&mesh, effort, rays, |structure, triangles, random| {
        let mut lattice = || f64::from(random.below(17) as i32 - 8) * 0.25;
        let origin = DVec3::new(lattice(), lattice(), lattice());
        let axis = [DVec3::X, DVec3::Y, DVec3::Z][random.below(3)];
        let ray = Ray::new(origin, if random.below(2) == 0 { axis } else { -axis });
        u64::from(structure.nearest(triangles, &ray, &|_| true) != oracle.nearest(&ray, |_| true))
    })?;
    let text = format!(
        "{wrong} of {} rays along axes, within planes of triangles and along their edges, through four structures, hit \
         anything but what the oracle says. A triangle that is seen along its plane isn't hit.",
        number(rays)
    );
    Ok(Finding::new(wrong == 0, text))
}

/// The structures that users choose from, by name.
pub(super) fn choices() -> impl Iterator<Item = (&'static str, Structure)> {
    umbrage_papers::structures()
        .iter()
        .map(|structure| (structure.name(), structure.clone()))
        .collect::<Vec<_>>()
        .into_iter()
}

pub(super) fn unsound(effort: &Effort) -> Result<Finding> {
    let mesh = TestMesh::bumpy_ball(2.0, effort.side(100, 16));
    let (rays, mut random) = (effort.of(200_000), effort.random());
    let nan = DVec3::splat(f64::NAN);
    let infinite = DVec3::splat(f64::INFINITY);
    // Added to the origin and to the direction of ordinary rays, as Embree's tests do.
    let broken = [
        (nan, DVec3::ZERO),
        (nan, nan),
        (DVec3::ZERO, nan),
        (infinite, DVec3::ZERO),
        (DVec3::ZERO, infinite),
        (infinite, infinite),
    ];
    let (mut worst, mut hits): (f64, u64) = (0.0, 0);
    for (_, structure) in single_rays(mesh.triangles())? {
        let mut seconds = |origin: DVec3, direction: DVec3| {
            let rays: Vec<Ray> = (0..rays)
                .map(|_| Ray::new(random.point().as_dvec3() + origin, random.point().as_dvec3() + direction))
                .collect();
            let started = std::time::Instant::now();
            let hit = |ray: &Ray| asked(&*structure).nearest(mesh.triangles(), ray, &|_| true).is_some();
            let hits = rays.iter().filter(|ray| hit(ray)).count() as u64;
            (started.elapsed().as_secs_f64(), hits)
        };
        let (ordinary, _) = seconds(DVec3::ZERO, DVec3::ZERO);
        for (origin, direction) in broken {
            let (time, met) = seconds(origin, direction);
            (worst, hits) = (worst.max(time / ordinary), hits + met);
        }
    }
    let text = format!(
        "Rays with origins or directions that are NaN or infinite take at most {worst:.2} times as long as ordinary ones, \
         through four structures; {hits} of them hit anything."
    );
    Ok(Finding::new(worst < 2.5 && hits == 0, text))
}
