//! The part of a frame that stays the same from frame to frame: triangles, texture coordinates and colours of all parts.

use glam::{Vec2, Vec3, Vec4};
use umbrage_scene::Mesh;
use umbrage_scene::rig::{Placement, RigPart};

use super::bodies::Bodies;
use super::parts::RigParts;
use super::rest::Rest;

impl RigParts {
    /// Copies each primitive's mesh for each of its parts, and frees the primitives' own. `default_material` is the index of
    /// the material for primitives without one. The fronts of parts that are mirrored at rest are turned back.
    pub(super) fn take_mesh(&mut self, default_material: u32, rest: &Rest, object_of_part: &[u32]) -> Mesh {
        let (vertices, triangles) = (self.vertices, self.triangles);
        let mut all = Mesh {
            triangles: Vec::with_capacity(triangles),
            material_of_triangle: Vec::with_capacity(triangles),
            part_of_triangle: Vec::with_capacity(triangles),
            ..Mesh::default()
        };
        let mut bodies = Bodies::new(&self.matrices, rest);
        for (part, &object) in self.parts.iter().zip(object_of_part) {
            let primitive = &self.primitives[part.shape as usize];
            let Mesh { triangles, tex_coords, colors, marks, .. } = &primitive.mesh;
            let material = primitive.material.unwrap_or(default_material);
            if !marks.is_empty() {
                all.marks.begin(material, Some(object));
                marks.points().iter().for_each(|&vertex| all.marks.push_point(part.first_vertex + vertex));
                let lines = marks.lines().iter().map(|line| line.map(|vertex| part.first_vertex + vertex));
                lines.for_each(|line| all.marks.push_line(line));
            }
            let is_mirrored = self.is_mirrored(part, rest);
            all.triangles.extend(triangles.iter().map(|corners| {
                let [a, b, c] = corners.map(|vertex| part.first_vertex + vertex);
                if is_mirrored { [a, c, b] } else { [a, b, c] }
            }));
            all.material_of_triangle.resize(all.triangles.len(), material);
            bodies.add(part, &primitive.shape, triangles, &mut all);
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

    /// Whether a part's transform mirrors it at rest: its fronts then have clockwise corners (glTF 2.0, Instantiation).
    /// For a skin, the first joint decides.
    fn is_mirrored(&self, part: &RigPart, rest: &Rest) -> bool {
        let (Placement::Rigid { matrix: index } | Placement::Skinned { first_matrix: index }) = part.placement;
        let sources = if part.moves { &self.matrices.moving } else { &self.matrices.still };
        let Some(source) = sources.get(index as usize) else { return false };
        let [x, y, z] =
            source.at(&rest.world_from_node).matrix3.to_cols_array_2d().map(|axis| Vec3::from(axis).as_dvec3());
        x.dot(y.cross(z)) < 0.0
    }
}

/// Extends `values` to `end` vertices: a part's `own` values come last, `missing` stands for vertices without any.
/// Nothing is added before the first part that has any.
fn extend<T: Copy>(values: &mut Vec<T>, own: &[T], missing: T, end: usize, vertices: usize) {
    if values.is_empty() && own.is_empty() {
        return;
    }
    values.reserve_exact(vertices - values.len());
    values.resize(end - own.len(), missing);
    values.extend_from_slice(own);
}
