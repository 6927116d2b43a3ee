//! `KHR_materials_variants`: named alternative materials for the same meshes.

use std::path::Path;

use gltf::json::Index;
use serde::Deserialize;
use umbrage_scene::Error;

use super::document::Document;
use crate::open::unknown_name;

const NAME: &str = "KHR_materials_variants";

#[derive(Deserialize)]
struct Variants {
    variants: Vec<Variant>,
}

#[derive(Deserialize)]
struct Variant {
    name: String,
}

#[derive(Deserialize)]
struct Mappings {
    mappings: Vec<Mapping>,
}

#[derive(Deserialize)]
struct Mapping {
    material: u32,
    variants: Vec<usize>,
}

/// Returns the names of the file's variants, and gives primitives the materials of the variant `wanted`, if any.
///
/// # Errors
/// Where there is no such variant, or its description is broken.
pub(super) fn apply(document: &mut Document, path: &Path, wanted: Option<&str>) -> Result<Vec<String>, Error> {
    let json = document.json.extensions.as_ref().and_then(|extensions| extensions.others.get(NAME));
    let variants = json.map(Variants::deserialize).transpose();
    let variants =
        variants.map_err(|error| document.malformed(format_args!("extensions.{NAME}"), error.to_string()))?;
    let names: Vec<_> = variants.into_iter().flat_map(|all| all.variants).map(|variant| variant.name).collect();
    let Some(wanted) = wanted else { return Ok(names) };
    let number = names.iter().position(|name| name == wanted).ok_or_else(|| unknown(path, wanted, &names))?;
    let mut chosen = Vec::new();
    for (mesh, json) in document.json.meshes.iter().enumerate() {
        for (primitive, json) in json.primitives.iter().enumerate() {
            let Some(json) = json.extensions.as_ref().and_then(|extensions| extensions.others.get(NAME)) else {
                continue;
            };
            let mappings = Mappings::deserialize(json).map_err(|error| {
                let location = format!("meshes[{mesh}].primitives[{primitive}].extensions.{NAME}");
                document.malformed(location, error.to_string())
            })?;
            let mapping = mappings.mappings.into_iter().find(|mapping| mapping.variants.contains(&number));
            chosen.extend(mapping.map(|mapping| (mesh, primitive, mapping.material)));
        }
    }
    for (mesh, primitive, material) in chosen {
        document.json.meshes[mesh].primitives[primitive].material = Some(Index::new(material));
    }
    Ok(names)
}

/// Makes the error for a variant that isn't among `names`.
pub(crate) fn unknown(path: &Path, wanted: &str, names: &[String]) -> Error {
    let names: Vec<_> = names.iter().map(|name| format!("`{name}`")).collect();
    unknown_name(path, "variant", wanted, &names)
}
