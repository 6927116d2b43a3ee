//! Joints and weights of skinned vertices.

use glam::{Affine3A, Vec3A};

/// Four joints of a vertex and their weights: 24 bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Influences {
    /// Indices of the skin's joints.
    pub joints: [u16; 4],
    /// At least zero; all weights of a vertex add up to one over all sets. Joints without weight are joint 0.
    pub weights: [f32; 4],
}

impl Influences {
    /// Normalizes each vertex's weights over all `sets` to a sum of one, and sets joints without weight to joint 0. Vertices
    /// without any usable weight follow joint 0; returns their number.
    pub(crate) fn normalize(sets: &mut [Vec<Self>], vertices: usize) -> usize {
        if sets.is_empty() {
            return 0;
        }
        let mut stray = 0;
        for vertex in 0..vertices {
            for set in &mut *sets {
                // NaN becomes 0.
                set[vertex].weights = set[vertex].weights.map(|weight| weight.max(0.0));
            }
            let sum: f32 = sets.iter().flat_map(|set| set[vertex].weights).sum();
            let usable = sum > 0.0 && sum.is_finite();
            for set in &mut *sets {
                let Self { joints, weights } = &mut set[vertex];
                *weights = weights.map(|weight| if usable { weight / sum } else { 0.0 });
                for (joint, weight) in joints.iter_mut().zip(weights) {
                    if *weight <= 0.0 {
                        *joint = 0;
                    }
                }
            }
            if !usable {
                stray += 1;
                sets[0][vertex].weights[0] = 1.0;
            }
        }
        stray
    }

    /// The highest joint of all vertices.
    pub(crate) fn highest_joint(sets: &[Vec<Self>]) -> Option<u32> {
        sets.iter().flatten().flat_map(|influences| influences.joints).max().map(u32::from)
    }

    /// The joint with the largest weight over a triangle's corners; the lowest of several.
    pub(crate) fn main_joint(sets: &[Vec<Self>], corners: [u32; 3]) -> u16 {
        let of_corners = || sets.iter().flat_map(|set| corners.map(|corner| set[corner as usize]));
        let weight = |joint: u16| -> f32 {
            let all = of_corners().flat_map(|all| all.joints.into_iter().zip(all.weights));
            all.filter(|&(other, _)| other == joint).map(|(_, weight)| weight).sum()
        };
        let joints = of_corners().flat_map(|all| all.joints);
        joints.max_by(|&a, &b| weight(a).total_cmp(&weight(b)).then(b.cmp(&a))).unwrap_or(0)
    }

    /// Adds the weighted transforms of this vertex's joints to `sum`; `joints` are the skin's.
    pub(crate) fn add_to(&self, sum: &mut Affine3A, joints: &[Affine3A]) {
        for (&joint, &weight) in self.joints.iter().zip(&self.weights) {
            let joint = &joints[usize::from(joint)];
            let weight = Vec3A::splat(weight);
            sum.matrix3.x_axis += joint.matrix3.x_axis * weight;
            sum.matrix3.y_axis += joint.matrix3.y_axis * weight;
            sum.matrix3.z_axis += joint.matrix3.z_axis * weight;
            sum.translation += joint.translation * weight;
        }
    }
}
