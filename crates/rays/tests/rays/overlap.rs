//! Triangles that touch boxes, against clipping in exact fractions.

use glam::Vec3;
use umbrage_rays::{Bounds, Nearest, SimdLevel, Triangles, Within};

use crate::exact::meets_box;
use crate::support::{Mesh, Random, blocks, scene};

/// The lists of every level, on one thread and on two: the same.
fn overlapping(triangles: Triangles<'_>, boxes: &[Bounds]) -> Within {
    let mut all = Vec::new();
    for level in SimdLevel::available() {
        for threads in [1, 2] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            let (mut nearest, mut found) = (Nearest::with_level(level), Within::default());
            pool.install(|| {
                nearest.build(triangles);
                nearest.overlapping(triangles, boxes, &mut found);
            });
            all.push(found);
        }
    }
    let first = all.swap_remove(0);
    assert!(all.iter().all(|other| *other == first), "levels and threads differ");
    first
}

fn check(name: &str, triangles: Triangles<'_>, boxes: &[Bounds]) {
    let found = overlapping(triangles, boxes);
    for (index, bounds) in boxes.iter().enumerate() {
        let is_near = |id: &u32| {
            let corners = triangles.indices[*id as usize].map(|vertex| triangles.positions.get(vertex as usize));
            let [Some(a), Some(b), Some(c)] = corners else { return false };
            [a, b, c].iter().all(|corner| corner.is_finite()) && meets_box([*a, *b, *c], *bounds)
        };
        let expected: Vec<u32> = (0..triangles.len() as u32).filter(is_near).collect();
        assert_eq!(found.of(index), expected, "{name}: {bounds:?}");
    }
}

/// Boxes around, beside, in and through triangles, some of them flat.
fn boxes(random: &mut Random, triangles: Triangles<'_>, reach: f32, count: usize) -> Vec<Bounds> {
    let finite: Vec<Vec3> = triangles.positions.iter().copied().filter(|at| at.is_finite()).collect();
    let boxes = (0..count).map(|step| {
        let mut pick = || finite[random.bits() as usize % finite.len()];
        let [a, b] = [pick(), pick()];
        let size = reach * 10.0_f32.powi(-(step as i32 / 8 % 6));
        let at = a.lerp(b, random.unit());
        match step % 8 {
            0 => Bounds { min: a.min(b), max: a.max(b) },
            1 => Bounds { min: a, max: a + random.point().abs() * size },
            2 => Bounds { min: at - size * 0.25, max: at + size * 0.25 },
            3 => Bounds { min: a, max: a },
            4 => Bounds { min: at.with_y(a.y), max: (at + random.point().abs() * size).with_y(a.y) },
            5 => Bounds { min: a - Vec3::X * size, max: a },
            6 => Bounds {
                min: (at * 8.0 / reach).round() * reach / 8.0,
                max: (at * 8.0 / reach).round() * reach / 8.0 + size,
            },
            _ => Bounds { min: at, max: at + random.point().abs() * size },
        }
    });
    boxes.filter(|bounds| bounds.min.cmple(bounds.max).all()).collect()
}

#[test]
fn lists_are_those_of_exact_clipping() {
    let mut random = Random(91);
    for scale in [1.0, 1e-30, 1e-3, 1e6, 1e30] {
        let meshes = [
            ("a scene", scene(&mut random)),
            ("blocks", blocks(&mut random, 8)),
            ("a ball", Mesh::bumpy_ball(Vec3::ZERO, 1.0, 6)),
            ("a floor", Mesh::floor(4, 1.0)),
        ];
        for (name, mesh) in meshes {
            let mesh = mesh.moved(scale, Vec3::ZERO);
            let boxes = boxes(&mut random, mesh.triangles(), scale, 48);
            check(&format!("{name} of {scale:e}"), mesh.triangles(), &boxes);
        }
    }
}

#[test]
fn touching_counts() {
    let mesh = Mesh { positions: vec![Vec3::X, Vec3::Y, Vec3::Z], indices: vec![[0, 1, 2], [0, 0, 1], [2, 2, 2]] };
    let third = 1.0 / 3.0;
    let at = |min: f32, max: f32| Bounds { min: Vec3::splat(min), max: Vec3::splat(max) };
    let boxes = [
        // In front of the plane x + y + z = 1, up to it, and beyond.
        at(-1.0, 0.25),
        at(-1.0, third),
        at(-1.0, third.next_up()),
        // The edge and the point.
        Bounds { min: Vec3::new(0.5, 0.5, 0.0), max: Vec3::new(0.5, 0.5, 0.0) },
        Bounds { min: Vec3::Z, max: Vec3::splat(2.0) },
        Bounds { min: Vec3::Z + Vec3::Z * f32::EPSILON, max: Vec3::splat(2.0) },
        // Everything and nothing.
        Bounds { min: Vec3::NEG_INFINITY, max: Vec3::INFINITY },
        Bounds::EMPTY,
        Bounds { min: Vec3::NAN, max: Vec3::INFINITY },
    ];
    let found = overlapping(mesh.triangles(), &boxes);
    // A third in f32 is above it.
    let expected: [&[u32]; 9] = [&[], &[0], &[0], &[0, 1], &[0, 2], &[], &[0, 1, 2], &[], &[]];
    for (index, expected) in expected.iter().enumerate() {
        assert_eq!(found.of(index), *expected, "{:?}", boxes[index]);
    }
    let none = overlapping(Triangles::default(), &boxes);
    assert!((0..boxes.len()).all(|index| none.of(index).is_empty()));
}
