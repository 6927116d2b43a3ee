//! Random scenes of the kinds that have fooled ray tracers.

use glam::{DVec2, Vec3};
use umbrage_rays::{Camera, LightSource, Projection, Sides, View};

use crate::{Case, MIXED_SIDES, Random, TestMesh, lights, views};

/// The random scene of a seed, the same on every machine.
#[must_use]
pub fn random_case(seed: u64) -> Case {
    let random = &mut Random::new(seed);
    let kind = KINDS[random.below(KINDS.len())];
    let (name, mesh) = kind(random);
    let camera = camera(random);
    let mut lights: Vec<LightSource> = (0..1 + random.below(3)).map(|_| light(random, &mesh, &camera)).collect();
    // Scaling by a power of ten changes all bits, by a power of two none.
    let scale = match random.below(4) {
        0 => 10.0_f32.powi(random.below(75) as i32 - 37),
        1 => 2.0_f32.powi(random.below(201) as i32 - 100),
        _ => 1.0,
    };
    let offset = match random.below(4) {
        0 => random.point() * scale * 10.0_f32.powi(random.below(8) as i32),
        _ => Vec3::ZERO,
    };
    for light in &mut lights {
        if let LightSource::Point { position } | LightSource::Spot { position, .. } = light {
            *position = *position * scale + offset;
        }
    }
    let side = |random: &mut Random| 1 + random.below(20) as u32;
    let view = View { camera: views::placed(camera, scale, offset), width: side(random), height: side(random) };
    let name = format!("{name}, scaled by {scale:e} and moved by {offset}");
    Case {
        offset_pixels: DVec2::splat(0.5),
        sides: [Sides::Both, Sides::Both, MIXED_SIDES, Sides::Front][random.below(4)],
        ..Case::new(name, mesh.placed(scale, offset), view, &lights)
    }
}

/// A scene about one unit in size, and its name.
type Kind = fn(&mut Random) -> (String, TestMesh);

const KINDS: [Kind; 7] = [reaching, slivers, stacks, bad_shapes, floors, soup, balls];

/// From 1 to 10⁹.
fn reach(random: &mut Random) -> f32 {
    10.0_f32.powf(9.0 * random.unit())
}

/// Ten triangles, two of them with a corner far away.
fn reaching(random: &mut Random) -> (String, TestMesh) {
    let (mut mesh, reach) = (TestMesh::default(), reach(random));
    for number in 0..10 {
        let mut corners = [(); 3].map(|()| random.point() * 1.5);
        if number < 2 {
            corners[random.below(3)] = random.point() * reach;
        }
        mesh.push(corners);
    }
    (format!("triangles that reach {reach:e}"), mesh)
}

/// Twelve slivers, a fiftieth wide, that reach far, over a floor.
fn slivers(random: &mut Random) -> (String, TestMesh) {
    let (mut mesh, reach) = (TestMesh::floor(2), reach(random));
    for _ in 0..12 {
        let (at, along) = (random.point(), random.point() * reach);
        mesh.push([at, at + random.point() * 0.02, at + along]);
    }
    (format!("slivers that reach {reach:e}"), mesh)
}

/// Triangles on top of one another: copies, parts of one plane, and neighbours that differ by a few bits.
fn stacks(random: &mut Random) -> (String, TestMesh) {
    let mut mesh = TestMesh::default();
    for _ in 0..5 {
        let [a, b, c] = [(); 3].map(|()| random.point() * 1.5);
        mesh.push([a, b, c]);
        mesh.push([c, b, a]);
        mesh.push([a, a.lerp(b, random.unit()), c.lerp(b, random.unit())]);
        let bits = |v: Vec3, random: &mut Random| v * (1.0 + random.below(5) as f32 * f32::EPSILON);
        mesh.push([a, b, c].map(|corner| bits(corner, random)));
    }
    // All in one plane that no axis is parallel to, and in one that two axes are parallel to.
    let tilted = |x: f32, y: f32| Vec3::new(x, y, -0.375 * x + 0.25 * y);
    for _ in 0..4 {
        mesh.push(
            [(); 3].map(|()| tilted((random.unit() * 64.0).round() / 32.0, (random.unit() * 64.0).round() / 32.0)),
        );
        mesh.push([(); 3].map(|()| random.point() * Vec3::new(2.0, 0.0, 2.0)));
    }
    ("stacks".to_owned(), mesh)
}

fn bad_shapes(random: &mut Random) -> (String, TestMesh) {
    let mut mesh = TestMesh::bad_shapes(random);
    // A quarter of them is enough, and takes less time.
    let first = random.below(4);
    mesh.indices = mesh.indices.into_iter().skip(first).step_by(4).collect();
    ("bad shapes".to_owned(), mesh)
}

/// A lattice with edges and corners on rays, and some corners raised slightly.
fn floors(random: &mut Random) -> (String, TestMesh) {
    let mut mesh = TestMesh::floor(4);
    for _ in 0..random.below(6) {
        let height = 10.0_f32.powi(-(random.below(9) as i32));
        let vertex = random.below(mesh.positions.len());
        mesh.positions[vertex].y += height;
    }
    ("a floor".to_owned(), mesh)
}

fn soup(random: &mut Random) -> (String, TestMesh) {
    ("a soup".to_owned(), TestMesh::soup(random, 40, 1e-4))
}

/// Closed surfaces, one inside the other.
fn balls(random: &mut Random) -> (String, TestMesh) {
    let mut mesh = TestMesh::bumpy_ball(1.0, 3 + random.below(4) as u32);
    mesh.append(&TestMesh::ball(1).placed(0.3 + random.unit(), random.point()));
    ("balls".to_owned(), mesh)
}

fn camera(random: &mut Random) -> Camera {
    let position = match random.below(8) {
        // Straight above, and among the triangles.
        0 => Vec3::new(0.0, 3.0, 0.0),
        1 => random.point(),
        _ => random.point().normalize_or(Vec3::Z) * (1.5 + 3.0 * random.unit()),
    };
    // From nearly zero to nearly π.
    let fov = match random.below(6) {
        0 => 1e-3 + random.unit() * 0.1,
        1 => 3.0 + random.unit() * 0.141,
        _ => 0.3 + random.unit() * 1.4,
    };
    let target = if random.below(8) == 0 { Vec3::ZERO } else { random.point() * 0.7 };
    let camera = Camera::look_at(position, target, Vec3::Y, fov);
    if random.below(5) == 0 {
        Camera { projection: Projection::Orthographic { half_height: 0.1 + 2.0 * random.unit() }, ..camera }
    } else {
        camera
    }
}

fn light(random: &mut Random, mesh: &TestMesh, camera: &Camera) -> LightSource {
    let vertex = mesh.positions[random.below(mesh.positions.len())];
    match random.below(9) {
        // On a surface, in its plane, at the camera, and far away.
        0 if vertex.abs().max_element() < 1e3 => lights::point(vertex),
        1 => lights::point(Vec3::new(random.unit() * 5.0, -1.0, random.unit() * 5.0)),
        2 => lights::point(camera.position),
        3 => lights::point(random.point() * 10.0_f32.powi(random.below(7) as i32)),
        4 => lights::sun(0.0, -1.0, 0.0),
        5 => lights::sun(random.unit() - 0.5, random.unit() - 0.5, random.unit() - 0.5),
        6 => LightSource::Spot {
            position: random.point() * 3.0,
            direction: random.point().normalize_or(Vec3::NEG_Y),
            inner_radians: 0.2,
            outer_radians: 0.3 + random.unit(),
        },
        _ => lights::point(random.point() * 3.0),
    }
}
