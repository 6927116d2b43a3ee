//! One scene, frame after frame: a structure may come from an earlier frame.

use glam::{Quat, Vec3};
use rayon::prelude::*;
use umbrage_verify::lights::{point, sun};
use umbrage_verify::views::{camera, view};
use umbrage_verify::{Case, Random, TestMesh};

use crate::check::Known;

/// Parts that stay, turn, wave, fly far away and back, shrink to a plane, and come apart; in the end the parts are
/// others, and then there are no triangles.
pub(super) fn frames() -> Vec<Known> {
    let mut random = Random::new(77);
    let soup = TestMesh::soup(&mut random, 40, 0.05);
    let ball = TestMesh::bumpy_ball(0.5, 8);
    let mut frames: Vec<Case> = (0..9).map(|step| frame(step, &ball, &soup)).collect();
    let mut other = frame(2, &ball, &soup);
    other.mesh.indices.rotate_left(2);
    let lights = other.lights.clone();
    frames.push(Case { name: "other triangles".to_owned(), ..other });
    let mut other = frame(3, &ball, &soup);
    other.part_of_triangle.iter_mut().for_each(|part| *part ^= 1);
    frames.push(Case { name: "other parts".to_owned(), ..other });
    frames.push(Case::new("nothing", TestMesh::default(), view(camera(), 24, 16), &lights));
    // The referee would take minutes, and other cases test each kind of triangle with it.
    let known = |case: Case| {
        let truth = case.truth();
        Known::with_truth(case, truth)
    };
    frames.into_par_iter().map(known).collect()
}

fn frame(step: u32, ball: &TestMesh, soup: &TestMesh) -> Case {
    let time = step as f32 * 0.37;
    let (mut mesh, mut part_of_triangle) = (TestMesh::default(), Vec::new());
    let mut add = |part: &TestMesh, at: &dyn Fn(Vec3) -> Vec3| {
        let mut moved = part.clone();
        moved.positions.iter_mut().for_each(|position| *position = at(*position));
        mesh.append(&moved);
        let part = part_of_triangle.last().map_or(0, |last| last + 1);
        part_of_triangle.resize(mesh.indices.len(), part);
    };
    let turn = Quat::from_axis_angle(Vec3::new(1.0, 2.0, 0.5).normalize(), time);
    add(&TestMesh::plane(12, 4.0), &|at| at + Vec3::NEG_Y);
    add(ball, &|at| turn * at + Vec3::new(0.4, 0.1 * time, 0.2));
    add(&TestMesh::plane(6, 1.5), &|at| at + Vec3::Y * 0.2 * (3.0 * at.x + time).sin());
    // Far enough to have few bits left, and back.
    let far = if step % 3 == 1 { Vec3::splat(3e5) } else { Vec3::ZERO };
    add(ball, &|at| at * Vec3::new(1.0, 1.0, if step == 5 { 0.0 } else { 0.5 }) + Vec3::NEG_X + far);
    add(soup, &|at| at * (1.0 + time * time));
    if step % 4 == 2 {
        mesh.positions[200].y = f32::NAN;
    }
    mesh.indices.push([0, 1, if step == 6 { 2 } else { u32::MAX }]);
    mesh.indices.push([7, 7, 8]);
    part_of_triangle.extend([0, 0]);
    // With an even number, the structure is built once for each frame.
    assert!(mesh.indices.len().is_multiple_of(2));
    let lights = [point(Vec3::new(1.0, 4.0, 2.0)), sun(0.3, -1.0, 0.2)];
    let case = Case::new(format!("step {step}"), mesh, view(camera(), 30, 22), &lights);
    Case { part_of_triangle, ..case }
}
