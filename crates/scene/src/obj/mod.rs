//! Wavefront OBJ with its material library (MTL).
//!
//! An own reader: the `tobj` crate panics on some broken libraries, shifts texture coordinates where only some corners
//! have them, splits vertices shared by two objects, and its errors don't say on which line.

mod geometry;
mod library;
mod materials;
mod textures;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::{Error, Materials, still::Still};
use geometry::Geometry;

/// Reads an OBJ file and the libraries that it names.
///
/// Polygons become fans. Corners with the same position, texture coordinates and normal share a vertex, across objects
/// and groups too. Texture coordinates are turned upside down: OBJ's origin is the image's lower left corner. Vertex
/// colours are taken as sRGB, as the common exporters write them. Smoothing groups have no effect: a corner without a
/// normal is flat.
///
/// # Errors
/// Where the OBJ file can't be read, or it or a library breaks its format. Libraries and textures that are missing are
/// warnings.
pub(crate) fn read(path: &Path) -> Result<Still, Error> {
    read_sharing(path, &mut SharedMaterials::default())
}

/// The materials of the last file read, for a next one that asks for the same.
#[derive(Debug, Default)]
pub(crate) struct SharedMaterials(Option<(Wanted, Arc<Materials>)>);

/// What decides which materials a file gets.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Wanted {
    folder: PathBuf,
    /// The text after each `mtllib`.
    libraries: Vec<String>,
    /// Names of the materials that triangles use, in order of first use; `None` before any `usemtl`.
    names: Vec<Option<String>>,
}

/// As [`read`], without reading libraries and textures again when the last file wanted the same.
///
/// # Errors
/// As [`read`].
pub(crate) fn read_sharing(path: &Path, shared: &mut SharedMaterials) -> Result<Still, Error> {
    let bytes = std::fs::read(path).map_err(|source| Error::read(path, source))?;
    let geometry = Geometry::parse(path, &bytes)?;
    drop(bytes);
    let folder = path.parent().unwrap_or(Path::new("")).to_owned();
    let wanted = Wanted { folder, libraries: geometry.libraries.clone(), names: geometry.material_names.clone() };
    let mut warnings = geometry.warnings();
    let materials = match &shared.0 {
        Some((had, materials)) if *had == wanted => Arc::clone(materials),
        _ => {
            let materials = Arc::new(materials::load(&wanted.folder, &wanted.libraries, &wanted.names, &mut warnings)?);
            shared.0 = Some((wanted, Arc::clone(&materials)));
            materials
        }
    };
    let vertices = geometry.vertices(path)?;
    if geometry.triangles.is_empty() {
        warnings.push("the file has no faces".to_owned());
    }
    let frame = vertices.into_frame(geometry.triangles, geometry.material_of_triangle, materials);
    Ok(Still { frame, warnings })
}
