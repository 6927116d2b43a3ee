//! `EXT_mesh_gpu_instancing`: one node that shows many copies of its mesh.

use glam::{Affine3A, Vec3};
use gltf::json::{Index, Node};
use umbrage_scene::Error;

use super::accessor::Accessor;
use super::document::Document;
use super::matrices::MatrixSource;
use super::nodes::{Trs, rotation};

/// The accessors of the transforms of a mesh's copies.
#[derive(Debug)]
pub(super) struct Instances<'a> {
    translations: Option<Accessor<'a>>,
    rotations: Option<Accessor<'a>>,
    scales: Option<Accessor<'a>>,
    /// Number of copies.
    pub(super) count: usize,
}

impl<'a> Instances<'a> {
    /// Finds the instances of node `number`; `None` where the node isn't instanced.
    ///
    /// # Errors
    /// Where one of the extension's attributes is broken, or they have different lengths.
    pub(super) fn find(document: &'a Document, node: &Node, number: usize) -> Result<Option<Self>, Error> {
        const EXTENSION: &str = "EXT_mesh_gpu_instancing";
        let Some(json) = node.extensions.as_ref().and_then(|extensions| extensions.others.get(EXTENSION)) else {
            return Ok(None);
        };
        let attribute = |name: &str| {
            let Some(index) = json.pointer("/attributes").and_then(|attributes| attributes.get(name)) else {
                return Ok(None);
            };
            let location = format!("nodes[{number}].extensions.{EXTENSION}.attributes.{name}");
            let index = index.as_u64().and_then(|index| u32::try_from(index).ok());
            let index = index.ok_or_else(|| document.malformed(&location, "it is not the number of an accessor"))?;
            document.accessor(Index::new(index), &location).map(|accessor| Some((accessor, location)))
        };
        let attributes = [attribute("TRANSLATION")?, attribute("ROTATION")?, attribute("SCALE")?];
        let Some(count) = attributes.iter().flatten().map(|(accessor, _)| accessor.count()).next() else {
            return Ok(None);
        };
        for (accessor, location) in attributes.iter().flatten() {
            accessor.expect_count(count, location)?;
        }
        let [translations, rotations, scales] = attributes.map(|attribute| attribute.map(|(accessor, _)| accessor));
        Ok(Some(Self { translations, rotations, scales, count }))
    }

    /// Reads each copy's transform to its node.
    ///
    /// # Errors
    /// Where an attribute has the wrong number of components, or the instances exceed the memory budget.
    pub(super) fn read(&self, document: &Document) -> Result<Vec<Affine3A>, Error> {
        document.take_for::<(Trs, Affine3A, MatrixSource)>(self.count, "instances")?;
        let mut instances = vec![Trs::IDENTITY; self.count];
        if let Some(accessor) = &self.translations {
            set(&mut instances, accessor.floats(None, Vec3::from_array)?, |trs, value| trs.translation = value);
        }
        if let Some(accessor) = &self.rotations {
            set(&mut instances, accessor.floats(None, rotation)?, |trs, value| trs.rotation = value);
        }
        if let Some(accessor) = &self.scales {
            set(&mut instances, accessor.floats(None, Vec3::from_array)?, |trs, value| trs.scale = value);
        }
        Ok(instances.iter().map(Trs::parent_from_node).collect())
    }
}

fn set<T>(instances: &mut [Trs], values: Vec<T>, assign: impl Fn(&mut Trs, T)) {
    instances.iter_mut().zip(values).for_each(|(instance, value)| assign(instance, value));
}
