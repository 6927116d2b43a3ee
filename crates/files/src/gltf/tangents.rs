//! Tangents for normal maps of files without tangents, by `MikkTSpace`, as the specification (§3.7.2.1) requires.

use std::collections::HashMap;

use bevy_mikktspace::{Geometry, Ops, TangentSpace, generate_tangents};
use glam::{Vec2, Vec4};
use umbrage_scene::rig::{Deltas, Shape};

use super::primitive::Primitive;

impl Primitive {
    /// Adds tangents along texture coordinates `set` to vertices without any. A vertex whose triangles disagree, as where a
    /// texture is mirrored, is split; the new vertices are at the end.
    ///
    /// Does nothing without normals or such texture coordinates, or where positions or coordinates aren't finite.
    pub(super) fn add_tangents(&mut self, set: usize) {
        let Self { shape, mesh, .. } = self;
        let Some(coords) = mesh.tex_coords.get(set).filter(|coords| !coords.is_empty()) else { return };
        let is_finite = shape.positions.iter().all(|position| position.is_finite())
            && coords.iter().all(|coords| coords.is_finite());
        if !shape.tangents.is_empty() || shape.normals.is_empty() || !is_finite {
            return;
        }
        let tangents = vec![[Vec4::ZERO; 3]; mesh.triangles.len()];
        let mut corners = Corners { shape, coords, triangles: &mesh.triangles, tangents };
        // `generate_tangents` has no error cases yet.
        if generate_tangents(&mut corners).is_err() {
            return;
        }
        let mut of_vertices = vec![None; shape.positions.len()];
        let mut copies = Vec::new();
        let mut found = HashMap::new();
        let of_corners = corners.tangents;
        let vertices_of_corners = mesh.triangles.as_flattened_mut().iter_mut();
        for (vertex, &tangent) in vertices_of_corners.zip(of_corners.as_flattened()) {
            let first = *of_vertices[*vertex as usize].get_or_insert(tangent);
            if first != tangent {
                let new = (of_vertices.len() + copies.len()) as u32;
                let bits = tangent.to_array().map(f32::to_bits);
                *vertex = *found.entry((*vertex, bits)).or_insert_with(|| {
                    copies.push((*vertex, tangent));
                    new
                });
            }
        }
        shape.tangents = of_vertices.into_iter().map(Option::unwrap_or_default).collect();
        shape.tangents.extend(copies.iter().map(|&(_, tangent)| tangent));
        let copies: Vec<u32> = copies.into_iter().map(|(vertex, _)| vertex).collect();
        self.repeat(&copies);
    }

    /// Appends copies of vertices, with all attributes but tangents.
    fn repeat(&mut self, vertices: &[u32]) {
        let Self { shape, mesh, .. } = self;
        let first = shape.positions.len() as u32;
        repeat(&mut shape.positions, vertices);
        repeat(&mut shape.normals, vertices);
        shape.influences.iter_mut().for_each(|set| repeat(set, vertices));
        mesh.tex_coords.iter_mut().for_each(|coords| repeat(coords, vertices));
        repeat(&mut mesh.colors, vertices);
        for target in &mut shape.morph_targets {
            for deltas in [&mut target.positions, &mut target.normals, &mut target.tangents] {
                repeat_deltas(deltas, first, vertices);
            }
        }
    }
}

/// Appends copies to an attribute, unless it is absent.
fn repeat<T: Copy>(values: &mut Vec<T>, vertices: &[u32]) {
    if !values.is_empty() {
        let copies: Vec<T> = vertices.iter().map(|&vertex| values[vertex as usize]).collect();
        values.extend(copies);
    }
}

/// As [`repeat`]; the first copy is vertex `first`.
fn repeat_deltas(deltas: &mut Deltas, first: u32, vertices: &[u32]) {
    match deltas {
        Deltas::Dense(deltas) => repeat(deltas, vertices),
        Deltas::Sparse { vertices: moved, deltas } => {
            let old = moved.len();
            for (copy, vertex) in (first..).zip(vertices) {
                if let Ok(at) = moved[..old].binary_search(vertex) {
                    moved.push(copy);
                    deltas.push(deltas[at]);
                }
            }
        }
    }
}

/// Triangles, and a tangent for each of their corners.
struct Corners<'a> {
    shape: &'a Shape,
    coords: &'a [Vec2],
    triangles: &'a [[u32; 3]],
    tangents: Vec<[Vec4; 3]>,
}

impl Corners<'_> {
    fn vertex(&self, triangle: usize, corner: usize) -> usize {
        self.triangles[triangle][corner] as usize
    }
}

/// Math functions with the same results on every machine.
struct Portable;

impl Ops for Portable {
    fn sqrt(x: f32) -> f32 {
        x.sqrt()
    }

    /// In f64, as in the reference program of `MikkTSpace`.
    fn acos(x: f32) -> f32 {
        libm::acos(f64::from(x)) as f32
    }
}

impl Geometry<Portable> for Corners<'_> {
    fn num_faces(&self) -> usize {
        self.triangles.len()
    }

    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }

    fn position(&self, face: usize, vert: usize) -> [f32; 3] {
        self.shape.positions[self.vertex(face, vert)].to_array()
    }

    fn normal(&self, face: usize, vert: usize) -> [f32; 3] {
        self.shape.normals[self.vertex(face, vert)].to_array()
    }

    fn tex_coord(&self, face: usize, vert: usize) -> [f32; 2] {
        self.coords[self.vertex(face, vert)].to_array()
    }

    fn set_tangent(&mut self, tangent_space: Option<TangentSpace>, face: usize, vert: usize) {
        let Some(space) = tangent_space else { return };
        let tangent = Vec4::from_array(space.tangent_encoded());
        // MikkTSpace's v grows upwards, glTF's downwards: that turns the bitangent.
        let is_unit = (tangent.truncate().length_squared() - 1.0).abs() < 1e-3;
        self.tangents[face][vert] = if is_unit { tangent.with_w(-tangent.w) } else { Vec4::ZERO };
    }
}
