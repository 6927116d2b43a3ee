//! Differences of posed vertices.

use std::sync::Arc;

use glam::Vec3;
use umbrage::scene::Frame;
use umbrage::scene::rig::{Pose, Rig};

use super::posing::{PosedVertices, Posing};

/// Differences between a GPU's vertices and the CPU's.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Difference {
    pub(crate) vertices: usize,
    /// Vertices with a coordinate that has other bits; all NaN are the same.
    pub(crate) positions: usize,
    /// The largest distance between two normals.
    pub(crate) normal: f32,
    /// The largest distance between two tangents, with the bitangent's sign as a fourth coordinate.
    pub(crate) tangent: f32,
}

impl Difference {
    /// Tolerance for unit vectors after two matrices and a cross product in f32.
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
