//! Point caches: sampled positions of the vertices of a mesh beside them.

mod normals;
mod samples;

use std::path::{Path, PathBuf};

use glam::Vec3;
use rayon::prelude::*;
use umbrage_rays::parallel::Parallel;
use umbrage_scene::{Animated, Error, Frame};

use crate::memory::Budget;
use crate::obj::{self, SharedMaterials};
use crate::smooth::{FlatTriangles, smooth};
use normals::Normals;
use samples::Samples;

/// Vertices below which a piece of work is not worth sharing between threads.
const GRAIN: usize = 4096;

/// An OBJ file whose vertices a cache moves.
///
/// Positions are interpolated linearly between samples, and stay after the last one.
#[derive(Debug)]
pub(crate) struct PointCache {
    samples: Samples,
    /// The OBJ file's own shape, whose mesh and materials stay the same.
    rest: Frame,
    /// The point of the cache that each vertex follows.
    point_of_vertex: Vec<u32>,
    /// `None` where the surface is flat.
    normals: Option<Normals>,
    warnings: Vec<String>,
}

impl PointCache {
    /// Reads a cache, and the OBJ file of the same name beside it.
    ///
    /// # Errors
    /// Where either can't be read or breaks its format, or they differ in their numbers of points.
    pub(crate) fn read(path: &Path, fps: f64, shared: &mut SharedMaterials, budget: &Budget) -> Result<Self, Error> {
        let mut warnings = Vec::new();
        let samples = Samples::read(path, fps, budget, &mut warnings)?;
        let mesh = mesh_beside(path, budget)?;
        let (mut still, mut positions) = obj::read_with_positions(&mesh, shared, budget)?;
        if samples.points() != positions.count {
            let (points, vertices) = (samples.points(), positions.count);
            let cause = format!("it moves {points} points, but {} has {vertices} vertices (`v`)", mesh.display());
            return Err(Error::malformed(path, "the number of points", cause));
        }
        let smoothed = smooth(&mut still.frame, shared.crease_degrees, FlatTriangles::Normals, budget);
        let normals = smoothed.and_then(|copied| {
            // Copies of vertices follow the points of their originals.
            let of_vertex = &mut positions.of_vertex;
            budget.reserve(of_vertex, copied.len(), "positions of vertices")?;
            copied.into_iter().for_each(|vertex| of_vertex.push(of_vertex[vertex as usize]));
            Normals::new(&still.frame, budget)
        });
        let normals = normals.map_err(|why| Error::malformed(&mesh, "the normals", why))?;
        warnings.extend(still.warnings);
        Ok(Self { samples, rest: still.frame, point_of_vertex: positions.of_vertex, normals, warnings })
    }
}

/// The OBJ file that a cache moves.
fn mesh_beside(path: &Path, budget: &Budget) -> Result<PathBuf, Error> {
    let candidates = ["obj", "OBJ"].map(|end| path.with_extension(end));
    let found = candidates.iter().find(|mesh| budget.may_read().has(mesh));
    found.cloned().ok_or_else(|| {
        let cause = format!("a point cache moves a mesh: it needs {} beside it", candidates[0].display());
        Error::address(path.display().to_string(), cause)
    })
}

impl Animated for PointCache {
    fn duration_seconds(&self) -> f64 {
        self.samples.duration_seconds()
    }

    /// Positions may be NaN or infinite, as in the cache: their triangles are left out.
    fn pose(&self, seconds: f64, frame: &mut Frame) -> Result<(), Error> {
        frame.mesh.clone_from(&self.rest.mesh);
        frame.materials.clone_from(&self.rest.materials);
        frame.tangents.clear();
        frame.positions.resize(self.point_of_vertex.len(), Vec3::ZERO);
        let moment = self.samples.at(seconds);
        let vertices = frame.positions.par_iter_mut().zip(&self.point_of_vertex).with_min_len(GRAIN);
        vertices.each(|(position, &point)| *position = moment.position(point as usize));
        match &self.normals {
            Some(normals) => normals.follow(&self.rest.mesh.triangles, &frame.positions, &mut frame.normals),
            None => frame.normals.clear(),
        }
        Ok(())
    }

    fn origin(&self) -> [f64; 3] {
        self.samples.origin().into()
    }

    fn warnings(&self) -> &[String] {
        &self.warnings
    }
}
