//! How posed vertices differ.

use std::sync::Arc;

use glam::Vec3;
use umbrage::scene::Frame;
use umbrage::scene::rig::{Pose, Rig};

use super::posing::{PosedVertices, Posing};

/// How a GPU's vertices differ from the CPU's.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Difference {
    pub(crate) vertices: usize,
    /// Vertices of which a coordinate has other bits. All NaN are one.
    pub(crate) positions: usize,
    /// The largest distance of two normals.
    pub(crate) normal: f32,
    /// The largest distance of two tangents, signs of bitangents counting as a fourth coordinate.
    pub(crate) tangent: f32,
}

impl Difference {
    /// Of unit vectors that went through two matrices and a cross product in f32.
    pub(crate) const ROUNDED: f32 = 1e-5;

    pub(crate) fn between(cpu: &Frame, gpu: &PosedVertices) -> Self {
        let counts = [&cpu.positions, &cpu.normals].map(Vec::len);
        assert_eq!(counts, [&gpu.positions, &gpu.normals].map(Vec::len));
        assert_eq!(cpu.tangents.len(), gpu.tangents.len());
        let is_other = |(one, other): &(&Vec3, &Vec3)| {
            let pairs = one.to_array().into_iter().zip(other.to_array());
            pairs.into_iter().any(|(one, other)| one.to_bits() != other.to_bits() && !(one.is_nan() && other.is_nan()))
        };
        let largest = |distances: &mut dyn Iterator<Item = f32>| {
            distances.fold(0.0, |most: f32, distance| if most.is_nan() || distance <= most { most } else { distance })
        };
        Self {
            vertices: cpu.positions.len(),
            positions: cpu.positions.iter().zip(&gpu.positions).filter(is_other).count(),
            normal: largest(&mut cpu.normals.iter().zip(&gpu.normals).map(|(one, other)| one.distance(*other))),
            tangent: largest(&mut cpu.tangents.iter().zip(&gpu.tangents).map(|(one, other)| one.distance(*other))),
        }
    }

    pub(crate) fn expect_rounding(&self, name: &str) {
        let is_rounding = self.normal < Self::ROUNDED && self.tangent < Self::ROUNDED;
        assert!(self.positions == 0 && is_rounding, "{name}: {self:?}");
    }
}

/// Poses a rig both ways.
pub(crate) fn compare(posing: &mut Posing, rig: &Arc<Rig>, pose: &Pose) -> (Difference, PosedVertices) {
    let mut frame = Frame::default();
    rig.pose(pose, &mut frame);
    let posed = posing.pose(rig, pose).unwrap_or_else(|error| panic!("{error}"));
    (Difference::between(&frame, &posed), posed)
}
