//! glTF 2.0: reading and posing.
//!
//! `document` reads files, `accessor` their bytes. `nodes`, `matrices`, `animation`, `primitive`, `material` and `attached`
//! read the content of their names; `parts` puts meshes and nodes together and makes a rig of the result, `expand` finds
//! the triangles of it that move together. `pose` finds the moving nodes at a moment; the rig poses the vertices that follow
//! them. `far` does so in f64 for scenes far from the origin of their coordinates.

mod accessor;
mod animation;
mod attached;
mod curve;
mod document;
mod draco;
mod expand;
mod extensions;
mod far;
mod instances;
mod layers;
mod material;
mod matrices;
mod meshopt;
mod moved;
mod nodes;
mod parts;
mod pointers;
mod pose;
mod primitive;
mod rest;
mod tangents;
mod texture;
pub(crate) mod variants;
mod visibility;

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use glam::DVec3;
use umbrage_scene::rig::Rig;
use umbrage_scene::{Error, Materials, Mesh};

use self::animation::Animations;
use self::attached::{NodeCamera, NodeLight};
use self::document::Document;
use self::far::Far;
use self::matrices::{MatrixSource, read_skins};
use self::moved::{Emission, Target};
use self::nodes::Nodes;
use self::parts::RigParts;
use self::pose::Scratch;
use self::rest::{MorphWeights, Rest};
use self::visibility::Visibility;
use crate::OpenOptions;
use crate::memory::Budget;

/// A glTF 2.0 scene, ready to be posed.
#[derive(Debug)]
pub(crate) struct GltfScene {
    path: PathBuf,
    rest: Rest,
    animations: Animations,
    rig: Arc<Rig>,
    /// Source of each matrix of the rig's poses.
    matrix_sources: Vec<MatrixSource>,
    cameras: Vec<NodeCamera>,
    lights: Vec<NodeLight>,
    mesh: Arc<Mesh>,
    materials: Arc<Materials>,
    /// Emission of each material at rest, where an animation changes any material.
    emissions: Vec<Emission>,
    /// For scenes whose nodes come and go.
    visibility: Option<Visibility>,
    variants: Vec<String>,
    warnings: Vec<String>,
    /// Memory of earlier poses.
    idle: Mutex<Vec<Scratch>>,
}

impl GltfScene {
    /// Opens a `.gltf` or `.glb` file.
    ///
    /// # Errors
    /// Where a file is missing or broken, needs an unsupported extension, or doesn't have the clip.
    pub(crate) fn open(path: &Path, options: &OpenOptions, budget: &Budget) -> Result<Self, Error> {
        let mut warnings = Vec::new();
        let mut document = Document::read(path, options.allow_outside, budget, &mut warnings)?;
        let variants = variants::apply(&mut document, path, options.variant.as_deref())?;
        let nodes = Nodes::read(&document)?;
        let skins = read_skins(&document)?;
        let weights = MorphWeights::read(&document)?;
        let animations = Animations::read(&document, path, |node| weights.count(node), &options.clip, &mut warnings)?;
        let cameras = attached::cameras(&document, &nodes, &mut warnings)?;
        let lights = attached::lights(&document, &nodes, &mut warnings)?;
        let mut rest = Rest::new(&document, &nodes, &weights, &animations);
        let mut parts = RigParts::read(&document, &nodes, &skins, &rest, &weights.first_of_node, &mut warnings)?;
        let mut first = Scratch::new(&rest);
        first.move_nodes(&rest, &animations, 0.0);
        let origin = parts.origin(&first);
        drop(first);
        if origin != DVec3::ZERO {
            rest.place(Far::read(&document, &nodes, &animations, &rest, origin)?);
        }
        let without_material = |primitive: &primitive::Primitive| primitive.material.is_none();
        let needs_default = parts.primitives.iter().any(without_material);
        let materials = material::read(&document, needs_default, &mut warnings)?;
        let (objects, object_of_part) = parts.objects(&document)?;
        let has_toggles = document.pointers.iter().any(|channel| channel.toggled_node().is_some());
        if has_toggles {
            // A mesh without hidden nodes beside the whole one.
            document.take_for::<[[f32; 4]; 2]>(parts.vertices, "nodes that come and go")?;
            document.take_for::<[u32; 5]>(parts.triangles + parts.marks, "nodes that come and go")?;
        }
        let changes_materials = animations.moved.iter().any(|moved| matches!(moved.target, Target::Material(..)));
        let emissions = document.json.materials.iter().filter(|_| changes_materials).map(Emission::of).collect();
        warnings.extend(document.warnings());
        // The file's bytes are as large as the data made from them.
        drop(document);
        let default_material = materials.materials.len().saturating_sub(1) as u32;
        let mesh = parts.take_mesh(default_material, &rest, &object_of_part);
        let mesh = Mesh { objects, ..mesh };
        if mesh.triangles.is_empty() && mesh.marks.is_empty() {
            warnings.push("the file has no triangles in the scene that is shown".to_owned());
        }
        let mesh = Arc::new(mesh);
        let visibility = has_toggles.then(|| Visibility::new(nodes, parts.of_nodes(), &mesh));
        let (rig, matrix_sources) = parts.into_rig(&rest, &animations);
        Ok(Self {
            path: path.to_owned(),
            rest,
            animations,
            rig: Arc::new(rig),
            matrix_sources,
            cameras,
            lights,
            mesh,
            materials: Arc::new(materials),
            emissions,
            visibility,
            variants,
            warnings,
            idle: Mutex::new(Vec::new()),
        })
    }
}
