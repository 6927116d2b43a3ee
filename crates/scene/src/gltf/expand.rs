//! The part of a frame that stays the same from frame to frame: triangles, texture coordinates and colours of all parts.

use std::ops::Range;

use glam::{Vec2, Vec4};

use super::parts::Parts;
use super::primitive::{Primitive, Surface};
use crate::Mesh;

/// Elements below which a piece of work is not worth sharing between threads.
pub(super) const GRAIN: usize = 4096;

impl Parts {
    /// Copies each primitive's surface for each of its parts, in parallel, and frees the primitives' own.
    /// `default_material` is the place of the material for primitives without one.
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
        self.copy_triangles(default_material, 0..triangles, &mut mesh.triangles, &mut mesh.material_of_triangle);
        for (set, tex_coords) in mesh.tex_coords.iter_mut().enumerate() {
            self.copy_attribute(&|primitive| &primitive.surface.tex_coords[set], 0..vertices, tex_coords);
        }
        self.copy_attribute(&|primitive| &primitive.surface.colors, 0..vertices, &mut mesh.colors);
        for primitive in &mut self.primitives {
            primitive.surface = Surface::default();
        }
        mesh
    }

    /// Fills the frame's triangles `range`, of which `triangles` and `materials` are that part.
    fn copy_triangles(
        &self,
        default_material: u32,
        range: Range<usize>,
        triangles: &mut [[u32; 3]],
        materials: &mut [u32],
    ) {
        if range.len() > GRAIN {
            let middle = range.start + range.len() / 2;
            let (left, right) = triangles.split_at_mut(middle - range.start);
            let (left_materials, right_materials) = materials.split_at_mut(middle - range.start);
            rayon::join(
                || self.copy_triangles(default_material, range.start..middle, left, left_materials),
                || self.copy_triangles(default_material, middle..range.end, right, right_materials),
            );
            return;
        }
        for part in self.with_triangles_in(range.clone()) {
            let surface = &self.primitive(part).surface;
            let (target, source) = overlap(&range, part.first_triangle as usize, surface.triangles.len());
            materials[target.clone()].fill(surface.material.unwrap_or(default_material));
            for (target, source) in triangles[target].iter_mut().zip(&surface.triangles[source]) {
                *target = source.map(|vertex| part.first_vertex + vertex);
            }
        }
    }

    /// Fills the frame's vertices `range`, of which `values` is that part, from an attribute of their primitives.
    /// Vertices whose primitive doesn't have it, and empty `values`, stay as they are.
    fn copy_attribute<'a, T: Copy + Send + 'a>(
        &'a self,
        attribute: &(impl Fn(&'a Primitive) -> &'a [T] + Sync),
        range: Range<usize>,
        values: &mut [T],
    ) {
        if values.is_empty() {
            return;
        }
        if range.len() > GRAIN {
            let middle = range.start + range.len() / 2;
            let (left, right) = values.split_at_mut(middle - range.start);
            rayon::join(
                || self.copy_attribute(attribute, range.start..middle, left),
                || self.copy_attribute(attribute, middle..range.end, right),
            );
            return;
        }
        for part in self.with_vertices_in(range.clone()) {
            let primitive = self.primitive(part);
            let source = attribute(primitive);
            if !source.is_empty() {
                let (target, from) = overlap(&range, part.first_vertex as usize, primitive.shape.positions.len());
                values[target].copy_from_slice(&source[from]);
            }
        }
    }
}

/// What `range` of the frame's elements has in common with a part's `count` ones from `first` on: as places in the
/// range, and as places in the part.
pub(super) fn overlap(range: &Range<usize>, first: usize, count: usize) -> (Range<usize>, Range<usize>) {
    let start = range.start.max(first);
    let end = range.end.min(first + count).max(start);
    (start - range.start..end - range.start, start - first..end - first)
}
