//! Which primitive is shown where: every copy of a primitive is a part with triangles and vertices of its own.

use std::collections::HashMap;

use glam::Affine3A;
use gltf::json;
use gltf::json::validation::Checked;
use rayon::prelude::*;

use super::document::Document;
use super::instances::Instances;
use super::nodes::Nodes;
use super::primitive::{Primitive, triangle_count};
use super::skin::Skins;
use crate::Error;

/// The most triangles, and the most vertices, that a scene may have once all copies of its meshes are made.
const MAX_ELEMENTS: u64 = 1 << 28;

/// A copy of a primitive.
#[derive(Debug)]
pub(super) struct Part {
    /// Index in [`Parts::primitives`].
    pub(super) primitive: u32,
    /// Index of its first vertex in the frame.
    pub(super) first_vertex: u32,
    /// Index of its first triangle in the frame.
    pub(super) first_triangle: u32,
    pub(super) placement: Placement,
    /// Index of the node's first morph weight among those of all nodes.
    pub(super) first_weight: u32,
}

/// What moves a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Placement {
    /// A node.
    Node(u32),
    /// A node, and one of [`Parts::instances`] in it.
    Instance { node: u32, instance: u32 },
    /// The joints of a skin, of which the first has this index among those of all skins.
    Skin { first_joint: u32 },
}

/// The parts of a scene and what they are made from.
#[derive(Debug, Default)]
pub(super) struct Parts {
    pub(super) primitives: Vec<Primitive>,
    /// In the order of their vertices and triangles, which have no gaps.
    pub(super) parts: Vec<Part>,
    /// From the space of each instance to that of its node.
    pub(super) instances: Vec<Affine3A>,
    pub(super) vertices: usize,
    pub(super) triangles: usize,
}

/// A visible node's mesh, before it is read.
struct Shown<'a> {
    node: usize,
    mesh: usize,
    json: &'a json::Mesh,
    instances: Option<Instances<'a>>,
}

impl Parts {
    /// Reads the meshes of all visible nodes. `first_weights` has each node's first morph weight.
    ///
    /// # Errors
    /// Where anything in them is broken, or the copies would have absurdly many triangles.
    pub(super) fn read(
        document: &Document,
        nodes: &Nodes,
        skins: &Skins,
        first_weights: &[u32],
        warnings: &mut Vec<String>,
    ) -> Result<Self, Error> {
        let shown = shown(document, nodes)?;
        check_triangles(document, &shown)?;
        let mut parts = Self::default();
        let primitives_of_mesh = parts.read_primitives(document, &shown, warnings)?;
        for shown in shown {
            let before = parts.parts.len();
            for &primitive in &primitives_of_mesh[&shown.mesh] {
                parts.add(document, skins, &shown, primitive, first_weights[shown.node], warnings)?;
            }
            // Only now is it known that there won't be absurdly many.
            if let Some(instances) = shown.instances.filter(|_| parts.parts.len() > before) {
                parts.instances.extend(instances.read()?);
            }
        }
        Ok(parts)
    }

    /// Reads each shown mesh's primitives once, in parallel, and says where the usable ones are.
    fn read_primitives(
        &mut self,
        document: &Document,
        shown: &[Shown<'_>],
        warnings: &mut Vec<String>,
    ) -> Result<HashMap<usize, Vec<u32>>, Error> {
        let mut primitives_of_mesh = HashMap::new();
        let mut to_read = Vec::new();
        let (mut without_triangles, mut first_without) = (0, String::new());
        for shown in shown {
            let is_new = !primitives_of_mesh.contains_key(&shown.mesh);
            let of_mesh: &mut Vec<u32> = primitives_of_mesh.entry(shown.mesh).or_default();
            for (number, json) in shown.json.primitives.iter().enumerate().filter(|_| is_new) {
                let location = format!("meshes[{}].primitives[{number}]", shown.mesh);
                let Checked::Valid(mode) = json.mode else {
                    return Err(document.malformed(format_args!("{location}.mode"), "it is none of 0 … 6"));
                };
                if triangle_count(mode, 0).is_some() {
                    of_mesh.push(to_read.len() as u32);
                    to_read.push((location, json));
                } else {
                    without_triangles += 1;
                    first_without = if without_triangles == 1 { location } else { first_without };
                }
            }
        }
        if without_triangles > 0 {
            warnings.push(format!(
                "{without_triangles} primitives of points or lines were left out, the first is {first_without}"
            ));
        }
        // Collected one by one, so that of several errors always the same one is told.
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
        skins: &Skins,
        shown: &Shown<'_>,
        primitive: u32,
        first_weight: u32,
        warnings: &mut Vec<String>,
    ) -> Result<(), Error> {
        let Primitive { shape, surface, .. } = &self.primitives[primitive as usize];
        let (vertices, triangles) = (shape.positions.len(), surface.triangles.len());
        if triangles == 0 {
            return Ok(());
        }
        let node = shown.node as u32;
        let location = format!("nodes[{node}]");
        let skin = document.json.nodes[shown.node].skin;
        let first_joint = match (skin, shape.highest_joint) {
            (Some(skin), Some(highest)) => {
                let (first, count) = skins.range(document, skin.value(), &location)?;
                if highest >= count {
                    let cause =
                        format!("a vertex of mesh {} follows joint {highest}, but there are {count}", shown.mesh);
                    return Err(document.malformed(format_args!("skins[{}]", skin.value()), cause));
                }
                Some(first)
            }
            (Some(_), None) => {
                warnings.push(format!("{location} has a skin, but mesh {} has no joints", shown.mesh));
                None
            }
            (None, _) => None,
        };
        let copies = match (&shown.instances, first_joint) {
            (Some(instances), None) => instances.count,
            (Some(_), Some(_)) => {
                warnings.push(format!("the instances of {location} were left out, as its mesh follows a skin"));
                1
            }
            (None, _) => 1,
        };
        self.check_size(document, copies, vertices, triangles)?;
        let first_instance = self.instances.len() as u32;
        let (first_vertex, first_triangle) = (self.vertices as u32, self.triangles as u32);
        self.parts.extend((0..copies as u32).map(|copy| Part {
            primitive,
            first_vertex: first_vertex + copy * vertices as u32,
            first_triangle: first_triangle + copy * triangles as u32,
            placement: match (first_joint, &shown.instances) {
                (Some(first_joint), _) => Placement::Skin { first_joint },
                (None, Some(_)) => Placement::Instance { node, instance: first_instance + copy },
                (None, None) => Placement::Node(node),
            },
            first_weight,
        }));
        self.vertices += copies * vertices;
        self.triangles += copies * triangles;
        Ok(())
    }

    fn check_size(&self, document: &Document, copies: usize, vertices: usize, triangles: usize) -> Result<(), Error> {
        let total =
            |so_far: usize, more: usize| (copies as u64).saturating_mul(more as u64).saturating_add(so_far as u64);
        let (vertices, triangles) = (total(self.vertices, vertices), total(self.triangles, triangles));
        if vertices.max(triangles) > MAX_ELEMENTS {
            return Err(too_many(document, &format!("{vertices} vertices and {triangles} triangles")));
        }
        Ok(())
    }

    /// The primitive of which `part` is a copy.
    pub(super) fn primitive(&self, part: &Part) -> &Primitive {
        &self.primitives[part.primitive as usize]
    }
}

fn shown<'a>(document: &'a Document, nodes: &Nodes) -> Result<Vec<Shown<'a>>, Error> {
    let mut shown = Vec::new();
    for (node, json) in document.json.nodes.iter().enumerate().filter(|&(node, _)| nodes.visible[node]) {
        let Some(mesh) = json.mesh.map(|mesh| mesh.value()) else { continue };
        let instances = Instances::find(document, json, node)?;
        let json = document.element(&document.json.meshes, "meshes", mesh, format_args!("nodes[{node}].mesh"))?;
        shown.push(Shown { node, mesh, json, instances });
    }
    Ok(shown)
}

/// Checks, before any memory is taken for them, that there won't be absurdly many triangles or morph targets.
fn check_triangles(document: &Document, shown: &[Shown<'_>]) -> Result<(), Error> {
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
    if copied > MAX_ELEMENTS {
        return Err(too_many(document, &format!("{copied} triangles")));
    }
    if morphed > MAX_MORPHED {
        return Err(too_many(document, &format!("{morphed} triangles in all morph targets together")));
    }
    Ok(())
}

/// How many triangles a mesh has, once and for each morph target, as far as its accessors say.
fn count_triangles(document: &Document, shown: &Shown<'_>) -> Result<(u64, u64), Error> {
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
        let own = triangle_count(mode, elements).unwrap_or(0);
        let targets = primitive.targets.as_ref().map_or(0, Vec::len) as u64;
        triangles = triangles.saturating_add(own);
        with_targets = with_targets.saturating_add(own.saturating_mul(1 + targets));
    }
    Ok((triangles, with_targets))
}

fn too_many(document: &Document, what: &str) -> Error {
    document.malformed("scene", format!("it would have {what}, which is more than any memory is meant for"))
}
