//! Few triangles, triangles in difficult places, triangles of bad shapes, and invalid triangles.

use glam::Vec3;
use umbrage_rays::{Camera, LightSource, Sides};
use umbrage_verify::lights::{among_bad_shapes, around, point, sun};
use umbrage_verify::views::{camera, parallel_camera, placed, view};
use umbrage_verify::{Case, Random, TestMesh, meshes_in_bad_places};

use super::{FAR, room, through};

/// A camera at the origin that looks along −z.
fn eye() -> Camera {
    Camera { position: Vec3::ZERO, right: Vec3::X, up: Vec3::Y, forward: Vec3::NEG_Z, ..camera() }
}

/// Every small number of triangles, and the numbers around full groups of 16 and 64.
pub(super) fn few() -> Vec<Case> {
    let mut random = Random::new(2);
    let mut cases = Vec::new();
    for count in (0..24).chain([31, 32, 33, 63, 64, 65, 200]) {
        let mesh = TestMesh::soup(&mut random, count, 0.1);
        let lights = [point(random.point() * 1.5), sun(0.3, -1.0, 0.2), point(Vec3::new(3.0, 5.0, 2.0))];
        let name = format!("{count} triangles");
        cases.push(through(Case::new(name, mesh, view(camera(), 13, 11), &lights), 0.1, 0.9));
    }
    cases
}

pub(super) fn in_bad_places() -> Vec<Case> {
    let at = Vec3::new;
    let mut meshes = meshes_in_bad_places();
    for far in [1e2, 1e7] {
        let mesh = TestMesh::of(&[
            [at(-far, -far, -5.0), at(far, -far, -5.0), at(0.0, far, -5.0)],
            // A floor through the eye plane, another through the eye, and one behind.
            [at(-far, -1.0, far), at(far, -1.0, far), at(0.0, -1.0, -far)],
            [at(-far, 0.0, far), at(far, 0.0, far), at(0.0, 0.0, -far)],
            [at(-far, -far, 5.0), at(far, -far, 5.0), at(0.0, far, 5.0)],
        ]);
        meshes.push(("floors and walls without end", mesh));
    }
    let lights = [point(at(0.5, 2.0, -1.0)), point(Vec3::ZERO), sun(0.2, -1.0, -0.3)];
    let mut cases = Vec::new();
    for (name, mesh) in meshes {
        for (width, height) in [(1, 1), (1, 9), (17, 1), (13, 12), (66, 4)] {
            for camera in [eye(), Camera { projection: parallel_camera().projection, ..eye() }] {
                let name = format!("{name} in {width}×{height}, {:?}", camera.projection);
                cases.push(Case::new(name, mesh.clone(), view(camera, width, height), &lights));
            }
        }
    }
    cases
}

/// Slivers, needles, shells that nearly touch, copies, and triangles around all others.
pub(super) fn of_bad_shapes() -> Vec<Case> {
    let mut cases = Vec::new();
    let mut random = Random::new(31);
    let bad_shapes = TestMesh::bad_shapes(&mut random);
    for (scale, offset) in [(1.0, Vec3::ZERO), (1e-6, Vec3::ZERO), (1e6, Vec3::ZERO), (1.0, FAR), (300.0, FAR)] {
        for camera in [camera(), parallel_camera()] {
            let view = view(placed(camera, scale, offset), 21, 17);
            let mesh = bad_shapes.clone().placed(scale, offset);
            cases.push(Case::new(format!("× {scale}"), mesh, view, &among_bad_shapes(scale, offset)));
        }
    }

    let mut slivers = TestMesh::default();
    for _ in 0..100 {
        let (from, to) = (random.point() * 2.0, random.point() * 2.0);
        let thickness = 1e-7_f32.powf(random.unit());
        slivers.push([from, to, from + (to - from) * random.unit() + random.point() * thickness]);
    }
    for layer in 0..20 {
        // The layers are less than an f32's rounding apart at the camera's distance.
        let depth = 1e-7 * layer as f32;
        slivers.push([Vec3::new(-1.0, -1.0, depth), Vec3::new(1.0, -1.0, -depth), Vec3::new(0.0, 1.0, depth)]);
    }
    let look = Camera::look_at(Vec3::new(2.5, 1.5, 3.5), Vec3::ZERO, Vec3::Y, 0.9);
    cases.push(Case::new("slivers and layers", slivers, view(look, 66, 20), &around(1.0, Vec3::ZERO)[..2]));

    let mut needles = room(6);
    for _ in 0..30 {
        let tip = random.point();
        needles.push([tip, tip + random.point() * 1e-4, tip + random.point() * 3.0]);
        let (a, b) = (random.point(), random.point());
        needles.push([a, b, a.lerp(b, random.unit()) + random.point() * 1e-6]);
    }
    // A shell that touches the floor's plane, some just above it, and copies of one triangle.
    for height in [-1.0, -1.0 + 4e-5, -1.0 + 1e-7] {
        needles.push([(-1.0, 0.5), (1.5, 0.7), (0.2, 2.0)].map(|(x, z)| Vec3::new(x, height, z)));
    }
    (0..30).for_each(|_| needles.push(TestMesh::COPY));
    cases.push(Case::new("needles and shells", needles, view(camera(), 29, 23), &around(1.0, Vec3::ZERO)));

    let mut rooms = room(6);
    rooms.append(&room(6));
    rooms.append(&room(6).placed(1.0, Vec3::new(1e-6, 0.0, 0.0)));
    let vertices = [0, 20, 61].map(|vertex| point(rooms.positions[vertex]));
    let lights: Vec<LightSource> = around(1.0, Vec3::ZERO).into_iter().step_by(2).chain(vertices).collect();
    cases.push(Case::new("a room three times", rooms, view(camera(), 25, 20), &lights));

    let light = Vec3::new(0.0, 1.7, 0.5);
    let mut around_light = room(6);
    for reach in [3.0, 50.0, 1e4, 1e9, 1e18] {
        (0..4).for_each(|_| around_light.push([(); 3].map(|()| random.point() * reach)));
    }
    // One in the plane of the light, one with the light at a corner, one through it.
    around_light.push([light + Vec3::X, light - Vec3::Z * 0.5, light + Vec3::new(-2.0, 0.0, 1.0)]);
    around_light.push([light, light + Vec3::NEG_Y * 0.5, light + Vec3::new(0.3, -0.5, 0.0)]);
    around_light.push([light + Vec3::NEG_Y, light + Vec3::new(1.0, 0.5, 0.0), light + Vec3::new(-1.0, 0.5, 0.0)]);
    let lights: Vec<LightSource> = around(1.0, Vec3::ZERO).into_iter().step_by(3).chain([point(light)]).collect();
    cases.push(Case::new("around the light", around_light, view(camera(), 29, 23), &lights));
    cases
}

/// Triangles with indices out of range, without an area, and with NaN or infinite corners: they change nothing.
pub(super) fn that_are_none() -> Vec<Case> {
    let mut random = Random::new(6);
    let mut soup = TestMesh::soup(&mut random, 100, 0.3);
    let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
    for (which, &value) in bad.iter().cycle().take(9).enumerate() {
        soup.positions[which * 30 + which % 3][which % 3] = value;
    }
    soup.indices[95] = [0, 4, 900_000];
    soup.indices[96] = [1, 2, u32::MAX];
    soup.indices[97] = [4, 4, 5];
    soup.positions[98 * 3] = soup.positions[98 * 3 + 1];
    assert!(soup.triangles().omitted().total() > 10);
    let lights = around(1.0, Vec3::ZERO);
    let mut cases = vec![Case::new("a broken soup", soup, view(camera(), 33, 65), &lights[5..8])];

    let mut broken = room(9);
    for value in bad {
        for axis in 0..3 {
            let mut corner = Vec3::ZERO;
            corner[axis] = value;
            broken.push([corner, Vec3::X, Vec3::Y]);
            broken.push([Vec3::X, Vec3::Y, corner]);
        }
    }
    broken.push([Vec3::X; 3]);
    broken.push([Vec3::X, Vec3::Y, Vec3::X]);
    let count = broken.positions.len() as u32;
    broken.indices.push([0, 1, count]);
    broken.indices.push([u32::MAX, 1, 2]);
    // The ball's triangles at its upper pole have no area either.
    assert_eq!(broken.triangles().omitted().total(), 22 + 18);
    cases.push(Case::new("a broken room", broken.clone(), view(camera(), 29, 23), &lights));
    let fronts = Case::new("fronts of a broken room", broken, view(camera(), 29, 23), &lights[..3]);
    cases.push(Case { sides: Sides::Front, ..fronts });

    let mut only = TestMesh::default();
    (0..40).for_each(|_| only.push([Vec3::X, Vec3::Y, Vec3::NAN]));
    cases.push(Case::new("nothing else", only, view(camera(), 5, 5), &lights[..2]));

    let no_vertices = TestMesh { positions: Vec::new(), indices: vec![[0, 1, 2], [0, 0, 0], [u32::MAX; 3]] };
    cases.push(Case::new("no vertices", no_vertices, view(camera(), 5, 5), &lights[..2]));

    // All combinations of nine coordinates that are finite, NaN or either infinity, except the one that is all finite,
    // with a ball's triangles in between.
    const WAYS: u32 = 4_u32.pow(9);
    let ball = TestMesh::ball(2);
    let mut patterns = TestMesh::default();
    for pattern in 1..WAYS {
        if pattern % 1000 == 1 && ((pattern / 1000) as usize) < ball.indices.len() {
            patterns.push(ball.triangles().corners(pattern / 1000));
        }
        let coordinate = |number: u32| {
            let finite = 0.3 * number as f32 - 1.0;
            [finite, f32::NAN, f32::INFINITY, f32::NEG_INFINITY][(pattern >> (2 * number) & 3) as usize]
        };
        patterns
            .push([0, 3, 6].map(|first| Vec3::new(coordinate(first), coordinate(first + 1), coordinate(first + 2))));
    }
    assert_eq!(patterns.triangles().omitted().total(), WAYS - 1);
    let look = Camera::look_at(Vec3::new(1.0, 2.0, 4.0), Vec3::ZERO, Vec3::Y, 0.8);
    let lights = [point(Vec3::new(1.0, 3.0, 1.0)), point(Vec3::new(0.1, 0.0, 0.0)), sun(0.0, -1.0, 0.0)];
    cases.push(Case::new("every pattern of NaN and infinity", patterns, view(look, 20, 17), &lights));
    cases
}
