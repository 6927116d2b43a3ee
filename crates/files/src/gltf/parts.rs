//! The parts of a scene: each copy of a primitive is a part with triangles and vertices of its own.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use glam::{DVec3, Vec2, Vec3, Vec4};
use gltf::json;
use gltf::json::animation::Property;
use gltf::json::validation::Checked;
use rayon::prelude::*;
use umbrage_scene::rig::{Influences, Placement, Pose, Rig, RigPart};
use umbrage_scene::{Error, Objects};

use super::animation::Animations;
use super::document::Document;
use super::instances::Instances;
use super::matrices::{Matrices, MatrixRange, MatrixSource};
use super::nodes::Nodes;
use super::pose::Scratch;
use super::primitive::{Primitive, piece_count};
use super::rest::Rest;
use crate::origin::FarBounds;

/// Maximum number of triangles, points and lines of a scene with all copies of its meshes. Their vertices also fit into a
/// `u32`, since primitives keep used vertices only.
const MAX_TRIANGLES: u64 = 1 << 28;

/// The parts of a scene and their sources.
#[derive(Debug, Default)]
pub(super) struct RigParts {
    /// The primitives that parts are copies of: the rig's shapes, with their meshes and materials.
    pub(super) primitives: Vec<Primitive>,
    /// In the order of their vertices and triangles, which have no gaps. Until [`RigParts::into_rig`], indices of their
    /// matrices count moving and still ones apart.
    pub(super) parts: Vec<RigPart>,
    pub(super) matrices: Matrices,
    /// The node of each of `parts`, and its number of triangles.
    of_nodes: Vec<(u32, usize)>,
    pub(super) vertices: usize,
    pub(super) triangles: usize,
    /// Number of points and lines, and the node of each part with any.
    pub(super) marks: usize,
    node_of_marks: Vec<u32>,
}

/// A visible node's mesh, before it is read.
struct ShownMesh<'a> {
    node: usize,
    mesh: usize,
    json: &'a json::Mesh,
    instances: Option<Instances<'a>>,
    first_weight: u32,
}

impl RigParts {
    /// Reads the meshes of all visible nodes. `first_weights` has each node's first morph weight.
    ///
    /// # Errors
    /// Where anything in them is broken, or the copies would have absurdly many triangles.
    pub(super) fn read(
        document: &Document,
        nodes: &Nodes,
        skins: &[Vec<MatrixSource>],
        rest: &Rest,
        first_weights: &[u32],
        warnings: &mut Vec<String>,
    ) -> Result<Self, Error> {
        let shown = shown(document, nodes, first_weights)?;
        check_triangles(document, &shown)?;
        let mut parts = Self { matrices: Matrices::new(rest), ..Self::default() };
        let primitives_of_mesh = parts.read_primitives(document, &shown, warnings)?;
        for shown in shown {
            let mut rigid = None;
            for &primitive in &primitives_of_mesh[&shown.mesh] {
                parts.add(document, skins, &shown, &mut rigid, primitive, warnings)?;
            }
        }
        Ok(parts)
    }

    /// Reads each shown mesh's primitives once, in parallel, and returns each mesh's usable ones.
    fn read_primitives(
        &mut self,
        document: &Document,
        shown: &[ShownMesh<'_>],
        warnings: &mut Vec<String>,
    ) -> Result<HashMap<usize, Vec<u32>>, Error> {
        let mut primitives_of_mesh = HashMap::new();
        let mut to_read = Vec::new();
        for shown in shown {
            let is_new = !primitives_of_mesh.contains_key(&shown.mesh);
            let of_mesh: &mut Vec<u32> = primitives_of_mesh.entry(shown.mesh).or_default();
            for (number, json) in shown.json.primitives.iter().enumerate().filter(|_| is_new) {
                let location = format!("meshes[{}].primitives[{number}]", shown.mesh);
                let Checked::Valid(_) = json.mode else {
                    return Err(document.malformed(format_args!("{location}.mode"), "it is none of 0 … 6"));
                };
                of_mesh.push(to_read.len() as u32);
                to_read.push((location, json));
            }
        }
        // Collected one by one, so that the same one of several errors is always reported.
        let read: Vec<Result<_, Error>> =
            to_read.par_iter().map(|(location, json)| Primitive::read(document, json, location)).collect();
        for primitive in read {
            let mut primitive = primitive?;
            warnings.append(&mut primitive.warnings);
            self.primitives.push(primitive);
        }
        Ok(primitives_of_mesh)
    }

    fn add(
        &mut self,
        document: &Document,
        skins: &[Vec<MatrixSource>],
        shown: &ShownMesh<'_>,
        rigid: &mut Option<MatrixRange>,
        primitive: u32,
        warnings: &mut Vec<String>,
    ) -> Result<(), Error> {
        let Primitive { shape, mesh, .. } = &self.primitives[primitive as usize];
        let (vertices, triangles, marks) = (shape.positions.len(), mesh.triangles.len(), mesh.marks.len());
        if triangles + marks == 0 {
            return Ok(());
        }
        let location = format!("nodes[{}]", shown.node);
        let skin = document.json.nodes[shown.node].skin.map(|skin| skin.value());
        let joints = match (skin, skin.and_then(|_| highest_joint(&shape.influences))) {
            (Some(skin), Some(highest)) => {
                let joints = document.element(skins, "skins", skin, format_args!("{location}.skin"))?;
                if highest as usize >= joints.len() {
                    let (mesh, count) = (shown.mesh, joints.len());
                    let cause = format!("a vertex of mesh {mesh} follows joint {highest}, but there are {count}");
                    return Err(document.malformed(format_args!("skins[{skin}]"), cause));
                }
                Some((skin, joints))
            }
            (Some(_), None) => {
                warnings.push(format!("{location} has a skin, but mesh {} has no joints", shown.mesh));
                None
            }
            (None, _) => None,
        };
        let copies = match (&shown.instances, joints) {
            (Some(instances), None) => instances.count,
            (Some(_), Some(_)) => {
                warnings.push(format!("the instances of {location} were left out, as its mesh follows a skin"));
                1
            }
            (None, _) => 1,
        };
        // Triangles and vertices of meshes and frames.
        document.take_for::<([u32; 3], [u32; 2])>(copies.saturating_mul(triangles), &location)?;
        document.take_for::<([Vec3; 2], [Vec2; 2], [Vec4; 2])>(copies.saturating_mul(vertices), &location)?;
        // Points and lines, then parts and runs of points and lines.
        document.take_for::<[u32; 2]>(copies.saturating_mul(marks), &location)?;
        document.take_for::<(RigPart, (u32, usize), [u64; 8])>(copies, &location)?;
        let added = match (joints, *rigid) {
            (Some((skin, joints)), _) => self.matrices.add_skin(skin, joints),
            (None, Some(added)) => added,
            (None, None) => *rigid.insert(self.matrices.add(&shown.matrices(document)?)),
        };
        let first_vertex = self.vertices as u32;
        self.parts.extend((0..copies as u32).map(|copy| RigPart {
            shape: primitive,
            first_vertex: first_vertex + copy * vertices as u32,
            first_weight: shown.first_weight,
            placement: match joints {
                Some(_) => Placement::Skinned { first_matrix: added.first },
                None => Placement::Rigid { matrix: added.first + copy },
            },
            moves: added.moves,
        }));
        self.of_nodes.extend((0..copies).map(|_| (shown.node as u32, triangles)));
        self.vertices += copies * vertices;
        self.triangles += copies * triangles;
        if marks > 0 {
            self.marks += copies * marks;
            self.node_of_marks.extend((0..copies).map(|_| shown.node as u32));
        }
        Ok(())
    }

    /// The scene's origin, by the positions of all vertices with nodes at a moment.
    pub(super) fn origin(&self, nodes: &Scratch) -> DVec3 {
        let mut bounds = FarBounds::default();
        let mut pose = Pose { matrices: Vec::new(), weights: nodes.pose.weights.clone() };
        let all_are_far = self.parts.iter().all(|part| {
            let shape = &self.primitives[part.shape as usize].shape;
            let sources = if part.moves { &self.matrices.moving } else { &self.matrices.still };
            let (first, count, placement) = match part.placement {
                Placement::Rigid { matrix } => (matrix as usize, 1, Placement::Rigid { matrix: 0 }),
                Placement::Skinned { first_matrix } => {
                    let highest = highest_joint(&shape.influences).map_or(0, |joint| joint as usize);
                    (first_matrix as usize, highest + 1, Placement::Skinned { first_matrix: 0 })
                }
            };
            pose.matrices.clear();
            pose.matrices.extend(sources[first..][..count].iter().map(|source| source.at(&nodes.world_from_node)));
            let part = RigPart { placement, ..*part };
            part.positions(&pose, shape, |position| bounds.add(position.as_dvec3()))
        });
        if all_are_far { bounds.origin() } else { DVec3::ZERO }
    }

    /// Nodes with their numbers of triangles, in the triangles' order; and the node of each run of points and lines.
    pub(super) fn of_nodes(&self) -> (Vec<(u32, usize)>, Vec<u32>) {
        (self.of_nodes.clone(), self.node_of_marks.clone())
    }

    /// The objects of triangles: nodes, by their names, or else their meshes' names, or else their numbers. And the
    /// object of each part.
    ///
    /// # Errors
    /// Where there is no memory for so many names.
    pub(super) fn objects(&self, document: &Document) -> Result<(Objects, Vec<u32>), Error> {
        let (mut objects, mut object_of_part) = (Objects::default(), Vec::with_capacity(self.parts.len()));
        let (mut first, mut last) = (0, None);
        for &(node, triangles) in &self.of_nodes {
            if last.replace(node) != Some(node) {
                // Names themselves are shorter than the JSON.
                document.take_for::<[u64; 16]>(1, "names of nodes")?;
                let json = &document.json.nodes[node as usize];
                let mesh = json.mesh.and_then(|mesh| document.json.meshes.get(mesh.value()));
                let names = [json.name.as_deref(), mesh.and_then(|mesh| mesh.name.as_deref())];
                match names.into_iter().flatten().find(|name| !name.is_empty()) {
                    Some(name) => objects.begin(first, name),
                    None => objects.begin(first, &format!("node {node}")),
                }
            }
            object_of_part.extend(objects.last());
            first += triangles;
        }
        Ok((objects, object_of_part))
    }

    /// A rig of all parts, and the sources of its poses' matrices.
    pub(super) fn into_rig(mut self, rest: &Rest, animations: &Animations) -> (Rig, Vec<MatrixSource>) {
        let channels = animations.channels.iter().zip(&rest.slot_of_channel);
        let morphing = channels.filter(|(channel, _)| channel.property == Property::MorphTargetWeights);
        let morphing: HashSet<u32> = morphing.map(|(_, &first_weight)| first_weight).collect();
        let shapes: Vec<_> = self.primitives.into_iter().map(|primitive| Arc::new(primitive.shape)).collect();
        let Matrices { moving: mut matrices, still, .. } = self.matrices;
        let moving_matrices = matrices.len();
        matrices.extend(still);
        for RigPart { placement, moves, first_weight, shape, .. } in &mut self.parts {
            let (Placement::Rigid { matrix } | Placement::Skinned { first_matrix: matrix }) = placement;
            *matrix += if *moves { 0 } else { moving_matrices as u32 };
            // Nodes without weights share the index of the next node's.
            *moves |= !shapes[*shape as usize].morph_targets.is_empty() && morphing.contains(first_weight);
        }
        let rig = Rig {
            parts: self.parts,
            vertices: self.vertices,
            has_normals: shapes.iter().any(|shape| !shape.normals.is_empty()),
            has_tangents: shapes.iter().any(|shape| !shape.tangents.is_empty()),
            moving_matrices,
            shapes,
        };
        (rig, matrices)
    }
}

impl ShownMesh<'_> {
    /// Sources of its mesh's matrices, where that follows no skin: the node, or each instance in it.
    fn matrices(&self, document: &Document) -> Result<Vec<MatrixSource>, Error> {
        let node = self.node as u32;
        let Some(instances) = &self.instances else { return Ok(vec![MatrixSource { node, node_from_mesh: None }]) };
        let instances = instances.read(document)?.into_iter();
        Ok(instances.map(|instance| MatrixSource { node, node_from_mesh: Some(instance) }).collect())
    }
}

fn shown<'a>(document: &'a Document, nodes: &Nodes, first_weights: &[u32]) -> Result<Vec<ShownMesh<'a>>, Error> {
    let mut shown = Vec::new();
    for (node, json) in document.json.nodes.iter().enumerate().filter(|&(node, _)| nodes.visible[node]) {
        let Some(mesh) = json.mesh.map(|mesh| mesh.value()) else { continue };
        let instances = Instances::find(document, json, node)?;
        let json = document.element(&document.json.meshes, "meshes", mesh, format_args!("nodes[{node}].mesh"))?;
        shown.push(ShownMesh { node, mesh, json, instances, first_weight: first_weights[node] });
    }
    Ok(shown)
}

/// Checks, before any memory is taken for them, that there won't be absurdly many triangles, points, lines or morph targets.
fn check_triangles(document: &Document, shown: &[ShownMesh<'_>]) -> Result<(), Error> {
    const MAX_MORPHED: u64 = 1 << 30;
    let mut triangles_of_mesh = HashMap::new();
    let (mut copied, mut morphed) = (0_u64, 0_u64);
    for shown in shown {
        let triangles = match triangles_of_mesh.get(&shown.mesh) {
            Some(&known) => known,
            None => {
                let (triangles, with_targets) = count_triangles(document, shown)?;
                morphed = morphed.saturating_add(with_targets);
                triangles_of_mesh.insert(shown.mesh, triangles);
                triangles
            }
        };
        let copies = shown.instances.as_ref().map_or(1, |instances| instances.count) as u64;
        copied = copied.saturating_add(triangles.saturating_mul(copies));
    }
    if copied > MAX_TRIANGLES {
        return Err(too_many(document, &format!("{copied} triangles")));
    }
    if morphed > MAX_MORPHED {
        return Err(too_many(document, &format!("{morphed} triangles in all morph targets together")));
    }
    Ok(())
}

/// Number of a mesh's triangles, points and lines, once and for each morph target, by the counts of its accessors.
fn count_triangles(document: &Document, shown: &ShownMesh<'_>) -> Result<(u64, u64), Error> {
    let (mut triangles, mut with_targets) = (0_u64, 0_u64);
    for (number, primitive) in shown.json.primitives.iter().enumerate() {
        let Checked::Valid(mode) = primitive.mode else { continue };
        let location = format!("meshes[{}].primitives[{number}]", shown.mesh);
        let positions = || {
            let name = Checked::Valid(json::mesh::Semantic::Positions);
            Some((*primitive.attributes.get(&name)?, "attributes.POSITION"))
        };
        let Some((counted, name)) = primitive.indices.map(|indices| (indices, "indices")).or_else(positions) else {
            continue;
        };
        let elements = document.accessor(counted, format_args!("{location}.{name}"))?.count() as u64;
        let own = piece_count(mode, elements);
        let targets = primitive.targets.as_ref().map_or(0, Vec::len) as u64;
        triangles = triangles.saturating_add(own);
        with_targets = with_targets.saturating_add(own.saturating_mul(1 + targets));
    }
    Ok((triangles, with_targets))
}

fn too_many(document: &Document, what: &str) -> Error {
    document.malformed("scene", format!("it would have {what}, which is more than any memory is meant for"))
}

/// The highest joint of all vertices.
fn highest_joint(sets: &[Vec<Influences>]) -> Option<u32> {
    sets.iter().flatten().flat_map(|influences| influences.joints).max().map(u32::from)
}
