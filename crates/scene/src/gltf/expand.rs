//! The part of a frame that stays the same from frame to frame: triangles, texture coordinates and colours of all parts.

use glam::{Vec2, Vec4};
use rayon::prelude::*;

use super::parts::Parts;
use super::primitive::{Primitive, Surface};
use crate::Mesh;
use crate::rig::{GRAIN, overlap, overlapping};

impl Parts {
    /// Copies each primitive's surface for each of its parts, in parallel, and frees the primitives' own.
    /// `default_material` is the index of the material for primitives without one.
    pub(super) fn take_mesh(&mut self, default_material: u32) -> Mesh {
        let (vertices, triangles) = (self.vertices, self.triangles);
        let mut mesh = Mesh {
            triangles: vec![[0; 3]; triangles],
            material_of_triangle: vec![0; triangles],
            tex_coords: [0, 1].map(|set| {
                let any = self.primitives.iter().any(|primitive| !primitive.surface.tex_coords[set].is_empty());
                vec![Vec2::ZERO; if any { vertices } else { 0 }]
            }),
            colors: {
                let any = self.primitives.iter().any(|primitive| !primitive.surface.colors.is_empty());
                vec![Vec4::ONE; if any { vertices } else { 0 }]
            },
        };
        self.copy_triangles(default_material, &mut mesh);
        for (set, tex_coords) in mesh.tex_coords.iter_mut().enumerate() {
            self.copy_attribute(&|primitive| &primitive.surface.tex_coords[set], tex_coords);
        }
        self.copy_attribute(&|primitive| &primitive.surface.colors, &mut mesh.colors);
        for primitive in &mut self.primitives {
            primitive.surface = Surface::default();
        }
        mesh
    }

    fn copy_triangles(&self, default_material: u32, mesh: &mut Mesh) {
        let chunks = mesh.triangles.par_chunks_mut(GRAIN).zip(mesh.material_of_triangle.par_chunks_mut(GRAIN));
        chunks.enumerate().for_each(|(chunk, (triangles, materials))| {
            let range = chunk * GRAIN..chunk * GRAIN + triangles.len();
            for part in overlapping(&self.parts, &range, |part| part.first_triangle) {
                let surface = &self.primitive(part).surface;
                let (target, source) = overlap(&range, part.first_triangle as usize, surface.triangles.len());
                materials[target.clone()].fill(surface.material.unwrap_or(default_material));
                for (target, source) in triangles[target].iter_mut().zip(&surface.triangles[source]) {
                    *target = source.map(|vertex| part.first_vertex + vertex);
                }
            }
        });
    }

    /// Fills the frame's `values` of an attribute from those of its primitives. Vertices whose primitive doesn't have it,
    /// and empty `values`, stay as they are.
    fn copy_attribute<'a, T: Copy + Send + Sync + 'a>(
        &'a self,
        attribute: &(impl Fn(&'a Primitive) -> &'a [T] + Sync),
        values: &mut [T],
    ) {
        values.par_chunks_mut(GRAIN).enumerate().for_each(|(chunk, values)| {
            let range = chunk * GRAIN..chunk * GRAIN + values.len();
            for part in overlapping(&self.parts, &range, |part| part.first_vertex) {
                let primitive = self.primitive(part);
                let source = attribute(primitive);
                if !source.is_empty() {
                    let (target, from) = overlap(&range, part.first_vertex as usize, primitive.shape.positions.len());
                    values[target].copy_from_slice(&source[from]);
                }
            }
        });
    }
}
