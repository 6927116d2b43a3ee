//! The part of a frame that stays the same from frame to frame: triangles, texture coordinates and colours of all parts, and
//! groups of triangles that move together, below the same animated node or mostly following the same joint.

use std::collections::HashMap;

use glam::{Vec2, Vec3, Vec4};
use umbrage_scene::Mesh;
use umbrage_scene::rig::{Influences, Placement, RigPart, Shape};

use super::matrices::Matrices;
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

/// A group of triangles with a motion of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Object {
    /// Triangles that don't move.
    Still,
    /// Triangles whose nearest animated node is this one.
    Node(u32),
    /// The morphing part with this first vertex.
    Morphed(u32),
    /// Triangles of the skin with this first matrix.
    Skin(u32),
}

/// Numbers objects and parts of a mesh in order of appearance.
struct Bodies<'a> {
    matrices: &'a Matrices,
    /// By moving node, the nearest animated node at or above it.
    animated: HashMap<u32, u32>,
    objects: HashMap<Object, u32>,
    /// By object and joint of its skin.
    parts: HashMap<(Object, u16), u32>,
}

impl<'a> Bodies<'a> {
    fn new(matrices: &'a Matrices, rest: &Rest) -> Self {
        let mut animated = HashMap::new();
        for moving in &rest.moving {
            let above = moving.parent.filter(|_| moving.slot.is_none()).and_then(|parent| animated.get(&parent));
            let own = above.copied().unwrap_or(moving.node);
            animated.insert(moving.node, own);
        }
        Self { matrices, animated, objects: HashMap::new(), parts: HashMap::new() }
    }

    /// Appends the object and part of each triangle of `part`, whose triangles are the mesh's last.
    fn add(&mut self, part: &RigPart, shape: &Shape, triangles: &[[u32; 3]], mesh: &mut Mesh) {
        let object = match part.placement {
            _ if !shape.morph_targets.is_empty() => Object::Morphed(part.first_vertex),
            _ if !part.moves => Object::Still,
            Placement::Skinned { first_matrix } => Object::Skin(first_matrix),
            Placement::Rigid { matrix } => {
                let node = self.matrices.moving[matrix as usize].node;
                Object::Node(self.animated.get(&node).copied().unwrap_or(node))
            }
        };
        let is_skinned = matches!(object, Object::Skin(_));
        mesh.part_of_triangle.extend(triangles.iter().map(|&corners| {
            let joint = if is_skinned { main_joint(&shape.influences, corners) } else { 0 };
            *self.parts.entry((object, joint)).or_insert_with(|| {
                let next = self.objects.len() as u32;
                mesh.object_of_part.push(*self.objects.entry(object).or_insert(next));
                mesh.object_of_part.len() as u32 - 1
            })
        }));
    }
}

/// The joint with the largest weight over a triangle's corners; the lowest of several.
fn main_joint(sets: &[Vec<Influences>], corners: [u32; 3]) -> u16 {
    let of_corners = || sets.iter().flat_map(|set| corners.map(|corner| set[corner as usize]));
    let weight = |joint: u16| -> f32 {
        let all = of_corners().flat_map(|all| all.joints.into_iter().zip(all.weights));
        all.filter(|&(other, _)| other == joint).map(|(_, weight)| weight).sum()
    };
    let joints = of_corners().flat_map(|all| all.joints);
    joints.max_by(|&a, &b| weight(a).total_cmp(&weight(b)).then(b.cmp(&a))).unwrap_or(0)
}
