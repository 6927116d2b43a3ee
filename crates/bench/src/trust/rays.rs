//! Rays at closed surfaces and at shared edges and corners of triangles: none may be lost.

use anyhow::Result;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use umbrage::rays::predicate::{self, HitPoint, ShadowRay};
use umbrage::rays::{Bvh, LightSource, Ray, SingleRays, Structure, Triangles};
use umbrage_papers::{KdTree, KdTreeOptions, UniformGrid, UniformOptions};
use umbrage_verify::{Random, SeamTrial, TestMesh};

use super::{Effort, Finding};

/// A point where f32 has few bits left; Embree's tests use it too.
const FAR: Vec3 = Vec3::new(148_376.0, 1_234.0, -223_423.0);

/// The structures that answer rays one at a time, built over a mesh.
pub(super) fn single_rays(triangles: Triangles<'_>) -> Result<Vec<(&'static str, Box<dyn Structure>)>> {
    let mut kd_tree = KdTree::default();
    kd_tree.set_options(KdTreeOptions::FAST)?;
    let mut nested = UniformGrid::default();
    nested.set_options(UniformOptions::NESTED)?;
    let mut structures: Vec<(&'static str, Box<dyn Structure>)> = vec![
        ("hierarchy", Box::<Bvh>::default()),
        ("kd-tree", Box::new(kd_tree)),
        ("uniform grid", Box::<UniformGrid>::default()),
        ("grids in cells", Box::new(nested)),
    ];
    structures.iter_mut().for_each(|(_, structure)| structure.build(triangles));
    Ok(structures)
}

/// Its single rays, which all of [`single_rays`] have.
pub(super) fn asked(structure: &dyn Structure) -> &dyn SingleRays {
    structure.single_rays().expect("answers single rays")
}

/// Sum of `count` over `times` random numbers, for all structures over a mesh.
pub(super) fn sums(
    mesh: &TestMesh,
    effort: &Effort,
    times: u64,
    count: impl Fn(&dyn SingleRays, Triangles<'_>, &mut Random) -> u64 + Sync,
) -> Result<u64> {
    let triangles = mesh.triangles();
    let of_structure = |structure: &dyn Structure| -> u64 {
        let rays = asked(structure);
        let numbers = (0..times).into_par_iter();
        numbers.map(|number| count(rays, triangles, &mut Random::new(effort.seed ^ (number << 8)))).sum()
    };
    Ok(single_rays(triangles)?.iter().map(|(_, structure)| of_structure(&**structure)).sum())
}

pub(super) fn is_lost(rays: &dyn SingleRays, triangles: Triangles<'_>, ray: &Ray) -> u64 {
    u64::from(rays.nearest(triangles, ray, &|_| true).is_none())
}

/// A number with its digits in groups of three.
pub(super) fn number(count: u64) -> String {
    let digits = count.to_string();
    let groups = digits.as_bytes().rchunks(3).rev().map(|group| String::from_utf8_lossy(group).into_owned());
    groups.collect::<Vec<_>>().join(" ")
}

pub(super) fn random(effort: &Effort) -> Result<Finding> {
    let (rays, mut lost) = (effort.of(348_000), 0);
    for position in [Vec3::ZERO, FAR] {
        let ball = TestMesh::bumpy_ball(2.0, effort.side(250, 16)).placed(1.0, position);
        lost += sums(&ball, effort, rays, |structure, triangles, random| {
            let ray = Ray::new((position + random.point() * 0.9).as_dvec3(), random.point().as_dvec3());
            is_lost(structure, triangles, &ray)
        })?;
    }
    let text = format!(
        "{lost} lost of {} random rays inside a closed surface at the origin, and as many inside one at (148 376, 1 234, \
         −223 423), through each of hierarchy, kd-tree, uniform grid and grids in cells.",
        number(rays)
    );
    Ok(Finding::new(lost == 0, text))
}

pub(super) fn seams(effort: &Effort) -> Result<Finding> {
    let mut trial = SeamTrial::new(30)?;
    let (rays, mut random) = (effort.of(100_000_000), effort.random());
    while trial.at_seams() < rays {
        trial.next(&mut random)?;
    }
    Ok(Finding::new(true, format!("No leak and no self-shadowing: {trial}.")))
}

/// Rays from a point exactly at all corners and middles of edges of a mesh: numbers of all rays, of lost ones, and of
/// those that meet a seam twice when they go on from hit to hit; and of further triangles hit at the same t.
#[derive(Default)]
struct SeamRays {
    rays: u64,
    lost: u64,
    twice: u64,
    shared: u64,
}

impl SeamRays {
    /// Shoots rays from `origin` at all seams. Each ray must hit the mesh.
    fn shoot(&mut self, mesh: &TestMesh, origin: Vec3) -> Result<()> {
        let (triangles, origin) = (mesh.triangles(), origin.as_dvec3());
        let corners = mesh.indices.iter().flat_map(|&[a, b, c]| [(a, a), (b, b), (c, c), (a, b), (b, c), (c, a)]);
        let at = |vertex: u32| mesh.positions[vertex as usize].as_dvec3();
        let targets: Vec<DVec3> = corners.map(|(a, b)| at(a).midpoint(at(b))).collect();
        for (_, structure) in single_rays(triangles)? {
            let structure = asked(&*structure);
            for target in &targets {
                let ray = Ray::new(origin, target - origin);
                self.rays += 1;
                let Some(first) = structure.nearest(triangles, &ray, &|_| true) else {
                    self.lost += 1;
                    continue;
                };
                let is_there_again = structure
                    .nearest(triangles, &Ray { t_min: first.t, ..ray }, &|_| true)
                    .is_some_and(|next| next.t - first.t < 1e-9);
                self.twice += u64::from(is_there_again);
                let met = |id: &u32| predicate::hit(&ray, triangles, *id).is_some_and(|hit| hit.t == first.t);
                self.shared += (0..triangles.len() as u32).filter(met).count() as u64 - 1;
            }
        }
        Ok(())
    }

    fn finding(&self) -> Finding {
        let Self { rays, lost, twice, shared } = self;
        let text = format!(
            "{lost} lost and {twice} met twice of {} rays exactly at shared corners and middles of edges, going on from each \
             hit to the next. Asked one by one, {} further triangles are met at the very same t, as they should be where \
             closed triangles touch: the lowest id wins.",
            number(*rays),
            number(*shared)
        );
        Finding::new(*lost == 0 && *twice == 0, text)
    }
}

pub(super) fn fans(effort: &Effort) -> Result<Finding> {
    let (mut random, mut rays) = (effort.random(), SeamRays::default());
    for _ in 0..effort.of(2_000) {
        let spokes = 3 + random.below(30) as u32;
        let middle = random.point() + Vec3::Y * random.unit() * 0.1;
        let rim = |spoke: u32, random: &mut Random| {
            let angle = std::f32::consts::TAU * spoke as f32 / spokes as f32;
            middle + Vec3::new(angle.cos(), 0.1 * random.unit(), angle.sin())
        };
        let mut fan = TestMesh { positions: vec![middle], ..TestMesh::default() };
        fan.positions.extend((0..spokes).map(|spoke| rim(spoke, &mut random)));
        fan.indices = (0..spokes).map(|spoke| [0, 1 + spoke, 1 + (spoke + 1) % spokes]).collect();
        rays.shoot(&fan, middle + Vec3::new(0.1 * random.unit(), 2.0, 0.1 * random.unit()))?;
    }
    for side in 1..effort.side(24, 3) {
        rays.shoot(&TestMesh::floor(side), Vec3::new(random.unit(), 1.0 + random.unit(), random.unit()))?;
    }
    Ok(rays.finding())
}

pub(super) fn windings(effort: &Effort) -> Result<Finding> {
    let (mut random, mut rays) = (effort.random(), SeamRays::default());
    for number in 0..effort.of(60) {
        let (scale, offset) =
            [(1.0, Vec3::ZERO), (1e-6, Vec3::ZERO), (1e6, Vec3::ZERO), (50.0, FAR)][number as usize % 4];
        let mut ball = TestMesh::ball(2).placed(scale, offset);
        for triangle in &mut ball.indices {
            triangle.rotate_left(random.below(3));
            if random.below(2) == 0 {
                triangle.swap(0, 1);
            }
        }
        rays.shoot(&ball, offset + random.point() * (0.2 * scale))?;
    }
    Ok(rays.finding())
}

pub(super) fn rough_ball(effort: &Effort) -> Result<Finding> {
    const SIDE: u32 = 16;
    let (rays, mut random) = (effort.of(100_000), effort.random());
    let mut ball = TestMesh::default();
    for (row, column) in (0..SIDE).flat_map(|row| (0..SIDE).map(move |column| (row, column))) {
        let polar = std::f32::consts::PI * row as f32 / (SIDE - 1) as f32;
        let around = std::f32::consts::TAU * (column % (SIDE - 1)) as f32 / (SIDE - 1) as f32;
        let is_new = column < SIDE - 1 && (column == 0 || (1..SIDE - 1).contains(&row));
        // The seam and the poles are single vertices.
        let radius = if is_new { 1.0 + 5.0 * random.unit() } else { 0.0 };
        let at = Vec3::new(polar.sin() * around.cos(), polar.sin() * around.sin(), polar.cos()) * radius;
        let first = (row * SIDE) as usize;
        ball.positions.push(if is_new { at } else { ball.positions[first] });
    }
    for (row, column) in (0..SIDE - 1).flat_map(|row| (0..SIDE - 1).map(move |column| (row, column))) {
        let index = |row: u32, column: u32| row * SIDE + column;
        let [a, b] = [index(row, column), index(row, column + 1)];
        let [c, d] = [index(row + 1, column + 1), index(row + 1, column)];
        ball.indices.extend([[a, b, c], [a, c, d]]);
    }
    let vertices = ball.positions.clone();
    let lost = sums(&ball, effort, rays, |structure, triangles, random| {
        let origin = (random.point() * 0.28).as_dvec3();
        let anywhere = Ray::new(origin, random.point().as_dvec3());
        let at_vertex = Ray::new(origin, vertices[random.below(vertices.len())].as_dvec3() - origin);
        is_lost(structure, triangles, &anywhere) + is_lost(structure, triangles, &at_vertex)
    })?;
    let text = format!(
        "{lost} lost of {} rays from the inside of a ball whose vertices are at random distances, half of them exactly at \
         vertices, through each of the four structures for single rays.",
        number(2 * rays)
    );
    Ok(Finding::new(lost == 0, text))
}

pub(super) fn leaving(effort: &Effort) -> Result<Finding> {
    let (points, mut dark) = (effort.of(2_000_000).div_ceil(20), 0);
    for (scale, center) in
        [(1.0, Vec3::ZERO), (1e-6, Vec3::ZERO), (1e6, Vec3::ZERO), (50.0, FAR), (1.0, Vec3::new(0.1, 7.0, -0.3))]
    {
        let ball = TestMesh::ball(3).placed(scale, center);
        dark += sums(&ball, effort, points, |structure, triangles, random| {
            let outwards = random.point().normalize_or(Vec3::X);
            let camera = (center + outwards * (4.0 * scale)).as_dvec3();
            let target = (center + random.point() * (0.5 * scale)).as_dvec3();
            let ray = Ray::new(camera, target - camera);
            let Some(hit) = structure.nearest(triangles, &ray, &|_| true) else { return 1 };
            let point = HitPoint::new(&ray, hit.t);
            let above = (point.position - center.as_dvec3()).normalize().as_vec3();
            let light = LightSource::Point { position: center + above * (3.0 * scale) };
            u64::from(structure.blocked(triangles, &ShadowRay::new(&light, point), hit.triangle, &|_, _| true))
        })?;
    }
    let text = format!(
        "{dark} of {} hit points on convex bodies of all scales, near and far, are shadowed by their own surface from a light \
         above it. Nothing is moved along a normal: there is no offset to choose.",
        number(20 * points)
    );
    Ok(Finding::new(dark == 0, text))
}
