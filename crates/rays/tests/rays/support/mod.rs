//! Small meshes, and the nearest hit by asking the predicate about every triangle.
#![allow(dead_code, reason = "not every test file uses all of it")]

pub(crate) mod far;
pub(crate) mod pairs;
pub(crate) mod scales;

use glam::{DVec3, Vec3};
use umbrage_rays::predicate::{ShadowRay, hit};
use umbrage_rays::{Hit, Ray, Triangles};

/// A mesh of its own.
#[derive(Clone, Debug, Default)]
pub(crate) struct Mesh {
    pub(crate) positions: Vec<Vec3>,
    pub(crate) indices: Vec<[u32; 3]>,
}

impl Mesh {
    pub(crate) fn triangles(&self) -> Triangles<'_> {
        Triangles { positions: &self.positions, indices: &self.indices }
    }

    pub(crate) fn push(&mut self, corners: [Vec3; 3]) {
        let first = self.positions.len() as u32;
        self.positions.extend(corners);
        self.indices.push([first, first + 1, first + 2]);
    }

    /// Two triangles between four corners.
    pub(crate) fn quad(&mut self, [a, b, c, d]: [Vec3; 4]) {
        let first = self.positions.len() as u32;
        self.positions.extend([a, b, c, d]);
        self.indices.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }

    /// A ball of `rings` by twice as many parts with shared vertices, bumpy by `bump`.
    pub(crate) fn ball(&mut self, center: Vec3, radius: f32, rings: u32, bump: f32) {
        let first = self.positions.len() as u32;
        let parts = 2 * rings;
        for ring in 0..=rings {
            for part in 0..parts {
                let (polar, around) = (
                    std::f32::consts::PI * ring as f32 / rings as f32,
                    std::f32::consts::TAU * part as f32 / parts as f32,
                );
                let radius = radius * (1.0 + bump * (9.0 * polar).sin() * (7.0 * around).cos());
                let (sin, cos) = polar.sin_cos();
                let direction = Vec3::new(sin * around.cos(), cos, sin * around.sin());
                self.positions.push(center + direction * radius);
            }
        }
        for ring in 0..rings {
            for part in 0..parts {
                let at = |ring: u32, part: u32| first + ring * parts + part % parts;
                let [a, b, c, d] = [at(ring, part), at(ring, part + 1), at(ring + 1, part + 1), at(ring + 1, part)];
                self.indices.extend([[a, b, c], [a, c, d]]);
            }
        }
    }

    pub(crate) fn append(&mut self, other: &Self) {
        let first = self.positions.len() as u32;
        self.positions.extend(&other.positions);
        self.indices.extend(other.indices.iter().map(|triangle| triangle.map(|vertex| vertex + first)));
    }

    /// Each position times `scale`, then moved by `offset`.
    pub(crate) fn moved(&self, scale: f32, offset: Vec3) -> Self {
        let positions = self.positions.iter().map(|&position| position * scale + offset).collect();
        Self { positions, indices: self.indices.clone() }
    }

    /// A ball with bumps.
    pub(crate) fn bumpy_ball(center: Vec3, radius: f32, rings: u32) -> Self {
        let mut mesh = Self::default();
        mesh.ball(center, radius, rings, 0.1);
        mesh
    }

    /// `count` triangles with corners around the origin, of sizes from `smallest` to one.
    pub(crate) fn soup(random: &mut Random, count: usize, smallest: f32) -> Self {
        let mut mesh = Self::default();
        for _ in 0..count {
            let center = random.point() * 2.0;
            let size = smallest.powf(random.unit());
            mesh.push([0; 3].map(|_| center + random.point() * size));
        }
        mesh
    }

    /// A square of 2 × `side`² triangles in the plane y = 0, from −`half` to `half`.
    pub(crate) fn floor(side: u32, half: f32) -> Self {
        let mut mesh = Self::default();
        let coordinate = |place: u32| half * (2.0 * place as f32 / side as f32 - 1.0);
        for z in 0..=side {
            for x in 0..=side {
                mesh.positions.push(Vec3::new(coordinate(x), 0.0, coordinate(z)));
            }
        }
        for z in 0..side {
            for x in 0..side {
                let a = z * (side + 1) + x;
                let (b, c, d) = (a + 1, a + side + 1, a + side + 2);
                mesh.indices.extend([[a, b, d], [a, d, c]]);
            }
        }
        mesh
    }
}

/// Numbers that look random: Steele, Lea and Flood's `SplitMix64`.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Returns a number in [0, 1).
    pub(crate) fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1 << 24) as f32
    }

    /// Returns a point of the cube [−1, 1)³.
    pub(crate) fn point(&mut self) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0
    }
}

/// Triangles with a corner exactly, or to 2⁻²¹, at a corner of cells of a uniform grid with [`CORNER_CELLS`] cells for each
/// triangle, and rays exactly through those corners, from nearby and so far away that crossings with cells' faces are
/// rounded.
pub(crate) fn corners_of_cells() -> (Mesh, Vec<Ray>) {
    let mut random = Random(21);
    let mut mesh = Mesh::default();
    // 16³ cells in a cube of 8³ have edges of one half; a grid begins 1/64 of that before its bounds, so at zero.
    let [low, high] = [Vec3::splat(1.0 / 128.0), Vec3::splat(8.0 + 1.0 / 128.0)];
    mesh.push([low, low + Vec3::X, low + Vec3::Y]);
    mesh.push([high, high - Vec3::X, high - Vec3::Y]);
    let mut rays = Vec::new();
    while mesh.indices.len() < 256 {
        let [corner, octant] = [random.point(), random.point()];
        let beside = random.point().round() * if random.unit() < 0.5 { 1.0 / (1 << 21) as f32 } else { 0.0 };
        let corner = (corner * 6.0 + 8.0).round() * 0.5 + beside;
        // From the corner into one of the eight cells around it.
        let mut inside = || (random.point() * 30.0).round().abs().max(Vec3::ONE) / 64.0 * octant.signum();
        mesh.push([corner, corner + inside(), corner + inside()]);
        for away in [0.25, 1.0, 4.0, f64::from(1 << 20), f64::from(1 << 30)] {
            for _ in 0..6 {
                // Few digits, so that the ray goes through the corner exactly.
                let direction = (random.point() * 3.0).round().as_dvec3();
                if direction.length() > 0.0 {
                    rays.push(Ray::new(corner.as_dvec3() - direction * away, direction));
                }
            }
        }
    }
    (mesh, rays)
}

/// The number of cells for each triangle of [`corners_of_cells`].
pub(crate) const CORNER_CELLS: f64 = 16.0;

/// The triangles of [`corners_of_cells`] inside of one cell of a room, in which a grid with [`CORNER_CELLS`] cells
/// for each triangle holds the grid that they have alone; and the same rays.
pub(crate) fn corners_of_cells_in_a_room() -> (Mesh, Vec<Ray>) {
    let (mut mesh, rays) = corners_of_cells();
    // 17 cells with an edge of 62 on each axis, of which the ninth is from about -31 to 31.
    for (corner, inwards) in [(-530.0, 1.0), (470.0, -1.0)] {
        let corner = Vec3::splat(corner);
        mesh.push([corner, corner + Vec3::X * inwards, corner + Vec3::Y * inwards]);
    }
    (mesh, rays)
}

/// The place of the ball of [`stadium`].
pub(crate) const BALL_PLACE: Vec3 = Vec3::new(0.3, -0.7, 0.2);

/// A bumpy ball with a radius of `smallness` on the floor of a room from -1 to 1.
pub(crate) fn stadium(rings: u32, smallness: f32) -> Mesh {
    let mut mesh = Mesh::bumpy_ball(Vec3::ZERO, smallness, rings).moved(1.0, BALL_PLACE);
    mesh.append(&Mesh::floor(4, 1.0).moved(1.0, Vec3::Y * (BALL_PLACE.y - smallness)));
    mesh.append(&Mesh::floor(1, 1.0).moved(1.0, Vec3::Y));
    mesh
}

/// Rays to corners, edges and insides of triangles: in the triangle's plane, almost in it, and from anywhere, near and far.
pub(crate) fn grazing_rays(triangles: Triangles<'_>, random: &mut Random, count: usize) -> Vec<Ray> {
    let mut rays = Vec::new();
    for step in 0..count {
        let id = (random.bits() % (triangles.len() as u64 - 2)) as u32;
        if !is_usable(triangles, id) {
            continue;
        }
        let [a, b, c] = triangles.corners(id).map(Vec3::as_dvec3);
        let weight = f64::from(random.unit());
        let on_edge = a + (b - a) * weight;
        let target = [a, on_edge, on_edge + (c - on_edge) * f64::from(random.unit())][step % 3];
        let along = (b - a) * f64::from(random.unit() - 0.5) + (c - a) * f64::from(random.unit() - 0.5);
        let lifted = along + (b - a).cross(c - a) * 10.0_f64.powi(-((step % 17) as i32));
        for direction in [along, lifted, (random.point() * 3.0).as_dvec3() - target] {
            if direction.length() > 1e-6 {
                rays.push(Ray::new(target - direction, direction));
                rays.push(Ray::new(target - direction * 100.0, direction));
            }
        }
    }
    rays
}

pub(crate) fn is_usable(triangles: Triangles<'_>, id: u32) -> bool {
    let vertices = triangles.positions.len() as u32;
    triangles.indices[id as usize].iter().all(|&vertex| vertex < vertices)
        && triangles.corners(id).iter().all(|corner| corner.is_finite())
}

/// Returns the nearest hit, by asking about every triangle.
pub(crate) fn nearest_of_all(triangles: Triangles<'_>, ray: &Ray, counts: impl Fn(&Hit) -> bool) -> Option<Hit> {
    let hits = (0..triangles.len() as u32).filter(|&id| is_usable(triangles, id));
    let hits = hits.filter_map(|id| hit(ray, triangles, id)).filter(|hit| counts(hit));
    hits.min_by(|a, b| (a.t, a.triangle).partial_cmp(&(b.t, b.triangle)).expect("no t is NaN"))
}

/// Whether any triangle but `own` shadows a point, by asking about every one.
pub(crate) fn blocked_by_any(
    triangles: Triangles<'_>,
    shadow_ray: &ShadowRay,
    own: u32,
    counts: impl Fn(u32, [f32; 2]) -> bool,
) -> bool {
    let others = (0..triangles.len() as u32).filter(|&id| id != own && is_usable(triangles, id));
    others
        .filter_map(|id| Some((id, shadow_ray.blocked_by(triangles.corners(id))?)))
        .any(|(id, barycentric)| counts(id, barycentric))
}

/// Triangles of all sizes, a ball and a floor, and some that can't be hit.
pub(crate) fn scene(random: &mut Random) -> Mesh {
    let mut mesh = Mesh::soup(random, 60, 0.02);
    mesh.append(&Mesh::bumpy_ball(Vec3::ZERO, 1.0, 8));
    mesh.append(&Mesh::floor(5, 3.0));
    mesh.positions[5].x = f32::NAN;
    mesh.indices.push([0, 1, u32::MAX]);
    mesh.indices.push([7, 7, 8]);
    mesh
}

/// Triangles and boxes with small whole numbers for coordinates, so that planes, faces, corners and rays coincide.
pub(crate) fn blocks(random: &mut Random, count: usize) -> Mesh {
    let mut mesh = Mesh::default();
    let whole = |random: &mut Random, reach: f32| (random.point() * reach).round();
    for step in 0..count {
        let corner = whole(random, 4.0);
        match step % 4 {
            0 => mesh.push([corner, whole(random, 4.0), whole(random, 4.0)]),
            // In a plane across an axis.
            1 => {
                let mut corners = [corner, whole(random, 4.0), whole(random, 4.0)];
                corners.iter_mut().for_each(|other| other[step / 4 % 3] = corner[step / 4 % 3]);
                mesh.push(corners);
            }
            2 => mesh.push([corner, corner + whole(random, 1.0), corner + whole(random, 1.0)]),
            _ => {
                let size = whole(random, 1.0).abs() + 1.0;
                let [x, y, z] = [Vec3::X * size.x, Vec3::Y * size.y, Vec3::Z * size.z];
                for [along, across, to] in [[x, y, z], [y, z, x], [z, x, y]] {
                    for start in [corner, corner + to] {
                        mesh.quad([start, start + along, start + along + across, start + across]);
                    }
                }
            }
        }
    }
    mesh
}

/// Returns a ray from a cube of twice `reach` to a point of the scene.
pub(crate) fn random_ray(random: &mut Random, reach: f32) -> Ray {
    let origin = (random.point() * reach).as_dvec3();
    let length = f64::from(random.unit()) * 3.0 + 0.01;
    Ray::new(origin, ((random.point() * 1.5).as_dvec3() - origin) * length)
}

/// Rays in planes of [`blocks`], along axes, diagonally through corners, and almost along axes, down to numbers without an
/// inverse.
pub(crate) fn rays_in_planes(random: &mut Random, count: usize) -> Vec<Ray> {
    let mut rays = Vec::new();
    for step in 0..count {
        // In the planes of faces, between them, and at corners.
        let mut origin = (random.point() * 6.0).round().as_dvec3();
        if step % 3 == 0 {
            origin += (random.point() * 2.0).round().as_dvec3() * 0.25;
        }
        let axis = [DVec3::X, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Z][step % 6];
        let flat = (random.point() * 3.0).round().as_dvec3() * (DVec3::ONE - axis.abs());
        rays.push(Ray::new(origin - axis * 16.0, axis * [1.0, 1e-90, 1e90][step % 3]));
        rays.push(Ray::new(origin - axis * f64::from(1 << 30), axis));
        // Zeros with either sign.
        rays.push(Ray::new(origin, axis * DVec3::new(1.0, -1.0, 1.0)));
        // Diagonally through corners, and in a plane.
        let diagonal = (random.point() * 2.0).round().as_dvec3();
        for direction in [diagonal, flat] {
            if direction != DVec3::ZERO {
                rays.push(Ray::new(origin - direction * 8.0, direction));
                rays.push(Ray::new(origin - direction * f64::from(1 << 26), direction));
            }
        }
        // Almost along an axis, down to numbers without an inverse.
        let tilt = random.point().as_dvec3() * 10.0_f64.powi(-((step % 20) as i32 * 17));
        rays.push(Ray::new(origin - axis * 16.0, axis + tilt * (DVec3::ONE - axis.abs())));
    }
    rays
}

/// Rays with ends before, behind and at their origin, and at hits.
pub(crate) fn rays_with_intervals(triangles: Triangles<'_>, random: &mut Random, count: usize) -> Vec<Ray> {
    let mut rays = Vec::new();
    for _ in 0..count {
        let mut ray = random_ray(random, 3.0);
        (ray.t_min, ray.t_max) = (f64::from(random.unit()) * 0.5, f64::from(random.unit()) * 2.0);
        rays.push(ray);
        // Behind the origin, and from a hit to itself and to another.
        rays.push(Ray { t_min: -3.0, t_max: -0.01, ..ray });
        rays.push(Ray { t_min: f64::NEG_INFINITY, ..ray });
        if let Some(hit) = nearest_of_all(triangles, &ray, |_| true) {
            rays.push(Ray { t_min: hit.t, ..ray });
            rays.push(Ray { t_min: hit.t.next_down(), t_max: hit.t.next_up(), ..ray });
            rays.push(Ray { t_max: hit.t, ..ray });
            rays.push(Ray { t_max: hit.t.next_up(), ..ray });
        }
    }
    rays
}
