//! One primitive of a mesh: its triangles, points or lines and its vertices in the mesh's own space.

use std::fmt::Display;

use glam::{Vec2, Vec3, Vec4};
use gltf::json::Index;
use gltf::json::mesh::{self, Mode, Semantic};
use gltf::json::validation::Checked;
use umbrage_scene::rig::{Deltas, Influences, MorphTarget, Shape};
use umbrage_scene::{Error, Marks, Mesh};

use super::accessor::Accessor;
use super::document::Document;
use super::material::tangent_coords;

/// A primitive, with warnings about content that was left out or mended.
#[derive(Debug, Default)]
pub(super) struct Primitive {
    pub(super) shape: Shape,
    /// The data that is the same in every pose, but for materials.
    pub(super) mesh: Mesh,
    /// Index of the file's material; `None` for glTF's default.
    pub(super) material: Option<u32>,
    pub(super) warnings: Vec<String>,
}

impl Primitive {
    /// Reads a primitive of triangles, points or lines; `location` is its path in the JSON. It is empty where it has no positions.
    ///
    /// Vertices that none of these uses are left out: some writers have many primitives share one large vertex buffer.
    ///
    /// # Errors
    /// Where an attribute or an index is broken.
    pub(super) fn read(document: &Document, json: &mesh::Primitive, location: &str) -> Result<Self, Error> {
        let mut primitive = Self::default();
        let attributes = Attributes { document, json, location };
        let Some(positions) = attributes.accessor(Semantic::Positions)? else {
            primitive.warnings.push(format!("{location} was left out, as it has no positions"));
            return Ok(primitive);
        };
        let count = positions.count();
        let Pieces { mut points, mut lines, mut triangles, odd } = Pieces::read(document, json, count, location)?;
        if odd > 0 {
            let whole = if json.mode == Checked::Valid(Mode::Lines) { "line" } else { "triangle" };
            primitive.warnings.push(format!("{location}: {odd} vertices at the end make no whole {whole}"));
        }
        let used = [&mut points[..], lines.as_flattened_mut(), triangles.as_flattened_mut()];
        let kept = without_unused_vertices(used, count);
        let kept = kept.as_deref();
        let mut marks = Marks::default();
        if triangles.is_empty() {
            marks.add(points, lines, 0);
        }
        let tex_coords = |set| if marks.is_empty() { attributes.tex_coords(set, count, kept) } else { Ok(Vec::new()) };
        primitive.mesh = Mesh {
            triangles,
            tex_coords: [tex_coords(0)?, tex_coords(1)?],
            colors: attributes.colors(count, kept)?,
            marks,
            ..Mesh::default()
        };
        primitive.material = json.material.map(|material| material.value() as u32);
        let material = json.material.map(|material| {
            let location = format_args!("{location}.material");
            document.element(&document.json.materials, "materials", material.value(), location)
        });
        let tangent_coords = material.transpose()?.and_then(tangent_coords);
        primitive.shape.positions = positions.floats(kept, Vec3::from_array)?;
        let unusable = primitive.shape.positions.iter().filter(|position| !position.is_finite()).count();
        if unusable > 0 {
            primitive.warnings.push(format!("{location}: {unusable} vertices have a position that is not finite"));
        }
        attributes.read_shape(count, kept, &mut primitive)?;
        if let Some(set) = tangent_coords {
            // Approximate memory for finding them.
            document.take_for::<[Vec4; 12]>(primitive.mesh.triangles.len(), format_args!("{location}'s tangents"))?;
            primitive.add_tangents(set as usize);
        }
        Ok(primitive)
    }
}

/// A primitive's attributes in the JSON.
struct Attributes<'a> {
    document: &'a Document,
    json: &'a mesh::Primitive,
    location: &'a str,
}

impl<'a> Attributes<'a> {
    fn accessor(&self, semantic: Semantic) -> Result<Option<Accessor<'a>>, Error> {
        let location = format!("{}.attributes.{}", self.location, semantic.to_string());
        let Some(&index) = self.json.attributes.get(&Checked::Valid(semantic)) else { return Ok(None) };
        self.document.accessor(index, location).map(Some)
    }

    /// An attribute that has `count` elements.
    fn counted(&self, semantic: Semantic, count: usize) -> Result<Option<Accessor<'a>>, Error> {
        let location = format!("{}.attributes.{}", self.location, semantic.to_string());
        let accessor = self.accessor(semantic)?;
        accessor.iter().try_for_each(|accessor| accessor.expect_count(count, &location))?;
        Ok(accessor)
    }

    fn tex_coords(&self, set: u32, count: usize, kept: Option<&[u32]>) -> Result<Vec<Vec2>, Error> {
        match self.counted(Semantic::TexCoords(set), count)? {
            Some(accessor) => accessor.floats(kept, Vec2::from_array),
            None => Ok(Vec::new()),
        }
    }

    fn colors(&self, count: usize, kept: Option<&[u32]>) -> Result<Vec<Vec4>, Error> {
        let Some(accessor) = self.counted(Semantic::Colors(0), count)? else { return Ok(Vec::new()) };
        let colors = if accessor.components() == 3 {
            accessor.fractions(kept, |color| Vec3::from_array(color).extend(1.0))?
        } else {
            accessor.fractions(kept, Vec4::from_array)?
        };
        // Vertices without a colour are white.
        Ok(if colors.iter().all(|&color| color == Vec4::ONE) { Vec::new() } else { colors })
    }

    fn read_shape(&self, count: usize, kept: Option<&[u32]>, primitive: &mut Primitive) -> Result<(), Error> {
        let shape = &mut primitive.shape;
        if let Some(accessor) = self.counted(Semantic::Normals, count)? {
            shape.normals = accessor.floats(kept, |normal| Vec3::from_array(normal).normalize_or_zero())?;
            // The specification has tangents without normals ignored.
            if let Some(accessor) = self.counted(Semantic::Tangents, count)? {
                shape.tangents = accessor.floats(kept, |tangent| unit_tangent(Vec4::from_array(tangent)))?;
            }
        }
        let vertices = shape.positions.len();
        let mut set = 0;
        while let Some(joints) = self.counted(Semantic::Joints(set), count)? {
            let Some(weights) = self.counted(Semantic::Weights(set), count)? else {
                let cause = format!("there is JOINTS_{set} but no WEIGHTS_{set}");
                return Err(self.document.malformed(format_args!("{}.attributes", self.location), cause));
            };
            let joints = joints
                .whole_numbers(kept, |joints: [u32; 4]| joints.map(|joint| u16::try_from(joint).unwrap_or(u16::MAX)))?;
            let weights = weights.fractions(kept, |weights: [f32; 4]| weights)?;
            let influences = joints.into_iter().zip(weights);
            shape.influences.push(influences.map(|(joints, weights)| Influences { joints, weights }).collect());
            set += 1;
        }
        let stray = normalize(&mut shape.influences, vertices);
        if stray > 0 {
            let location = self.location;
            primitive.warnings.push(format!("{location}: {stray} vertices without usable weights follow joint 0"));
        }
        for (number, target) in self.json.targets.iter().flatten().enumerate() {
            let location = format!("{}.targets[{number}]", self.location);
            shape.morph_targets.push(self.morph_target(target, count, kept, &location)?);
        }
        Ok(())
    }

    /// A target of a primitive with `count` vertices, of which those with the rising indices `kept` are kept.
    fn morph_target(
        &self,
        json: &mesh::MorphTarget,
        count: usize,
        kept: Option<&[u32]>,
        location: &str,
    ) -> Result<MorphTarget, Error> {
        let deltas = |accessor: Option<Index<_>>, name: &str| {
            let Some(accessor) = accessor else { return Ok(Deltas::default()) };
            let location = format!("{location}.{name}");
            let accessor = self.document.accessor(accessor, &location)?;
            accessor.expect_count(count, &location)?;
            if !accessor.is_mostly_zero() {
                return Ok(Deltas::Dense(accessor.floats(kept, Vec3::from_array)?));
            }
            let (vertices, deltas) = accessor.sparse_floats(Vec3::from_array)?;
            let Some(kept) = kept else { return Ok(Deltas::Sparse { vertices, deltas }) };
            let renumber = |(vertex, delta)| Some((kept.binary_search(&vertex).ok()? as u32, delta));
            let (vertices, deltas) = vertices.into_iter().zip(deltas).filter_map(renumber).unzip();
            Ok(Deltas::Sparse { vertices, deltas })
        };
        Ok(MorphTarget {
            positions: deltas(json.positions, "POSITION")?,
            normals: deltas(json.normals, "NORMAL")?,
            tangents: deltas(json.tangents, "TANGENT")?,
        })
    }
}

fn unit_tangent(tangent: Vec4) -> Vec4 {
    match tangent.truncate().try_normalize() {
        Some(direction) => direction.extend(if tangent.w < 0.0 { -1.0 } else { 1.0 }),
        None => Vec4::ZERO,
    }
}

/// Number of triangles, points or lines of a primitive with `elements` indices or vertices.
pub(super) fn piece_count(mode: Mode, elements: u64) -> u64 {
    match mode {
        Mode::Triangles => elements / 3,
        Mode::TriangleStrip | Mode::TriangleFan => elements.saturating_sub(2),
        Mode::Points | Mode::LineLoop => elements,
        Mode::Lines => elements / 2,
        Mode::LineStrip => elements.saturating_sub(1),
    }
}

/// Elements of a primitive: all lists but one are empty.
#[derive(Debug, Default)]
struct Pieces {
    points: Vec<u32>,
    lines: Vec<[u32; 2]>,
    triangles: Vec<[u32; 3]>,
    /// Number of elements at the end that make no whole triangle or line.
    odd: usize,
}

impl Pieces {
    /// Reads the elements of a primitive with `vertices` vertices.
    fn read(document: &Document, json: &mesh::Primitive, vertices: usize, location: &str) -> Result<Self, Error> {
        let elements = elements(document, json, vertices, location)?;
        let two = |two: &[u32]| [two[0], two[1]];
        let strip = |(at, three): (usize, &[u32])| {
            // Every second triangle of a strip turns the other way; the specification swaps its last two vertices.
            if at % 2 == 0 { [three[0], three[1], three[2]] } else { [three[0], three[2], three[1]] }
        };
        let mut pieces = Self::default();
        match json.mode {
            Checked::Valid(Mode::Points) => pieces.points = elements,
            Checked::Valid(Mode::Lines) => {
                let (lines, odd) = elements.as_chunks();
                (pieces.lines, pieces.odd) = (lines.to_vec(), odd.len());
            }
            Checked::Valid(Mode::LineStrip) => pieces.lines = elements.windows(2).map(two).collect(),
            Checked::Valid(Mode::LineLoop) => {
                let closing = elements.last().zip(elements.first()).map(|(&last, &first)| [last, first]);
                pieces.lines = elements.windows(2).map(two).chain(closing).collect();
            }
            Checked::Valid(Mode::TriangleStrip) => {
                pieces.triangles = elements.windows(3).enumerate().map(strip).collect();
            }
            Checked::Valid(Mode::TriangleFan) => {
                let (&center, rim) = elements.split_first().unwrap_or((&0, &[]));
                pieces.triangles = rim.windows(2).map(|two| [two[0], two[1], center]).collect();
            }
            Checked::Valid(Mode::Triangles) | Checked::Invalid => {
                let (triangles, odd) = elements.as_chunks();
                (pieces.triangles, pieces.odd) = (triangles.to_vec(), odd.len());
            }
        }
        Ok(pieces)
    }
}

/// The elements of a primitive with `vertices` vertices: its indices, or else all vertices.
fn elements(document: &Document, json: &mesh::Primitive, vertices: usize, location: &str) -> Result<Vec<u32>, Error> {
    let Some(indices) = json.indices else { return Ok((0..count_u32(document, vertices, location)?).collect()) };
    let accessor = document.accessor(indices, format_args!("{location}.indices"))?;
    let indices: Vec<u32> = accessor.whole_numbers(None, |[index]| index)?;
    if let Some(at) = indices.iter().position(|&index| index as usize >= vertices) {
        let cause = format!("element {at} is vertex {}, but there are {vertices} vertices", indices[at]);
        return Err(document.malformed(format_args!("{location}.indices"), cause));
    }
    Ok(indices)
}

fn count_u32(document: &Document, count: usize, location: impl Display) -> Result<u32, Error> {
    u32::try_from(count).map_err(|_| document.malformed(location, format!("{count} vertices are too many")))
}

/// Renumbers the indices in `used`, so that only used vertices remain, and returns these, ascending; `None` if all are
/// used.
fn without_unused_vertices(mut used: [&mut [u32]; 3], vertices: usize) -> Option<Vec<u32>> {
    let mut are_used = vec![false; vertices];
    for &mut vertex in used.iter_mut().flat_map(|used| used.iter_mut()) {
        are_used[vertex as usize] = true;
    }
    if are_used.iter().all(|&used| used) {
        return None;
    }
    let kept = are_used.iter().enumerate().filter(|&(_, &used)| used).map(|(vertex, _)| vertex as u32);
    let kept: Vec<u32> = kept.collect();
    let mut new_from_old = vec![0; vertices];
    for (new, &old) in kept.iter().enumerate() {
        new_from_old[old as usize] = new as u32;
    }
    for vertex in used.iter_mut().flat_map(|used| used.iter_mut()) {
        *vertex = new_from_old[*vertex as usize];
    }
    Some(kept)
}

/// Normalizes each vertex's weights over all `sets` to a sum of one, and sets joints without weight to joint 0. Vertices
/// without any usable weight follow joint 0; returns their number.
fn normalize(sets: &mut [Vec<Influences>], vertices: usize) -> usize {
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
            let Influences { joints, weights } = &mut set[vertex];
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
