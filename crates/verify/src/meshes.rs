use std::collections::HashMap;

use glam::Vec3;
use umbrage_rays::Triangles;

use crate::Random;

/// Vertices and triangles made for a test.
#[derive(Clone, Debug, Default)]
pub struct TestMesh {
    /// World positions.
    pub positions: Vec<Vec3>,
    /// Three vertices for each triangle.
    pub indices: Vec<[u32; 3]>,
}

impl TestMesh {
    /// The mesh as structures see it.
    #[must_use]
    pub fn triangles(&self) -> Triangles<'_> {
        Triangles { positions: &self.positions, indices: &self.indices }
    }

    /// A mesh of triangles without shared vertices.
    #[must_use]
    pub fn of(triangles: &[[Vec3; 3]]) -> Self {
        let mut mesh = Self::default();
        triangles.iter().for_each(|&corners| mesh.push(corners));
        mesh
    }

    /// A closed, convex ball of radius 1: an icosahedron with each triangle split into four, `splits` times. Windings
    /// are mixed: every third triangle is reversed.
    #[must_use]
    pub fn ball(splits: u32) -> Self {
        let golden = 0.5 * (1.0 + 5.0_f32.sqrt());
        let mut positions: Vec<Vec3> = [(-1.0, golden), (1.0, golden), (-1.0, -golden), (1.0, -golden)]
            .into_iter()
            .flat_map(|(a, b)| [Vec3::new(a, b, 0.0), Vec3::new(0.0, a, b), Vec3::new(b, 0.0, a)])
            .map(Vec3::normalize)
            .collect();
        // Two corners of an icosahedron's face are a side apart; the next distance is far longer.
        let near = |a: usize, b: usize| a < b && positions[a].distance(positions[b]) < 1.1;
        let mut indices = Vec::new();
        for a in 0..12 {
            for b in (0..12).filter(|&b| near(a, b)) {
                indices.extend((0..12).filter(|&c| near(b, c) && near(a, c)).map(|c| [a as u32, b as u32, c as u32]));
            }
        }
        for _ in 0..splits {
            let mut middles = HashMap::new();
            let mut middle = |a: u32, b: u32| {
                *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    positions.push((positions[a as usize] + positions[b as usize]).normalize());
                    (positions.len() - 1) as u32
                })
            };
            indices = indices
                .into_iter()
                .flat_map(|[a, b, c]| {
                    let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
                })
                .collect();
        }
        for triangle in indices.iter_mut().step_by(3) {
            triangle.swap(1, 2);
        }
        Self { positions, indices }
    }

    /// A floor of `side`² squares in the plane y = −1, from −2 to 2. If `side` is a power of two, the corners are on a
    /// lattice of powers of two.
    #[must_use]
    pub fn floor(side: u32) -> Self {
        let at = |x: u32, z: u32| Vec3::new(x as f32, 0.0, z as f32) * (4.0 / side as f32) - Vec3::new(2.0, 1.0, 2.0);
        let positions = (0..=side).flat_map(|z| (0..=side).map(move |x| (x, z))).map(|(x, z)| at(x, z)).collect();
        let squares = (0..side).flat_map(|z| (0..side).map(move |x| (x, z)));
        let halves = squares.flat_map(|(x, z)| {
            let a = z * (side + 1) + x;
            let [b, c, d] = [a + 1, a + side + 2, a + side + 1];
            if (x + z) % 3 == 0 { [[a, b, c], [d, c, a]] } else { [[a, b, d], [b, d, c]] }
        });
        Self { positions, indices: halves.collect() }
    }

    /// A ball above a floor, and a wall behind both.
    #[must_use]
    pub fn room() -> Self {
        let mut mesh = Self::floor(8);
        let ball = Self::ball(2).placed(0.5, Vec3::new(0.25, -0.25, 0.0));
        (0..ball.indices.len() as u32).for_each(|id| mesh.push(ball.triangles().corners(id)));
        mesh.push([Vec3::new(-2.0, -1.0, -1.5), Vec3::new(2.0, -1.0, -1.5), Vec3::new(0.0, 2.0, -1.5)]);
        mesh
    }

    /// The [room](Self::room) among triangles of every bad shape.
    #[must_use]
    pub fn bad_shapes(random: &mut Random) -> Self {
        let mut mesh = Self::room();
        for _ in 0..30 {
            // Slivers, needles, and tiny triangles that still have an area.
            let (a, b) = (random.point() * 1.5, random.point() * 1.5);
            mesh.push([a, b, a.lerp(b, random.unit()) + random.point() * 1e-6]);
            mesh.push([a, a + random.point() * 1e-5, b + random.point() * 2.0]);
            mesh.push([a, Vec3::new(a.x.next_up(), a.y, a.z), Vec3::new(a.x, a.y.next_up(), a.z)]);
            mesh.push([(); 3].map(|()| b + random.point() * 1e-7));
        }
        // Points and lines without an area.
        let (a, b) = (random.point(), random.point());
        [[a, a, a], [a, b, a], [a, a.midpoint(b), b]].into_iter().for_each(|corners| mesh.push(corners));
        // Triangles that span the whole view and reach around the camera and the lights, and far beyond all others.
        for reach in [6.0, 1e3, 1e6] {
            let plane = |x: f32, y: f32, z: f32| Vec3::new(x, y, z) * reach;
            mesh.push([plane(-1.0, -0.7, -1.0), plane(1.0, -0.8, -1.0), plane(0.1, -0.9, 1.0)]);
            mesh.push([plane(-1.0, 1.0, -1.0), plane(1.0, 1.0, -1.0), plane(0.1, 0.9, 1.0)]);
        }
        mesh
    }

    /// The triangle of [copies](Self::copies).
    pub const COPY: [Vec3; 3] = [Vec3::new(-1.5, -0.5, 0.0), Vec3::new(-0.5, -0.5, 1.0), Vec3::new(-1.0, 0.5, 1.0)];

    /// The [room](Self::room) with `count` copies of one triangle.
    #[must_use]
    pub fn copies(count: u32) -> Self {
        let mut mesh = Self::room();
        (0..count).for_each(|_| mesh.push(Self::COPY));
        mesh
    }

    /// A ball of 2.5·10⁻⁴ over a card of 2·10⁻³, which is the two triangles after the ball's, and two triangles two units
    /// below both, a thousand times as large.
    #[must_use]
    pub fn card() -> Self {
        let mut mesh = Self::ball(2).placed(2.5e-4, Vec3::new(1e-4, 3e-4, 3e-4));
        let card = |x: f32, y: f32| Vec3::new(x, y, -0.3 * y - 1e-3) * 1e-3;
        mesh.push([card(-1.0, -1.0), card(0.9, -1.0), card(0.9, 1.0)]);
        mesh.push([card(-1.0, -1.0), card(0.9, 1.0), card(-1.0, 1.0)]);
        for (a, b, c) in [((-2.0, -2.0), (2.0, -2.0), (2.0, 2.0)), ((-2.0, -2.0), (2.0, 2.0), (-2.0, 2.0))] {
            mesh.push([a, b, c].map(|(x, y)| Vec3::new(x, y, -2.0)));
        }
        mesh
    }

    /// The mesh, scaled and then moved.
    #[must_use]
    pub fn placed(mut self, scale: f32, offset: Vec3) -> Self {
        self.positions.iter_mut().for_each(|position| *position = *position * scale + offset);
        self
    }

    /// Adds a triangle with vertices of its own.
    pub fn push(&mut self, corners: [Vec3; 3]) {
        let first = self.positions.len() as u32;
        self.positions.extend(corners);
        self.indices.push([first, first + 1, first + 2]);
    }

    /// Adds two triangles between four corners.
    pub fn quad(&mut self, [a, b, c, d]: [Vec3; 4]) {
        let first = self.positions.len() as u32;
        self.positions.extend([a, b, c, d]);
        self.indices.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }

    /// Adds all of another mesh, behind this one's triangles.
    pub fn append(&mut self, other: &Self) {
        let first = self.positions.len() as u32;
        self.positions.extend(&other.positions);
        // Indices out of range stay out of range.
        self.indices.extend(other.indices.iter().map(|triangle| triangle.map(|vertex| vertex.saturating_add(first))));
    }

    /// A ball with bumps around the origin, of `rings` by twice as many quads with shared vertices. The triangles at
    /// its poles have no area.
    #[must_use]
    pub fn bumpy_ball(radius: f32, rings: u32) -> Self {
        let parts = 2 * rings;
        let at = |ring: u32, part: u32| {
            let polar = std::f32::consts::PI * ring as f32 / rings as f32;
            let around = std::f32::consts::TAU * part as f32 / parts as f32;
            let radius = radius * (1.0 + 0.1 * (9.0 * polar).sin() * (7.0 * around).cos());
            Vec3::new(polar.sin() * around.cos(), polar.cos(), polar.sin() * around.sin()) * radius
        };
        let positions = (0..=rings).flat_map(|ring| (0..parts).map(move |part| at(ring, part)));
        let indices = (0..rings).flat_map(|ring| (0..parts).map(move |part| (ring, part))).flat_map(|(ring, part)| {
            let index = |ring: u32, part: u32| ring * parts + part % parts;
            let [a, b] = [index(ring, part), index(ring, part + 1)];
            let [c, d] = [index(ring + 1, part + 1), index(ring + 1, part)];
            [[a, b, c], [a, c, d]]
        });
        Self { positions: positions.collect(), indices: indices.collect() }
    }

    /// `count` triangles with corners around the origin, of sizes from `smallest` to one.
    #[must_use]
    pub fn soup(random: &mut Random, count: usize, smallest: f32) -> Self {
        let mut mesh = Self::default();
        for _ in 0..count {
            let center = random.point() * 2.0;
            let size = smallest.powf(random.unit());
            mesh.push([(); 3].map(|()| center + random.point() * size));
        }
        mesh
    }

    /// Triangles that show their front, their back or, up to rounding, neither to some points: fifty for each point are
    /// edge-on.
    #[must_use]
    pub fn fronts_and_backs(points: [Vec3; 2]) -> Self {
        let mut random = Random::new(13);
        let mut mesh = Self::soup(&mut random, 100, 0.05);
        mesh.append(&Self::bumpy_ball(1.0, 10));
        mesh.append(&Self::plane(3, 500.0));
        for point in points {
            for _ in 0..50 {
                let (a, b) = (random.point(), random.point());
                mesh.push([a, b, a + (a - point) * random.unit()]);
            }
        }
        mesh
    }

    /// A square of 2 × `side`² triangles in the plane y = 0, from −`half` to `half`.
    #[must_use]
    pub fn plane(side: u32, half: f32) -> Self {
        let coordinate = |step: u32| half * (2.0 * step as f32 / side as f32 - 1.0);
        let corners = (0..=side).flat_map(|z| (0..=side).map(move |x| (x, z)));
        let positions = corners.map(|(x, z)| Vec3::new(coordinate(x), 0.0, coordinate(z))).collect();
        let squares = (0..side).flat_map(|z| (0..side).map(move |x| (x, z)));
        let halves = squares.flat_map(|(x, z)| {
            let a = z * (side + 1) + x;
            let [b, c, d] = [a + 1, a + side + 1, a + side + 2];
            [[a, b, d], [a, d, c]]
        });
        Self { positions, indices: halves.collect() }
    }
}

/// Few triangles in difficult places for a camera at the origin that looks along −z: in one plane, behind it and
/// through it.
#[must_use]
pub fn meshes_in_bad_places() -> Vec<(&'static str, TestMesh)> {
    let of = TestMesh::of;
    let at = Vec3::new;
    let one = [at(-1.0, -0.8, -3.0), at(1.1, -0.7, -4.0), at(0.1, 1.0, -3.5)];
    let beside = [at(-1.0, -0.8, -3.0), at(0.1, 1.0, -3.5), at(-1.2, 0.9, -2.0)];
    let flat = |x: f32| [at(-1.0 + x, -1.0, -3.0), at(1.0 + x, -1.0, -3.0), at(x, 1.0, -3.0)];
    let far = [at(-1e5, -1e5, -20.0), at(1e5, -1e5, -20.0), at(0.0, 1e5, -20.0)];
    let through = [at(-2.0, -1.0, 3.0), at(2.0, -1.0, 2.0), at(0.3, -0.5, -6.0)];
    let touching = [at(0.0, 0.0, 0.0), at(1.0, -1.0, -2.0), at(-1.0, -1.0, -2.0)];
    let behind = one.map(|corner| corner * at(1.0, 1.0, -1.0));
    let edge_on = [at(0.0, 0.0, -1.0), at(0.5, 0.0, -3.0), at(-0.5, 0.0, -3.0)];
    vec![
        ("nothing", TestMesh::default()),
        ("one", of(&[one])),
        ("two that share an edge", of(&[one, beside])),
        ("two in one plane", of(&[flat(0.0), flat(0.25)])),
        ("two in one plane, the other way", of(&[flat(0.25), flat(0.0)])),
        ("the same twice", of(&[one, one])),
        ("the same, turned and mirrored", of(&[far, [one[1], one[2], one[0]], [one[2], one[1], one[0]], one])),
        ("all of the view", of(&[far])),
        ("all of the view, and one before it", of(&[far, one])),
        ("behind the eye", of(&[behind])),
        ("through the eye's plane", of(&[through])),
        ("through the eye", of(&[touching, one])),
        ("in the eye's plane", of(&[[at(-1.0, 0.0, 0.0), at(1.0, 0.0, 0.0), at(0.0, 1.0, 0.0)], one])),
        ("edge on", of(&[edge_on, far])),
        ("all of them", of(&[one, beside, flat(0.0), flat(0.25), far, through, touching, behind, edge_on])),
    ]
}
