//! Wavefront OBJ with its material library (MTL).
//!
//! An own reader: the `tobj` crate panics on some broken libraries, shifts texture coordinates where only some corners
//! have them, splits vertices shared by two objects, and its errors don't say on which line.

mod geometry;
mod library;
mod materials;
mod textures;

use std::mem;
use std::path::Path;
use std::sync::Arc;

use glam::DVec3;
use umbrage_scene::{Error, Materials};

use crate::folder::{self, Files, Folder};
use crate::memory::{Budget, Limits};
use crate::{OpenOptions, foreign, still::Still};
use geometry::Geometry;

/// Reads an OBJ file and the libraries that it names.
///
/// Polygons are cut as [`polygon`](crate::polygon) says. Corners with the same position, texture coordinates and normal share a vertex, across objects
/// and groups too. Texture coordinates are turned upside down: OBJ's origin is the image's lower left corner. Vertex
/// colours are taken as sRGB, as the common exporters write them. Smoothing groups have no effect.
///
/// Libraries and textures are not read again if the last file had the same ones.
///
/// # Errors
/// Where the OBJ file or a library can't be read, or the OBJ file breaks its format. Libraries and textures that are missing,
/// and statements of a library that can't be read, are warnings.
pub(crate) fn read(path: &Path, shared: &mut SharedMaterials, budget: &Budget) -> Result<Still, Error> {
    still(path, &mut parsed(path, shared, budget)?, shared, budget)
}

/// The positions in an OBJ file, whether or not faces use them.
#[derive(Debug)]
pub(crate) struct Positions {
    pub(crate) count: usize,
    /// The index of each vertex's position.
    pub(crate) of_vertex: Vec<u32>,
}

/// As [`read`], with the position of the file that each vertex comes from.
///
/// # Errors
/// As [`read`].
pub(crate) fn read_with_positions(
    path: &Path,
    shared: &mut SharedMaterials,
    budget: &Budget,
) -> Result<(Still, Positions), Error> {
    let mut geometry = parsed(path, shared, budget)?;
    let still = still(path, &mut geometry, shared, budget)?;
    Ok((still, geometry.positions(path)?))
}

fn parsed(path: &Path, shared: &SharedMaterials, budget: &Budget) -> Result<Geometry, Error> {
    let bytes = folder::read(path, budget).map_err(|source| Error::read(path, source))?;
    foreign::expect_text(path, &bytes)?;
    let origin = shared.origin.unwrap_or_else(|| geometry::origin(&bytes));
    Geometry::parse(path, &bytes, origin, budget)
}

/// Makes a frame of `geometry`, whose triangles are taken away.
fn still(path: &Path, geometry: &mut Geometry, shared: &mut SharedMaterials, budget: &Budget) -> Result<Still, Error> {
    let folder = Folder::of(path, shared.allow_outside);
    let wanted = Wanted { folder, libraries: geometry.libraries.clone(), names: geometry.material_names.clone() };
    let mut warnings = geometry.warnings();
    let materials = match &shared.last {
        Some((had, materials)) if *had == wanted => Arc::clone(materials),
        _ => {
            let materials = materials::load(&wanted.folder, &wanted.libraries, &wanted.names, budget, &mut warnings)?;
            let materials = Arc::new(materials);
            shared.last = Some((wanted, Arc::clone(&materials)));
            materials
        }
    };
    let vertices = geometry.vertices(path)?;
    if geometry.triangles.is_empty() && geometry.marks.is_empty() {
        warnings.push("the file has no faces".to_owned());
    }
    let triangles = mem::take(&mut geometry.triangles);
    let mut frame = vertices.into_frame(triangles, mem::take(&mut geometry.material_of_triangle), materials);
    let mesh = Arc::make_mut(&mut frame.mesh);
    mesh.objects = mem::take(&mut geometry.objects);
    mesh.marks = mem::take(&mut geometry.marks);
    Ok(Still { frame, warnings, origin: geometry.origin, ..Still::default() })
}

/// The materials of the last file read, for the next one if it has the same.
#[derive(Debug)]
pub(crate) struct SharedMaterials {
    last: Option<(Wanted, Arc<Materials>)>,
    allow_outside: bool,
    /// Origin of all files of a sequence, that of its first; `None` where each file has its own.
    pub(crate) origin: Option<DVec3>,
    /// [`OpenOptions::crease_degrees`].
    pub(crate) crease_degrees: f32,
    /// Limits of each file.
    pub(crate) limits: Limits,
}

impl SharedMaterials {
    /// No materials yet, for files opened with `options`.
    pub(crate) fn new(options: &OpenOptions, files: Files) -> Self {
        let OpenOptions { allow_outside, crease_degrees, .. } = *options;
        Self { last: None, allow_outside, origin: None, crease_degrees, limits: options.limits(files) }
    }
}

/// Folder, libraries and names, which decide the materials that a file gets.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Wanted {
    folder: Folder,
    /// The text after each `mtllib`.
    libraries: Vec<String>,
    /// Names of the materials that triangles use, in order of first use; `None` before any `usemtl`.
    names: Vec<Option<String>>,
}
