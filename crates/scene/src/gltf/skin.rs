//! Skins: which nodes are joints, and where meshes are from them.

use glam::{Affine3A, Mat4};

use super::document::Document;
use crate::Error;

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
    pub(super) fn read(document: &Document) -> Result<Self, Error> {
        let mut skins = Self::default();
        for (number, json) in document.json.skins.iter().enumerate() {
            let location = format!("skins[{number}]");
            let matrices = match json.inverse_bind_matrices {
                None => Vec::new(),
                Some(accessor) => {
                    let accessor = document.accessor(accessor, format_args!("{location}.inverseBindMatrices"))?;
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
                let location = format_args!("{location}.joints[{at}]");
                document.element(&document.json.nodes, "nodes", node.value(), location)?;
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
    pub(super) fn range(&self, document: &Document, index: usize, location: &str) -> Result<(u32, u32), Error> {
        document.element(&self.ranges, "skins", index, format_args!("{location}.skin")).copied()
    }
}
