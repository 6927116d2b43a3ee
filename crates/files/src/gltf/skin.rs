//! Skins: their joints' nodes and inverse bind matrices.

use glam::{Affine3A, Mat4};
use umbrage_scene::Error;

use super::document::Document;
use super::matrices::MatrixSource;

/// Reads the joints of all skins.
///
/// # Errors
/// Where a joint or a matrix is broken or missing.
pub(super) fn read(document: &Document) -> Result<Vec<Vec<MatrixSource>>, Error> {
    let mut skins = Vec::new();
    for (number, json) in document.json.skins.iter().enumerate() {
        let location = format!("skins[{number}]");
        let matrices = match json.inverse_bind_matrices {
            None => Vec::new(),
            Some(accessor) => {
                let accessor = document.accessor(accessor, format_args!("{location}.inverseBindMatrices"))?;
                let matrices: Vec<_> =
                    accessor.floats(None, |columns: [f32; 16]| Affine3A::from_mat4(Mat4::from_cols_array(&columns)))?;
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
        let mut joints = Vec::new();
        for (at, node) in json.joints.iter().enumerate() {
            let location = format_args!("{location}.joints[{at}]");
            document.element(&document.json.nodes, "nodes", node.value(), location)?;
            let joint_from_mesh = matrices.get(at).copied().unwrap_or(Affine3A::IDENTITY);
            joints.push(MatrixSource { node: node.value() as u32, node_from_mesh: Some(joint_from_mesh) });
        }
        skins.push(joints);
    }
    Ok(skins)
}
