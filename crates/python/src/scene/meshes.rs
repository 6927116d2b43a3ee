//! The triangles of a scene in world space, as all its structures take them.

use std::ops::Range;

use glam::{DMat4, DVec3, Vec3};
use umbrage::rays::{Scanned, Triangles};

/// Meshes one after the other: a triangle's id is its index among all.
#[derive(Debug, Default)]
pub(super) struct Meshes {
    positions: Vec<Vec3>,
    indices: Vec<[u32; 3]>,
    geometries: Vec<Geometry>,
}

/// A mesh that was added.
#[derive(Debug)]
struct Geometry {
    vertices: Range<usize>,
    triangles: Range<usize>,
    moved: Option<Moved>,
}

/// What a transform was given to.
#[derive(Debug)]
struct Moved {
    world_from_object: DMat4,
    /// The mesh's own coordinates.
    vertices: Vec<Vec3>,
}

impl Meshes {
    pub(super) fn triangles(&self) -> Triangles<'_> {
        Triangles { positions: &self.positions, indices: &self.indices }
    }

    pub(super) fn count(&self) -> usize {
        self.geometries.len()
    }

    /// How many vertices a geometry has.
    pub(super) fn vertices_of(&self, geometry: usize) -> usize {
        self.geometries[geometry].vertices.len()
    }

    /// The ids of a geometry's triangles.
    pub(super) fn triangles_of(&self, geometry: usize) -> Range<usize> {
        self.geometries[geometry].triangles.clone()
    }

    /// Adds a mesh; `None` where there would be more vertices or triangles than ids.
    pub(super) fn add(&mut self, vertices: &[Vec3], triangles: &[[u32; 3]]) -> Option<usize> {
        let first_vertex = u32::try_from(self.positions.len()).ok()?;
        // The highest id stands for none.
        let most = u32::MAX as usize;
        if self.positions.len() + vertices.len() >= most || self.indices.len() + triangles.len() >= most {
            return None;
        }
        let (first, first_triangle) = (self.positions.len(), self.indices.len());
        self.positions.extend_from_slice(vertices);
        self.indices.extend(triangles.iter().map(|corners| corners.map(|corner| corner + first_vertex)));
        self.geometries.push(Geometry {
            vertices: first..self.positions.len(),
            triangles: first_triangle..self.indices.len(),
            moved: None,
        });
        Some(self.geometries.len() - 1)
    }

    /// Moves a geometry's vertices, of which there are as many as before.
    pub(super) fn update(&mut self, geometry: usize, vertices: &[Vec3]) {
        let Geometry { vertices: range, moved, .. } = &mut self.geometries[geometry];
        let world = &mut self.positions[range.clone()];
        match moved {
            None => world.copy_from_slice(vertices),
            Some(moved) => {
                moved.vertices.copy_from_slice(vertices);
                moved.apply(world);
            }
        }
    }

    /// Puts a geometry elsewhere.
    pub(super) fn set_transform(&mut self, geometry: usize, world_from_object: DMat4) {
        let Geometry { vertices, moved, .. } = &mut self.geometries[geometry];
        let world = &mut self.positions[vertices.clone()];
        let moved = moved.get_or_insert_with(|| Moved { world_from_object, vertices: world.to_vec() });
        moved.world_from_object = world_from_object;
        moved.apply(world);
    }

    /// The ids among all triangles of triangles of geometries.
    ///
    /// # Errors
    /// Which isn't there.
    pub(super) fn ids(&self, geometries: &[u32], triangles: &[u32]) -> Result<Vec<u32>, String> {
        let id = |(&geometry, &triangle): (&u32, &u32)| {
            if geometry == Scanned::NONE || triangle == Scanned::NONE {
                return Ok(Scanned::NONE);
            }
            let range = self.geometries.get(geometry as usize).map(|geometry| geometry.triangles.clone());
            let range = range.ok_or_else(|| {
                format!("geometry_ids: expected ids below {}, the number of geometries, found {geometry}", self.count())
            })?;
            if triangle as usize >= range.len() {
                let count = range.len();
                return Err(format!(
                    "primitive_ids: expected ids below {count}, the number of triangles of geometry {geometry}, found {triangle}"
                ));
            }
            Ok((range.start + triangle as usize) as u32)
        };
        geometries.iter().zip(triangles).map(id).collect()
    }

    /// The geometry that a triangle belongs to, and its number there.
    pub(super) fn geometry_of(&self, triangle: u32) -> (u32, u32) {
        let id = triangle as usize;
        // Those without triangles end where they begin.
        let geometry = self.geometries.partition_point(|geometry| geometry.triangles.end <= id);
        (geometry as u32, (id - self.geometries[geometry].triangles.start) as u32)
    }
}

impl Moved {
    /// In f64, then rounded once.
    fn apply(&self, world: &mut [Vec3]) {
        for (world, vertex) in world.iter_mut().zip(&self.vertices) {
            let vertex: DVec3 = vertex.as_dvec3();
            *world = self.world_from_object.transform_point3(vertex).as_vec3();
        }
    }
}
