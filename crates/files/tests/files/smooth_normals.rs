//! Normals for OBJ, PLY and STL files without any.

use std::fmt::Write;
use std::time::{Duration, Instant};

use glam::Vec3;
use umbrage_files::OpenOptions;
use umbrage_scene::{Error, Frame};

use crate::solids::floats;

/// Positions and polygons of three or more corners.
struct Solid {
    positions: Vec<Vec3>,
    polygons: Vec<Vec<usize>>,
}

impl Solid {
    /// A solid of revolution around the y axis, from rings of height and radius, upwards; ends with a radius above zero are
    /// closed by polygons.
    fn turned(rings: &[(f32, f32)], sides: usize) -> Self {
        let (mut positions, mut polygons) = (Vec::new(), Vec::new());
        for &(height, radius) in rings {
            positions.extend((0..sides).map(|side| {
                let (sine, cosine) = (side as f32 / sides as f32 * std::f32::consts::TAU).sin_cos();
                Vec3::new(cosine * radius, height, -sine * radius)
            }));
        }
        for ring in 1..rings.len() {
            let [below, above] = [ring - 1, ring].map(|ring| ring * sides);
            for side in 0..sides {
                let next = (side + 1) % sides;
                let corners = [below + side, below + next, above + next, above + side];
                let distinct = |&corner: &usize| rings[corner / sides].1 > 0.0 || corner % sides == 0;
                // All corners at a tip are one.
                let tip = |corner: usize| if rings[corner / sides].1 > 0.0 { corner } else { corner / sides * sides };
                let mut polygon = corners.map(tip).to_vec();
                polygon.dedup();
                assert!(polygon.iter().all(distinct));
                polygons.push(polygon);
            }
        }
        let cap = |ring: usize| ring * sides..(ring + 1) * sides;
        if rings[0].1 > 0.0 {
            polygons.push(cap(0).rev().collect());
        }
        if rings[rings.len() - 1].1 > 0.0 {
            polygons.push(cap(rings.len() - 1).collect());
        }
        Self { positions, polygons }
    }

    fn sphere() -> Self {
        let ring = |step: u8| (f32::from(step) / 24.0 * std::f32::consts::PI).sin_cos();
        let rings: Vec<_> =
            (0..=24).map(|step| (-ring(step).1, if step % 24 == 0 { 0.0 } else { ring(step).0 })).collect();
        Self::turned(&rings, 48)
    }

    fn placed(mut self, scale: f32, offset: Vec3) -> Self {
        self.positions.iter_mut().for_each(|position| *position = *position * scale + offset);
        self
    }

    fn obj(&self) -> Vec<u8> {
        let mut text = String::new();
        self.positions.iter().for_each(|p| writeln!(text, "v {} {} {}", p.x, p.y, p.z).unwrap());
        for polygon in &self.polygons {
            text.push('f');
            polygon.iter().for_each(|corner| write!(text, " {}", corner + 1).unwrap());
            text.push('\n');
        }
        text.into_bytes()
    }

    fn ply(&self) -> Vec<u8> {
        let [vertices, faces] = [self.positions.len(), self.polygons.len()];
        let mut text = format!(
            "ply\nformat ascii 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\n\
             element face {faces}\nproperty list int int vertex_indices\nend_header\n"
        );
        self.positions.iter().for_each(|p| writeln!(text, "{} {} {}", p.x, p.y, p.z).unwrap());
        for polygon in &self.polygons {
            write!(text, "{}", polygon.len()).unwrap();
            polygon.iter().for_each(|corner| write!(text, " {corner}").unwrap());
            text.push('\n');
        }
        text.into_bytes()
    }

    /// As STL, whose corners have positions only.
    fn stl(&self) -> Vec<u8> {
        let fan = |polygon: &Vec<usize>| {
            let corner = |index: usize| self.positions[polygon[index]].to_array();
            let triangle = |last: usize| [[0.0; 3], corner(0), corner(last - 1), corner(last)].concat();
            (2..polygon.len()).map(|last| [floats(&triangle(last), false), vec![0; 2]].concat()).collect::<Vec<_>>()
        };
        let triangles: Vec<Vec<u8>> = self.polygons.iter().flat_map(fan).collect();
        [vec![0; 80], (triangles.len() as u32).to_le_bytes().to_vec(), triangles.concat()].concat()
    }
}

fn opened(name: &str, bytes: Vec<u8>, crease_degrees: f32) -> Frame {
    let options = OpenOptions { crease_degrees, ..OpenOptions::default() };
    let frame = umbrage_files::open_files(name, [(name, bytes)], &options).unwrap().at(0.0).unwrap();
    frame.check().unwrap();
    frame
}

/// The position and the normal of each corner of each triangle.
fn corners(frame: &Frame) -> Vec<[(Vec3, Vec3); 3]> {
    let corner = |vertex: u32| (frame.positions[vertex as usize], frame.normals[vertex as usize]);
    let shaded = |triangle: [(Vec3, Vec3); 3]| {
        // A triangle is flat if all of its normals are zero.
        let is_flat = triangle.iter().all(|(_, normal)| *normal == Vec3::ZERO);
        if is_flat { triangle.map(|(position, _)| (position, own_normal(triangle))) } else { triangle }
    };
    frame.mesh.triangles.iter().map(|triangle| shaded(triangle.map(corner))).collect()
}

fn own_normal([a, b, c]: [(Vec3, Vec3); 3]) -> Vec3 {
    (b.0 - a.0).cross(c.0 - a.0).normalize()
}

#[test]
fn a_sphere_of_triangles_is_round_in_every_format_at_any_size() {
    for (name, bytes) in
        [("a.obj", Solid::sphere().obj()), ("a.ply", Solid::sphere().ply()), ("a.stl", Solid::sphere().stl())]
    {
        let [flat, smooth] = [0.0, 60.0].map(|crease| opened(name, bytes.clone(), crease));
        assert!(flat.normals.is_empty(), "{name}");
        // The triangles' positions are exactly the same.
        let positions = |frame: &Frame| {
            let triangles = frame.triangles();
            (0..triangles.len() as u32).map(|id| triangles.corners(id)).collect::<Vec<_>>()
        };
        assert_eq!(positions(&flat), positions(&smooth), "{name}");
        assert_eq!(flat.positions.len(), smooth.positions.len(), "{name}: nothing is split");
        for (position, normal) in corners(&smooth).into_iter().flatten() {
            assert!(
                (normal.length() - 1.0).abs() < 1e-5 && position.dot(normal) > 0.9999,
                "{name}: {normal} at {position}"
            );
        }
    }
    for scale in [1e-18, 1e-6, 1e15] {
        let smooth = opened("a.obj", Solid::sphere().placed(scale, Vec3::ZERO).obj(), 60.0);
        for (position, normal) in corners(&smooth).into_iter().flatten() {
            assert!((position / scale).dot(normal) > 0.9999, "{normal} at {position}");
        }
    }
}

#[test]
fn a_cube_stays_as_it_is() {
    let cube = Solid::turned(&[(-1.0, 1.0), (1.0, 1.0)], 4);
    for (name, bytes) in [("a.obj", cube.obj()), ("a.ply", cube.ply()), ("a.stl", cube.stl())] {
        let frame = opened(name, bytes, 60.0);
        assert_eq!((frame.normals.len(), frame.positions.len()), (0, 8));
    }
}

#[test]
fn a_cylinder_is_round_around_and_has_creases_at_its_ends() {
    let tin = Solid::turned(&[(-1.0, 1.0), (1.0, 1.0)], 24);
    for (name, bytes) in [("a.obj", tin.obj()), ("a.stl", tin.stl())] {
        let frame = opened(name, bytes, 60.0);
        assert_eq!(frame.positions.len(), 4 * 24, "{name}");
        for triangle in corners(&frame) {
            let is_cap = own_normal(triangle).y.abs() > 0.5;
            for (position, normal) in triangle {
                let expected = if is_cap { Vec3::Y * position.y } else { position.with_y(0.0) };
                assert!(normal.dot(expected) > 0.9999, "{name}: {normal} at {position}");
            }
        }
    }
}

#[test]
fn the_crease_says_which_edges_are_round() {
    // Neighbouring sides meet at 45°.
    let column = Solid::turned(&[(-1.0, 1.0), (1.0, 1.0)], 8).obj();
    assert!(opened("a.obj", column.clone(), 44.0).normals.is_empty());
    let bent = |frame: &Frame| {
        let of = corners(frame);
        of.iter().filter(|triangle| triangle.iter().any(|corner| corner.1.dot(own_normal(**triangle)) < 0.99)).count()
    };
    assert_eq!(bent(&opened("a.obj", column.clone(), 46.0)), 16);
    assert_eq!(bent(&opened("a.obj", column, 180.0)), 16 + 2 * 6);
    for wrong in [-1.0, 180.5, f32::NAN] {
        let options = OpenOptions { crease_degrees: wrong, ..OpenOptions::default() };
        let error = umbrage_files::open_files("a.obj", [("a.obj", Solid::sphere().obj())], &options).unwrap_err();
        assert!(error.to_string().contains("give 0 to 180"), "{error}");
    }
}

#[test]
fn the_tip_of_a_cone_has_the_normals_of_its_sides() {
    let cone = opened("a.obj", Solid::turned(&[(0.0, 1.0), (3.0, 0.0)], 48).obj(), 60.0);
    let is_tip = |corner: &(Vec3, Vec3)| corner.0.y > 2.9;
    let sides: Vec<_> = corners(&cone).into_iter().filter(|triangle| triangle.iter().any(is_tip)).collect();
    assert_eq!(sides.len(), 48);
    for side in sides {
        let tip = side.iter().find(|corner| is_tip(corner)).unwrap();
        assert!(tip.1.dot(own_normal(side)) > 0.9999, "{}", tip.1);
    }
}

#[test]
fn larger_triangles_and_wider_angles_weigh_more() {
    // Two triangles at 45° with right angles at the first vertex; one is larger.
    let frame = opened("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 -4 4\nf 1 2 3\nf 1 4 2\n".to_vec(), 60.0);
    let slanted = Vec3::new(0.0, 4.0, 4.0);
    let expected = (Vec3::Z + slanted).normalize();
    assert!(frame.normals[0].distance(expected) < 1e-6, "{}", frame.normals[0]);
}

#[test]
fn triangles_without_an_area_have_no_say() {
    let frame = opened(
        "a.obj",
        b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 -4 4\nv nan 0 0\nf 1 2 3\nf 1 4 2\nf 1 2 2\nf 1 2 5\n".to_vec(),
        60.0,
    );
    assert!(frame.normals.iter().all(|normal| normal.is_finite()));
    for triangle in &corners(&frame)[..2] {
        let normal = triangle[0].1;
        assert!(normal.distance((Vec3::Z + Vec3::new(0.0, 4.0, 4.0)).normalize()) < 1e-6, "{normal}");
    }
}

#[test]
fn a_hundred_thousand_triangles_around_one_edge_take_no_longer_than_elsewhere() {
    const COUNT: usize = 200_000;
    let at_an_edge = Solid {
        positions: (0..COUNT).map(|index| Vec3::new(index as f32, 1.0, 0.0)).chain([Vec3::ZERO, Vec3::Z]).collect(),
        polygons: (0..COUNT).map(|index| vec![index, COUNT, COUNT + 1]).collect(),
    };
    let around_a_point = Solid {
        positions: (0..COUNT).map(|index| Vec3::new(index as f32, 1.0, 0.0)).chain([Vec3::ZERO]).collect(),
        polygons: (1..COUNT).map(|index| vec![index - 1, index, COUNT]).collect(),
    };
    for solid in [at_an_edge, around_a_point] {
        let bytes = solid.stl();
        let start = Instant::now();
        opened("a.stl", bytes, 60.0);
        assert!(start.elapsed() < Duration::from_secs(10), "{:?}", start.elapsed());
    }
}

#[test]
fn smoothing_takes_from_the_memory_that_opening_may_take() {
    let bytes = Solid::sphere().stl();
    let open = |max_memory: u64| {
        let options = OpenOptions { max_memory, ..OpenOptions::default() };
        umbrage_files::open_files("a.stl", [("a.stl", bytes.clone())], &options)
    };
    open(2 << 20).unwrap();
    let error = open(240_000).unwrap_err();
    assert!(matches!(error, Error::Memory { .. }) && error.to_string().contains("--crease 0"), "{error}");
}
