//! `EXT_mesh_gpu_instancing`: one node that shows its mesh at many places.

use glam::{Affine3A, Vec3};
use gltf::json::{Index, Node};

use super::accessor::Accessor;
use super::document::Document;
use super::nodes::{Trs, rotation};
use crate::Error;

/// The places in node `number` of the copies of its mesh; `None` where it isn't instanced.
///
/// # Errors
/// Where the extension or one of its attributes is broken.
pub(super) fn node_from_instance(
    document: &Document,
    node: &Node,
    number: usize,
) -> Result<Option<Vec<Affine3A>>, Error> {
    const EXTENSION: &str = "EXT_mesh_gpu_instancing";
    let Some(json) = node.extensions.as_ref().and_then(|extensions| extensions.others.get(EXTENSION)) else {
        return Ok(None);
    };
    let place = format!("nodes[{number}].extensions.{EXTENSION}.attributes");
    let attribute = |name: &str| {
        let Some(index) = json.pointer("/attributes").and_then(|attributes| attributes.get(name)) else {
            return Ok(None);
        };
        let place = format!("{place}.{name}");
        let index = index.as_u64().and_then(|index| u32::try_from(index).ok());
        let index = index.ok_or_else(|| document.malformed(&place, "it is not the number of an accessor"))?;
        document.accessor(Index::new(index), place).map(Some)
    };
    let (translations, rotations, scales) = (attribute("TRANSLATION")?, attribute("ROTATION")?, attribute("SCALE")?);
    let Some(count) = [&translations, &rotations, &scales].into_iter().flatten().map(Accessor::count).next() else {
        return Ok(None);
    };
    let mut instances = vec![Trs::IDENTITY; count];
    if let Some(accessor) = translations {
        accessor.expect_count(count, &place)?;
        set(&mut instances, accessor.floats(None, Vec3::from_array)?, |trs, value| trs.translation = value);
    }
    if let Some(accessor) = rotations {
        accessor.expect_count(count, &place)?;
        set(&mut instances, accessor.floats(None, rotation)?, |trs, value| trs.rotation = value);
    }
    if let Some(accessor) = scales {
        accessor.expect_count(count, &place)?;
        set(&mut instances, accessor.floats(None, Vec3::from_array)?, |trs, value| trs.scale = value);
    }
    Ok(Some(instances.iter().map(Trs::parent_from_node).collect()))
}

fn set<T>(instances: &mut [Trs], values: Vec<T>, assign: impl Fn(&mut Trs, T)) {
    instances.iter_mut().zip(values).for_each(|(instance, value)| assign(instance, value));
}
