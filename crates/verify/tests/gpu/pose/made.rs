//! Rigs made to use all ways of moving vertices, with all kinds of numbers.

use std::sync::Arc;

use glam::{Affine3A, Quat, Vec3, Vec4};
use umbrage::scene::rig::{Deltas, Influences, MorphTarget, Placement, Pose, Rig, RigPart, Shape};
use umbrage_verify::Random;

use super::compare::{Difference, compare};
use super::posing::Posing;
use crate::common::gpu;

/// Number of the skin's joints.
const JOINTS: usize = 5;
/// Weights of a part; a shape may use fewer.
const WEIGHTS: usize = 3;

/// Kinds of coordinates, matrices and weights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Numbers {
    /// Of the size of a room.
    Ordinary,
    /// Any bits at all: subnormal, huge, infinite and not a number.
    Any,
    /// Zeros of both signs and small whole numbers, whose sums often cancel.
    Cancelling,
}

impl Numbers {
    fn next(self, random: &mut Random) -> f32 {
        match self {
            Self::Ordinary => random.below(2_000_001) as f32 * 1e-5 - 10.0,
            Self::Any => f32::from_bits(random.bits() as u32),
            Self::Cancelling => [0.0, -0.0, 1.0, -1.0, 2.0, 0.5][random.below(6)],
        }
    }

    fn vector(self, random: &mut Random) -> Vec3 {
        Vec3::from_array([0; 3].map(|_| self.next(random)))
    }

    fn matrix(self, random: &mut Random) -> Affine3A {
        if self != Self::Ordinary {
            return Affine3A::from_cols_array(&[0; 12].map(|_| self.next(random)));
        }
        let [x, y, z] = [0; 3].map(|_| self.next(random));
        // Also mirrored, and far from flat.
        let scale = self.vector(random).map(|scale| if scale.abs() < 1.0 { 1.0 } else { scale });
        Affine3A::from_scale_rotation_translation(
            scale,
            Quat::from_rotation_x(x) * Quat::from_rotation_y(y),
            Vec3::splat(z),
        )
    }

    fn deltas(self, vertices: usize, random: &mut Random) -> Deltas {
        match random.below(3) {
            0 => Deltas::Dense((0..vertices).map(|_| self.vector(random)).collect()),
            1 => {
                let some: Vec<u32> = (0..vertices as u32).filter(|_| random.below(4) == 0).collect();
                Deltas::Sparse { deltas: some.iter().map(|_| self.vector(random)).collect(), vertices: some }
            }
            _ => Deltas::default(),
        }
    }
}

fn shape(numbers: Numbers, vertices: usize, sets: usize, random: &mut Random) -> Shape {
    let mut unit = || Numbers::Ordinary.vector(random).normalize_or_zero();
    let normals: Vec<_> = (0..vertices).map(|_| unit()).collect();
    let tangents: Vec<Vec4> = (0..vertices).map(|place| unit().extend([1.0, -1.0][place % 2])).collect();
    let influences = |random: &mut Random| {
        let weights = [0; 4].map(|_| random.below(4) as f32 / 4.0);
        let weights =
            if numbers == Numbers::Any { weights.map(|weight| weight * numbers.next(random)) } else { weights };
        let joints = weights.map(|weight| if weight > 0.0 { random.below(JOINTS) as u16 } else { 0 });
        Influences { joints, weights }
    };
    let target = |random: &mut Random| MorphTarget {
        positions: numbers.deltas(vertices, random),
        normals: Numbers::Ordinary.deltas(vertices, random),
        tangents: Numbers::Ordinary.deltas(vertices, random),
    };
    let with_normals = random.below(4) > 0;
    let with_tangents = with_normals && random.below(3) > 0;
    Shape {
        positions: (0..vertices).map(|_| numbers.vector(random)).collect(),
        normals: if with_normals { normals } else { Vec::new() },
        tangents: if with_tangents { tangents } else { Vec::new() },
        influences: (0..sets).map(|_| (0..vertices).map(|_| influences(random)).collect()).collect(),
        morph_targets: (0..random.below(WEIGHTS + 1)).map(|_| target(random)).collect(),
    }
}

/// Skinned and rigid copies of shapes of all sizes; every second one moves.
fn rig(numbers: Numbers, random: &mut Random) -> Rig {
    let sizes = [1, 3, 64, 65, 200, 7, 1000];
    let shapes: Vec<_> =
        sizes.into_iter().enumerate().map(|(place, size)| Arc::new(shape(numbers, size, place % 3, random))).collect();
    let mut parts = Vec::new();
    let mut vertices = 0;
    for copy in 0..20 {
        let shape = random.below(shapes.len()) as u32;
        let is_skinned = !shapes[shape as usize].influences.is_empty();
        // The moving matrices are a skin's, then a rigid one; the still ones are the same again.
        let moves = copy % 2 == 0;
        let first_matrix = if moves { 0 } else { JOINTS as u32 + 1 };
        let placement = if is_skinned {
            Placement::Skinned { first_matrix }
        } else {
            Placement::Rigid { matrix: first_matrix + JOINTS as u32 }
        };
        // Weights move as well.
        let first_weight = if moves { 0 } else { WEIGHTS as u32 };
        parts.push(RigPart { shape, first_vertex: vertices as u32, first_weight, placement, moves });
        vertices += shapes[shape as usize].positions.len();
    }
    Rig { shapes, parts, vertices, has_normals: true, has_tangents: true, moving_matrices: JOINTS + 1 }
}

/// A pose with new moving matrices and weights, and the rest from `still`.
fn moved(numbers: Numbers, still: &Pose, random: &mut Random) -> Pose {
    let mut pose = still.clone();
    pose.matrices[..=JOINTS].fill_with(|| numbers.matrix(random));
    pose.weights[..WEIGHTS].fill_with(|| if random.below(3) == 0 { 0.0 } else { numbers.next(random) });
    pose
}

fn first_pose(numbers: Numbers, random: &mut Random) -> Pose {
    let matrices = (0..2 * (JOINTS + 1)).map(|_| numbers.matrix(random)).collect();
    Pose { matrices, weights: (0..2 * WEIGHTS).map(|_| numbers.next(random)).collect() }
}

#[test]
fn ordinary_rigs_are_posed_alike() {
    let Some(gpu) = gpu() else { return };
    let mut posing = Posing::new(gpu);
    let mut random = Random::new(1);
    for number in 0..20 {
        let rig = Arc::new(rig(Numbers::Ordinary, &mut random));
        let mut pose = first_pose(Numbers::Ordinary, &mut random);
        for moment in 0..3 {
            compare(&mut posing, &rig, &pose).0.expect_rounding(&format!("rig {number}, moment {moment}"));
            pose = moved(Numbers::Ordinary, &pose, &mut random);
        }
    }
}

#[test]
fn positions_are_alike_whatever_the_numbers() {
    let Some(gpu) = gpu() else { return };
    let mut posing = Posing::new(gpu);
    let mut random = Random::new(2);
    for numbers in [Numbers::Any, Numbers::Cancelling] {
        for number in 0..20 {
            let rig = Arc::new(rig(numbers, &mut random));
            let mut pose = first_pose(numbers, &mut random);
            for moment in 0..3 {
                let (difference, _) = compare(&mut posing, &rig, &pose);
                assert_eq!(difference.positions, 0, "rig {number}, moment {moment}, {numbers:?}: {difference:?}");
                pose = moved(numbers, &pose, &mut random);
            }
        }
    }
}

#[test]
fn the_comparison_finds_what_differs() {
    let Some(gpu) = gpu() else { return };
    let mut posing = Posing::new(gpu);
    let mut random = Random::new(3);
    let rig = Arc::new(rig(Numbers::Ordinary, &mut random));
    let pose = first_pose(Numbers::Ordinary, &mut random);
    let (_, posed) = compare(&mut posing, &rig, &pose);
    let mut frame = umbrage::scene::Frame::default();
    rig.pose(&pose, &mut frame);
    assert_eq!(Difference::between(&frame, &posed).positions, 0);
    frame.positions[100].y = frame.positions[100].y.next_up();
    frame.normals[7] += Vec3::splat(1e-4);
    frame.tangents[8].w = f32::NAN;
    let difference = Difference::between(&frame, &posed);
    assert_eq!(difference.positions, 1);
    assert!(difference.normal > Difference::ROUNDED && difference.tangent.is_nan(), "{difference:?}");
}

#[test]
fn still_vertices_are_posed_once() {
    let Some(gpu) = gpu() else { return };
    let mut posing = Posing::new(gpu);
    let mut random = Random::new(4);
    let rig = Arc::new(rig(Numbers::Ordinary, &mut random));
    let first = first_pose(Numbers::Ordinary, &mut random);
    let (difference, posed) = compare(&mut posing, &rig, &first);
    difference.expect_rounding("first pose");
    // Matrices outside of the moving ones must stay.
    let mut broken = first.clone();
    broken.matrices[JOINTS + 1..].fill(Affine3A::ZERO);
    let (difference, again) = compare(&mut posing, &rig, &broken);
    assert!(difference.positions > rig.vertices / 4, "{difference:?}");
    assert_eq!((posed.positions, posed.normals), (again.positions, again.normals));
    // Another rig with the same tables is a new one.
    let other = Arc::new(Rig { shapes: Vec::new(), parts: Vec::new(), vertices: 0, ..*rig });
    compare(&mut posing, &other, &Pose::default()).0.expect_rounding("a rig without vertices");
    compare(&mut posing, &rig, &broken).0.expect_rounding("a new rig");
}
