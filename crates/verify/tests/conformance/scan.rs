//! Directions from one origin hit the triangles that the oracle says: all around, through seams, from anywhere.

use glam::{DVec3, Vec3};
use umbrage_rays::predicate::hit;
use umbrage_rays::{Hit, Opaque, Ray, Scan, Scanned, Scanner, Sides, SimdLevel, Sweep, Wanted};
use umbrage_verify::{MIXED_SIDES, Random, TestMesh};

use crate::frames::on_threads;

const FAR: Vec3 = Vec3::new(148_376.0, 1_234.0, -223_423.0);

/// Meshes, each with its size and its middle.
pub(crate) fn meshes() -> Vec<(&'static str, TestMesh, f32, Vec3)> {
    let mut random = Random::new(3);
    let one = TestMesh { positions: vec![Vec3::X, Vec3::Y, Vec3::Z], indices: vec![[0, 1, 2]] };
    let mut torn = TestMesh::ball(1);
    torn.positions[7].y = f32::NAN;
    torn.positions[9].x = f32::INFINITY;
    torn.indices.push([0, 1, 1000]);
    vec![
        ("nothing", TestMesh::default(), 1.0, Vec3::ZERO),
        ("one triangle", one, 1.0, Vec3::ZERO),
        ("coplanar pair", TestMesh::floor(1), 1.0, Vec3::ZERO),
        ("room", TestMesh::room(), 1.0, Vec3::ZERO),
        ("bad shapes", TestMesh::bad_shapes(&mut random), 1.0, Vec3::ZERO),
        ("copies", TestMesh::copies(40), 1.0, Vec3::ZERO),
        ("card", TestMesh::card(), 1e-3, Vec3::ZERO),
        ("torn", torn, 1.0, Vec3::ZERO),
        ("small ball", TestMesh::ball(2).placed(1e-6, Vec3::ZERO), 1e-6, Vec3::ZERO),
        ("large ball", TestMesh::ball(2).placed(1e6, Vec3::ZERO), 1e6, Vec3::ZERO),
        ("distant ball", TestMesh::ball(2).placed(50.0, FAR), 50.0, FAR),
        ("least ball", TestMesh::ball(1).placed(1e-30, Vec3::ZERO), 1e-30, Vec3::ZERO),
        ("largest ball", TestMesh::ball(1).placed(1e30, Vec3::ZERO), 1e30, Vec3::ZERO),
    ]
}

/// Inside, on a corner, on an edge, in a plane, outside, and a million sizes away.
pub(crate) fn origins(mesh: &TestMesh, size: f32, middle: Vec3, random: &mut Random) -> Vec<DVec3> {
    let size = f64::from(size);
    let mut origins = vec![middle.as_dvec3(), middle.as_dvec3() + random.point().as_dvec3() * (0.4 * size)];
    if !mesh.positions.is_empty() {
        let [a, b, c] = mesh.triangles().corners(random.below(mesh.indices.len().min(50)) as u32).map(Vec3::as_dvec3);
        origins.extend([a, a.midpoint(b), a.lerp(b, 0.3).lerp(c, 0.4), b + (b - c) * 0.7]);
    }
    origins.push(middle.as_dvec3() + DVec3::new(3.0, 2.0, -1.0) * size);
    origins.push(middle.as_dvec3() + DVec3::new(0.6, 0.8, -0.3) * (1e6 * size));
    origins
}

/// Directions to corners and edges, anywhere, along axes, at the seams of faces, and invalid; of all lengths.
pub(crate) fn directions(mesh: &TestMesh, origin: DVec3, size: f32, random: &mut Random, count: usize) -> Vec<Vec3> {
    const SIGNS: [f32; 3] = [-1.0, 0.0, 1.0];
    let mut directions = Vec::new();
    for x in SIGNS {
        for y in SIGNS {
            directions.extend(SIGNS.map(|z| Vec3::new(x, y, z)));
        }
    }
    directions.extend([Vec3::NAN, Vec3::new(1.0, f32::INFINITY, 0.0), Vec3::new(1.0, f32::MIN_POSITIVE, 0.0)]);
    while directions.len() < count {
        let target = if mesh.indices.is_empty() || random.below(4) == 0 {
            origin + random.point().as_dvec3() * f64::from(size)
        } else {
            let corners = mesh.triangles().usable_corners(random.below(mesh.indices.len()) as u32);
            let [a, b, c] = corners.unwrap_or([Vec3::X; 3]).map(Vec3::as_dvec3);
            match random.below(4) {
                0 => a,
                // Exactly on the edge, for origins that are near.
                1 => b.midpoint(c),
                2 => b.lerp(c, f64::from(random.unit())),
                _ => a.lerp(b, f64::from(random.unit())).lerp(c, f64::from(random.unit())),
            }
        };
        let mut direction = (target - origin).as_vec3();
        match random.below(8) {
            // On the seam of two faces.
            0 => direction.y = direction.x,
            1 => direction *= 1e3,
            2 => direction *= 1e-3,
            _ => {}
        }
        directions.push(direction);
    }
    directions
}

/// The hits of a ray, nearest first.
fn truth(scan: &Scan<'_>, ray: &Ray, most: usize) -> Vec<Hit> {
    let ids = 0..scan.triangles.len() as u32;
    let hits =
        ids.filter(|&id| scan.triangles.usable_corners(id).is_ok()).filter_map(|id| hit(ray, scan.triangles, id));
    let mut hits: Vec<Hit> = hits
        .filter(|hit| {
            let id = hit.triangle;
            let is_stopped = scan.opacity.is_opaque(id) || scan.opacity.stops(id, hit.barycentric);
            is_stopped && scan.sides.stop(ray, id, scan.triangles.corners(id))
        })
        .collect();
    hits.sort_by(|a, b| a.t.total_cmp(&b.t).then(a.triangle.cmp(&b.triangle)));
    hits.truncate(most);
    hits
}

/// All parts of answers but everything together.
pub(crate) const WANTED: [Wanted; 3] =
    [Wanted::IDS, Wanted { t: true, barycentric: false }, Wanted { t: false, barycentric: true }];

/// Whether an answer has the same bits as that with everything, and nothing that isn't wanted.
pub(crate) fn are_parts(wanted: Wanted, found: &Scanned, all: &Scanned) -> bool {
    let bits = |weights: &[[f32; 2]]| weights.as_flattened().iter().map(|of| of.to_bits()).collect::<Vec<_>>();
    let t: &[f64] = if wanted.t { &all.t } else { &[] };
    let of_weights = if wanted.barycentric { bits(&all.barycentric) } else { Vec::new() };
    found.triangle == all.triangle
        && found.t == t
        && bits(&found.barycentric) == of_weights
        && (found.returns, found.without_direction) == (all.returns, all.without_direction)
}

/// Compares all answers about a scan with the truth.
fn check(name: &str, scanner: &mut Scanner, scan: &Scan<'_>) -> usize {
    const RETURNS: usize = 3;
    let (mut first, mut several, mut any) = (Scanned::default(), Scanned::default(), Vec::new());
    scanner.scan(scan, 1, &mut first);
    scanner.scan(scan, RETURNS, &mut several);
    let without = scanner.hits_any(scan, &mut any);
    let parts = WANTED.map(|wanted| {
        [1, RETURNS].map(|returns| {
            let mut scanned = Scanned::default();
            scanner.scan(&Scan { wanted, ..*scan }, returns, &mut scanned);
            scanned
        })
    });
    for (wanted, [of_one, of_several]) in WANTED.into_iter().zip(&parts) {
        assert!(are_parts(wanted, of_one, &first) && are_parts(wanted, of_several, &several), "{name}: {wanted:?}");
    }
    let (mut index, mut hits, mut bad) = (0, 0, 0);
    for sweep in scan.sweeps {
        for direction in sweep.directions {
            bad += usize::from(!direction.is_finite() || *direction == Vec3::ZERO);
            let direction = direction.as_dvec3();
            let ray = Ray { origin: sweep.origin, direction, t_min: scan.t_min, t_max: scan.t_max };
            let is_somewhere = direction.is_finite() && direction != DVec3::ZERO;
            let truth = if is_somewhere { truth(scan, &ray, RETURNS) } else { Vec::new() };
            assert_eq!(several.hits(index).collect::<Vec<_>>(), truth, "{name}: {ray:?}");
            assert_eq!(first.hits(index).next(), truth.first().copied(), "{name}: {ray:?}");
            assert_eq!(any[index / 64] >> (index % 64) & 1 == 1, !truth.is_empty(), "{name}: {ray:?}");
            hits += truth.len();
            index += 1;
        }
    }
    assert_eq!((first.len(), first.without_direction, without), (index, bad, bad), "{name}");
    hits
}

#[test]
fn scans_do_not_depend_on_threads() {
    let mut random = Random::new(12);
    let mesh = TestMesh::bad_shapes(&mut random);
    // Many in the same tile, and many in the same direction.
    let mut all = directions(&mesh, DVec3::ZERO, 1.0, &mut random, 20_000);
    all.extend(std::iter::repeat_n(Vec3::new(0.1, -0.5, 0.2), 5_000));
    all.extend((0..5_000).map(|_| Vec3::new(0.3, -0.5, 0.2) + random.point() * 1e-6));
    let sweeps = [Sweep { origin: DVec3::new(0.1, 0.2, 0.9), directions: &all }];
    let scan = Scan::new(mesh.triangles(), &sweeps);
    let mut expected: Option<(Scanned, Vec<u64>)> = None;
    for threads in [1, 2, 3, 7] {
        let found = on_threads(threads, || {
            let (mut scanner, mut scanned, mut any) = (Scanner::default(), Scanned::default(), Vec::new());
            scanner.build(scan.triangles);
            scanner.scan(&scan, 2, &mut scanned);
            scanner.hits_any(&scan, &mut any);
            // NaN doesn't equal itself.
            scanned.barycentric.iter_mut().filter(|of| of[0].is_nan()).for_each(|of| *of = [-1.0; 2]);
            (scanned, any)
        });
        assert!(*expected.get_or_insert_with(|| found.clone()) == found, "{threads} threads");
    }
}

#[test]
fn sensors_that_turn_move_and_change_hit_what_the_oracle_says() {
    let mut random = Random::new(62);
    let mesh = TestMesh::ball(2);
    let mut scanner = Scanner::default();
    scanner.build(mesh.triangles());
    let lines = |random: &mut Random, count: usize| -> Vec<Vec3> { (0..count).map(|_| random.point()).collect() };
    // Two sweeps of one call, whose order is kept, and found anew where directions are others.
    let (mut one, mut other) = (lines(&mut random, 1000), lines(&mut random, 300));
    for frame in 0..12 {
        let turn = glam::Quat::from_rotation_y(0.3 * frame as f32);
        let turned: Vec<Vec3> = one.iter().map(|&direction| turn * direction).collect();
        let origin = random.point().as_dvec3() * 0.3;
        let sweeps = [Sweep { origin, directions: &turned }, Sweep { origin: -origin, directions: &other }];
        assert!(check(&format!("frame {frame}"), &mut scanner, &Scan::new(mesh.triangles(), &sweeps)) > 1000);
        match frame % 4 {
            1 => other = lines(&mut random, 300),
            2 => one = lines(&mut random, 1000),
            3 => other.truncate(250),
            _ => one[frame] = Vec3::ZERO,
        }
    }
}

#[test]
fn a_million_in_a_cell_hit_what_the_oracle_says() {
    const MANY: usize = 1_000_000;
    let mut random = Random::new(17);
    let (mut scanner, mut scanned) = (Scanner::default(), Scanned::default());
    // A million copies of one direction.
    let ball = TestMesh::ball(2);
    let directions = vec![Vec3::new(0.3, -0.2, 0.4); MANY];
    let sweeps = [Sweep { origin: DVec3::ZERO, directions: &directions }];
    let scan = Scan::new(ball.triangles(), &sweeps);
    let ray = Ray { origin: DVec3::ZERO, direction: directions[0].as_dvec3(), t_min: 0.0, t_max: f64::INFINITY };
    let expected = truth(&scan, &ray, 1);
    scanner.build(ball.triangles());
    scanner.scan(&scan, 1, &mut scanned);
    assert!(!expected.is_empty());
    assert!((0..MANY).all(|direction| scanned.hits(direction).eq(expected.iter().copied())));
    // A million triangles, all within a ten-thousandth of their distance.
    let mut mesh = TestMesh::default();
    for id in 0..MANY as u32 {
        let corner = Vec3::new(0.0, 0.0, 10.0) + random.point() * 1e-3;
        mesh.positions.extend([corner, corner + random.point() * 1e-4, corner + random.point() * 1e-4]);
        mesh.indices.push([3 * id, 3 * id + 1, 3 * id + 2]);
    }
    let directions: Vec<Vec3> = (0..6).map(|_| Vec3::new(0.0, 0.0, 10.0) + random.point() * 5e-4).collect();
    let sweeps = [Sweep { origin: DVec3::ZERO, directions: &directions }];
    let scan = Scan::new(mesh.triangles(), &sweeps);
    scanner.build(mesh.triangles());
    scanner.scan(&scan, 3, &mut scanned);
    for (index, direction) in directions.iter().enumerate() {
        let ray = Ray { origin: DVec3::ZERO, direction: direction.as_dvec3(), t_min: 0.0, t_max: f64::INFINITY };
        let expected = truth(&scan, &ray, 3);
        assert_eq!(expected.len(), 3, "{direction}");
        assert!(scanned.hits(index).eq(expected), "{direction}");
    }
}

/// Tests that take long, which `cargo run -p ci` runs with `--all` alone.
mod long {
    use super::*;

    #[test]
    fn directions_hit_what_the_oracle_says() {
        let mut random = Random::new(11);
        let mut hits = 0;
        for (name, mesh, size, middle) in meshes() {
            let triangles = mesh.triangles();
            let origins = origins(&mesh, size, middle, &mut random);
            let sets: Vec<_> =
                origins.iter().map(|&origin| directions(&mesh, origin, size, &mut random, 300)).collect();
            let sweeps: Vec<_> =
                origins.iter().zip(&sets).map(|(&origin, directions)| Sweep { origin, directions }).collect();
            for level in SimdLevel::available() {
                let mut scanner = Scanner::with_level(level);
                for threads in [1, 2, 3, 7] {
                    // In the second frame patches are others.
                    hits += on_threads(threads, || {
                        scanner.build(triangles);
                        check(name, &mut scanner, &Scan::new(triangles, &sweeps))
                    });
                }
            }
            let mut scanner = Scanner::default();
            // With grown patches, too.
            (0..2).for_each(|_| scanner.build(triangles));
            let mask = |id: u32, [u, v]: [f32; 2]| !id.is_multiple_of(5) || u + v < 0.5;
            let base = Scan::new(triangles, &sweeps);
            let size = f64::from(size);
            hits += check(name, &mut scanner, &Scan { t_min: 0.3, t_max: 1.0, ..base });
            hits += check(name, &mut scanner, &Scan { t_min: 0.5 * size, t_max: 2.0 * size, ..base });
            hits += check(name, &mut scanner, &Scan { sides: Sides::Front, ..base });
            hits += check(name, &mut scanner, &Scan { sides: MIXED_SIDES, opacity: &mask, ..base });
            hits += check(name, &mut scanner, &Scan { sides: MIXED_SIDES, opacity: &Opaque, ..base });
        }
        assert!(hits > 100_000, "{hits} hits");
    }
}
