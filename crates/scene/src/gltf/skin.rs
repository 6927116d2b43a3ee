//! Skins: which joints a vertex follows, and from where.

use glam::{Affine3A, Mat4, Vec3A};

use super::document::Document;
use super::nodes::Nodes;
use crate::Error;

/// Four joints that a vertex follows, and how much: 24 bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Influences {
    /// Places among the skin's joints.
    pub joints: [u16; 4],
    /// Zero or more; those of all sets of a vertex add up to one. A joint without weight is joint 0.
    pub weights: [f32; 4],
}

impl Influences {
    /// Makes the weights of each vertex, one in each of `sets`, add up to one, and has joints without weight be joint 0.
    /// Vertices without any usable weight follow joint 0; their number is given back.
    pub(super) fn normalize(sets: &mut [Vec<Self>], vertices: usize) -> usize {
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

    /// The highest joint that any vertex follows.
    pub(super) fn highest_joint(sets: &[Vec<Self>]) -> Option<u32> {
        sets.iter().flatten().flat_map(|influences| influences.joints).max().map(u32::from)
    }

    /// Adds this vertex's share of the transforms in `joints`, its skin's, to `sum`.
    pub(super) fn add_to(&self, sum: &mut Affine3A, joints: &[Affine3A]) {
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

/// A joint of a skin.
#[derive(Clone, Copy, Debug)]
pub(super) struct Joint {
    pub(super) node: u32,
    pub(super) joint_from_mesh: Affine3A,
}

/// The joints of all skins, one skin after the other.
#[derive(Debug, Default)]
pub(super) struct Skins {
    pub(super) joints: Vec<Joint>,
    /// First joint and number of joints of each skin.
    ranges: Vec<(u32, u32)>,
}

impl Skins {
    /// Reads all skins.
    ///
    /// # Errors
    /// Where a joint or a matrix is broken or missing.
    pub(super) fn read(document: &Document, nodes: &Nodes) -> Result<Self, Error> {
        let mut skins = Self::default();
        for (number, json) in document.json.skins.iter().enumerate() {
            let place = format!("skins[{number}]");
            let matrices = match json.inverse_bind_matrices {
                None => Vec::new(),
                Some(accessor) => {
                    let accessor = document.accessor(accessor, format_args!("{place}.inverseBindMatrices"))?;
                    let matrices: Vec<_> = accessor
                        .floats(None, |columns: [f32; 16]| Affine3A::from_mat4(Mat4::from_cols_array(&columns)))?;
                    if matrices.len() < json.joints.len() {
                        let cause = format!("{} matrices for {} joints", matrices.len(), json.joints.len());
                        return Err(accessor.malformed(cause));
                    }
                    if let Some(at) = matrices.iter().position(|matrix| !matrix.is_finite()) {
                        return Err(accessor.malformed(format!("matrix {at} is not finite")));
                    }
                    matrices
                }
            };
            skins.ranges.push((skins.joints.len() as u32, json.joints.len() as u32));
            for (at, node) in json.joints.iter().enumerate() {
                nodes.check(document, node.value(), format_args!("{place}.joints[{at}]"))?;
                let joint_from_mesh = matrices.get(at).copied().unwrap_or(Affine3A::IDENTITY);
                skins.joints.push(Joint { node: node.value() as u32, joint_from_mesh });
            }
        }
        Ok(skins)
    }

    /// The joints of the skin that starts at joint `first`.
    pub(super) fn of_first(&self, first: u32) -> &[Joint] {
        let range = self.ranges.iter().find(|&&(start, count)| start == first && count > 0);
        range.map_or(&[], |&(start, count)| &self.joints[start as usize..][..count as usize])
    }

    /// Where skin `index` has its first joint, and how many it has.
    ///
    /// # Errors
    /// Where there is no such skin.
    pub(super) fn range(&self, document: &Document, index: usize, place: &str) -> Result<(u32, u32), Error> {
        document.element(&self.ranges, "skins", index, format_args!("{place}.skin")).copied()
    }
}
