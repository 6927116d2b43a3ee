use bytemuck::{Pod, Zeroable};
use glam::{Vec3, Vec4};

/// A shape: vertices in a mesh's own space.
#[derive(Clone, Debug, Default)]
pub struct RigShape<'a> {
    /// Positions of vertices in the rest pose.
    pub positions: &'a [Vec3],
    /// Of unit length or zero; empty, or one for each position.
    pub normals: &'a [Vec3],
    /// Unit tangents and the sign of the bitangent, or zero; empty, or one for each position.
    pub tangents: &'a [Vec4],
    /// Sets of four influences for each position.
    pub influences: Vec<Vec<Influences>>,
    /// Morph targets, scaled by weights.
    pub targets: Vec<RigTarget<'a>>,
}

/// Deltas of a morph target at weight one.
#[derive(Clone, Copy, Debug, Default)]
pub struct RigTarget<'a> {
    /// Of positions.
    pub positions: Deltas<'a>,
    /// Of normals.
    pub normals: Deltas<'a>,
    /// Of tangents' directions.
    pub tangents: Deltas<'a>,
}

/// Deltas for all vertices or for some.
#[derive(Clone, Copy, Debug)]
pub enum Deltas<'a> {
    /// One for each vertex.
    Dense(&'a [Vec3]),
    /// One for each vertex in the first list, which is ascending; zero for the others.
    Sparse(&'a [u32], &'a [Vec3]),
}

impl Default for Deltas<'_> {
    fn default() -> Self {
        Self::Sparse(&[], &[])
    }
}

/// Four joints that a vertex follows, and their weights.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct Influences {
    /// Indices among the matrices of the part's skin.
    pub joints: [u16; 4],
    /// A joint without weight is joint 0.
    pub weights: [f32; 4],
}

/// A copy of a shape.
#[derive(Clone, Copy, Debug)]
pub struct RigPart {
    /// Index among the shapes.
    pub shape: u32,
    /// Index of its first vertex among those of all parts.
    pub first_vertex: u32,
    /// Index of the weight of its first morph target.
    pub first_weight: u32,
    /// Index of its matrix, or of joint 0's if `is_skinned`.
    pub matrix: u32,
    /// Whether its vertices follow their influences.
    pub is_skinned: bool,
    /// Whether it may change in the next pose.
    pub moves: bool,
}

/// A part, as in `pose.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct PosePart {
    /// Index of its first vertex among those to be posed.
    pub first_posed: u32,
    /// As [`RigPart::first_vertex`].
    pub first_vertex: u32,
    /// As [`RigPart::shape`].
    pub shape: u32,
    /// As [`RigPart::first_weight`].
    pub first_weight: u32,
    /// As [`RigPart::matrix`].
    pub matrix: u32,
    /// As [`RigPart::is_skinned`].
    pub is_skinned: u32,
}

/// First words of a shape's tables, as in `pose.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct PoseShape {
    /// Word of the first position.
    pub position_word: u32,
    /// Word of the first normal, or [`PoseShape::NO_ATTRIBUTE`].
    pub normal_word: u32,
    /// Word of the first tangent, or [`PoseShape::NO_ATTRIBUTE`].
    pub tangent_word: u32,
    /// Word of the first influences of the first set.
    pub influence_word: u32,
    /// Words of a set.
    pub influence_words: u32,
    /// Number of sets.
    pub influence_sets: u32,
    /// Word of the first target.
    pub target_word: u32,
    /// Number of morph targets.
    pub targets: u32,
}

impl PoseShape {
    /// Stands for an attribute that a shape or scene doesn't have.
    pub const NO_ATTRIBUTE: u32 = u32::MAX;
    /// The number of deltas if every vertex has one.
    pub const DENSE_DELTAS: u32 = u32::MAX;
    /// Words of a target's record of deltas.
    pub const TARGET_WORDS: u32 = 6;
    /// Words of an [`Influences`].
    pub const INFLUENCE_WORDS: u32 = (size_of::<Influences>() / 4) as u32;
}

/// A rig in the form that `pose.wgsl` reads, made once for a scene.
///
/// Bytes: for a shape's vertex 12, with a normal 12 more, with a tangent 16, for each set of influences 24, for each
/// morph target and attribute 12 (sparse: 16 for each vertex with a delta); 24 for a part.
#[derive(Clone, Debug, Default)]
pub struct RigTables {
    pub(super) parts: Vec<PosePart>,
    pub(super) shapes: Vec<PoseShape>,
    pub(super) vertices: Vec<u32>,
    pub(super) deltas: Vec<u32>,
    /// Vertices of all parts.
    pub(super) posed: u32,
    /// Vertices of parts that move, which come first.
    pub(super) moving_posed: u32,
    /// One past the last vertex.
    pub(super) end: u32,
}

impl RigTables {
    /// The tables of parts, which are copies of shapes.
    ///
    /// # Panics
    /// If a part's shape doesn't exist.
    #[must_use]
    pub fn new<'a>(shapes: impl IntoIterator<Item = RigShape<'a>>, parts: &[RigPart]) -> Self {
        let mut tables = Self::default();
        let mut counts = Vec::new();
        for shape in shapes {
            counts.push(shape.positions.len() as u32);
            tables.add_shape(&shape);
        }
        for moves in [true, false] {
            for part in parts.iter().filter(|part| part.moves == moves) {
                tables.parts.push(PosePart {
                    first_posed: tables.posed,
                    first_vertex: part.first_vertex,
                    shape: part.shape,
                    first_weight: part.first_weight,
                    matrix: part.matrix,
                    is_skinned: u32::from(part.is_skinned),
                });
                let count = counts[part.shape as usize];
                tables.posed += count;
                tables.end = tables.end.max(part.first_vertex + count);
            }
            if moves {
                tables.moving_posed = tables.posed;
            }
        }
        tables
    }

    fn add_shape(&mut self, shape: &RigShape<'_>) {
        let records = self.deltas.len();
        self.deltas.resize(records + shape.targets.len() * PoseShape::TARGET_WORDS as usize, 0);
        for (index, target) in shape.targets.iter().enumerate() {
            for (attribute, deltas) in [target.positions, target.normals, target.tangents].into_iter().enumerate() {
                let record = records + index * PoseShape::TARGET_WORDS as usize + 2 * attribute;
                let (first, count) = self.add_deltas(deltas);
                self.deltas[record..][..2].copy_from_slice(&[first, count]);
            }
        }
        let position_word = self.add_vertices(shape.positions).unwrap_or(0);
        let normal_word = self.add_vertices(shape.normals);
        let tangent_word = self.add_vertices(shape.tangents);
        let influence_word = self.vertices.len() as u32;
        for set in &shape.influences {
            self.add_vertices(set);
        }
        self.shapes.push(PoseShape {
            position_word,
            normal_word: normal_word.unwrap_or(PoseShape::NO_ATTRIBUTE),
            tangent_word: tangent_word.unwrap_or(PoseShape::NO_ATTRIBUTE),
            influence_word,
            influence_words: shape.positions.len() as u32 * PoseShape::INFLUENCE_WORDS,
            influence_sets: shape.influences.len() as u32,
            target_word: records as u32,
            targets: shape.targets.len() as u32,
        });
    }

    /// Appends elements and returns their first word; `None` if there are none.
    fn add_vertices<T: Pod>(&mut self, elements: &[T]) -> Option<u32> {
        let word = self.vertices.len() as u32;
        self.vertices.extend(words(elements));
        (!elements.is_empty()).then_some(word)
    }

    /// Appends deltas and returns their first word and their number.
    fn add_deltas(&mut self, deltas: Deltas<'_>) -> (u32, u32) {
        let word = self.deltas.len() as u32;
        match deltas {
            Deltas::Dense(deltas) => {
                self.deltas.extend(words(deltas));
                (word, PoseShape::DENSE_DELTAS)
            }
            Deltas::Sparse(vertices, deltas) => {
                self.deltas.extend_from_slice(vertices);
                self.deltas.extend(words(deltas));
                (word, vertices.len() as u32)
            }
        }
    }
}

/// Elements whose size is a multiple of four bytes, word by word.
fn words<T: Pod>(elements: &[T]) -> impl Iterator<Item = u32> {
    let bytes: &[u8] = bytemuck::cast_slice(elements);
    bytes.as_chunks().0.iter().map(|&word| u32::from_ne_bytes(word))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::{differences, layout, module, other_constants};
    use crate::link::link;
    use crate::pose::pose::PoseSize;

    #[test]
    fn structs_are_those_of_the_shader() {
        let shader = module(&link("pose::pose"));
        let layouts = [
            layout!(PoseSize { vertices, parts, matrix_word, normal_word, tangent_word }),
            layout!(PosePart { first_posed, first_vertex, shape, first_weight, matrix, is_skinned }),
            layout!(PoseShape {
                position_word,
                normal_word,
                tangent_word,
                influence_word,
                influence_words,
                influence_sets,
                target_word,
                targets,
            }),
        ];
        for of_rust in layouts {
            assert_eq!(differences(&shader, &of_rust), [""; 0]);
        }
    }

    #[test]
    fn constants_are_those_of_the_shader() {
        let shader = module(&link("pose::pose"));
        let constants = [
            ("NO_ATTRIBUTE", PoseShape::NO_ATTRIBUTE),
            ("DENSE_DELTAS", PoseShape::DENSE_DELTAS),
            ("TARGET_WORDS", PoseShape::TARGET_WORDS),
            ("INFLUENCE_WORDS", (size_of::<Influences>() / 4) as u32),
            ("MATRIX_WORDS", glam::Affine3A::IDENTITY.to_cols_array().len() as u32),
        ];
        assert_eq!(other_constants(&shader, &constants), [""; 0]);
    }
}
