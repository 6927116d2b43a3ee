//! The part of a frame that stays the same from frame to frame: triangles, texture coordinates and colours of all parts.

use glam::{Vec2, Vec4};

use super::parts::Parts;
use crate::Mesh;

impl Parts {
    /// Copies each primitive's mesh for each of its parts, and frees the primitives' own. `default_material` is the index of
    /// the material for primitives without one.
    pub(super) fn take_mesh(&mut self, default_material: u32) -> Mesh {
        let (vertices, triangles) = (self.vertices, self.triangles);
        let mut all = Mesh {
            triangles: Vec::with_capacity(triangles),
            material_of_triangle: Vec::with_capacity(triangles),
            ..Mesh::default()
        };
        for part in &self.parts {
            let primitive = &self.primitives[part.shape as usize];
            let Mesh { triangles, tex_coords, colors, .. } = &primitive.mesh;
            all.triangles.extend(triangles.iter().map(|corners| corners.map(|vertex| part.first_vertex + vertex)));
            all.material_of_triangle.resize(all.triangles.len(), primitive.material.unwrap_or(default_material));
            let end = part.first_vertex as usize + primitive.shape.positions.len();
            for (all, own) in all.tex_coords.iter_mut().zip(tex_coords) {
                extend(all, own, Vec2::ZERO, end, vertices);
            }
            extend(&mut all.colors, colors, Vec4::ONE, end, vertices);
        }
        for primitive in &mut self.primitives {
            primitive.mesh = Mesh::default();
        }
        all
    }
}

/// Adds what a part's vertices, the last of those before `end`, have of their `own`, or else `missing`. Nothing is added
/// before the first part that has any.
fn extend<T: Copy>(values: &mut Vec<T>, own: &[T], missing: T, end: usize, vertices: usize) {
    if values.is_empty() && own.is_empty() {
        return;
    }
    values.reserve_exact(vertices - values.len());
    values.resize(end - own.len(), missing);
    values.extend_from_slice(own);
}
