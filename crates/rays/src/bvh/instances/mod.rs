//! Meshes that stand in the world many times, without a copy of their triangles.
//!
//! Each mesh has a hierarchy in its own space, and one hierarchy has the boxes of all placements, in two levels (Wald,
//! Benthin and Slusallek, *Distributed interactive ray tracing of dynamic scenes*, 2003). A ray goes through a mesh's
//! hierarchy in the mesh's space, wide enough for all that rounding may do; the predicate is asked about world-space corners.
//! So answers are those of the flattened triangles, bit for bit.

mod place;
mod trace;

use glam::{DAffine3, Vec3};
use rayon::prelude::*;

use super::build::Builder;
use super::{Bvh, Child, Node};
use crate::triangles::Unusable;
use crate::{Hit, SimdLevel, Triangles};
use place::Placed;

/// Triangles of meshes, each mesh placed in the world any number of times.
///
/// Ids are those of the flattened triangles: all triangles of the first placement's mesh, then those of the next
/// placement's.
#[derive(Clone, Copy, Debug, Default)]
pub struct InstancedTriangles<'a> {
    /// The triangles of each mesh, in the mesh's own space.
    pub meshes: &'a [Triangles<'a>],
    /// The places of meshes in the world, in the order of ids.
    pub placements: &'a [Placement],
}

/// A mesh, and its transform to the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// The index of the mesh.
    pub mesh: u32,
    /// Transform from the mesh's space to the world's; any, also one without an inverse.
    pub world_from_mesh: DAffine3,
    /// Rays see the mesh here only where their mask and this one have a bit in common.
    pub mask: u32,
}

impl Placement {
    /// A mesh at its place, for all rays.
    #[must_use]
    pub fn new(mesh: u32, world_from_mesh: DAffine3) -> Self {
        Self { mesh, world_from_mesh, mask: u32::MAX }
    }

    /// A position in the world: computed in f64 and rounded to f32 once.
    #[inline]
    #[must_use]
    pub fn pose(&self, position: Vec3) -> Vec3 {
        self.world_from_mesh.transform_point3(position.as_dvec3()).as_vec3()
    }
}

impl InstancedTriangles<'_> {
    /// The number of triangles in the world.
    #[must_use]
    pub fn len(&self) -> usize {
        self.placements.iter().map(|placement| self.mesh(placement).len()).sum()
    }

    /// Whether there are no triangles in the world.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.placements.iter().all(|placement| self.mesh(placement).is_empty())
    }

    #[inline(always)]
    fn mesh(&self, placement: &Placement) -> Triangles<'_> {
        self.meshes[placement.mesh as usize]
    }
}

/// Answers rays among [placed meshes](InstancedTriangles): hits, ids, t and light bits are those of the flattened triangles.
///
/// Keep it and build it for every frame: its memory is reused. A mesh's hierarchy stays until [`forget`](Self::forget), so a
/// frame in which meshes only move takes a microsecond or two for each placement. A placement takes about 400 bytes.
///
/// Placements that make a mesh flat, stretch it more than a million times as much one way as another, or take it so far away
/// that f32 spoils its shape are flattened inside.
///
/// ```
/// use glam::{DAffine3, DVec3, Vec3};
/// use umbrage_rays::{InstanceTree, InstancedTriangles, Placement, Ray, RayMasks, Scanned, Triangles};
///
/// let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
/// let meshes = [Triangles { positions: &corners, indices: &[[0, 1, 2]] }];
/// let at = |x: f64| Placement::new(0, DAffine3::from_translation(DVec3::X * x));
/// let placements: Vec<_> = (0..100).map(|number| at(2.0 * f64::from(number))).collect();
/// let scene = InstancedTriangles { meshes: &meshes, placements: &placements };
///
/// let (mut tree, mut traced) = (InstanceTree::default(), Scanned::default());
/// tree.build(&scene);
/// let rays = [Ray::new(DVec3::new(14.25, 0.5, 3.0), DVec3::NEG_Z), Ray::new(DVec3::new(15.5, 0.5, 3.0), DVec3::NEG_Z)];
/// tree.trace(&scene, &rays, RayMasks::default(), &mut traced);
/// assert_eq!((traced.t[0], traced.triangle[0]), (3.0, 7));
/// assert_eq!(traced.triangle[1], Scanned::NONE);
/// ```
#[derive(Default)]
pub struct InstanceTree {
    level: SimdLevel,
    meshes: Vec<Mesh>,
    placed: Vec<Placed>,
    /// Over the boxes of placements; a leaf's index is a placement's.
    nodes: Vec<Node>,
    root: Child,
    builder: Builder,
    flattened: Flattened,
}

debug_some!(InstanceTree as tree: "meshes" => tree.meshes.len(), "placed" => tree.placed.len());

#[derive(Default)]
struct Mesh {
    hierarchy: Bvh,
    is_current: bool,
    /// The largest coordinate of a triangle, and the largest side of the box of all.
    reach: f64,
    size: f64,
}

/// The triangles of placements that no ray could be brought into the space of.
#[derive(Default)]
struct Flattened {
    hierarchy: Bvh,
    positions: Vec<Vec3>,
    indices: Vec<[u32; 3]>,
    /// The id of each triangle among all.
    ids: Vec<u32>,
}

impl Flattened {
    fn triangles(&self) -> Triangles<'_> {
        Triangles { positions: &self.positions, indices: &self.indices }
    }
}

impl InstanceTree {
    /// Uses the instructions of a level instead of the widest; answers are the same bit for bit.
    #[must_use]
    pub fn with_level(level: SimdLevel) -> Self {
        Self { level, ..Self::default() }
    }

    /// Marks the triangles of a mesh as changed: its hierarchy is rebuilt by the next build.
    pub fn forget(&mut self, mesh: usize) {
        if let Some(mesh) = self.meshes.get_mut(mesh) {
            mesh.is_current = false;
        }
    }

    /// Builds the hierarchies of new and forgotten meshes, and the one over all placements.
    ///
    /// # Panics
    /// If a placement has a mesh that isn't there, or there are more triangles in the world than ids: 2³² − 1.
    pub fn build(&mut self, scene: &InstancedTriangles<'_>) {
        let Self { level, meshes, placed, nodes, root, builder, flattened } = self;
        meshes.resize_with(scene.meshes.len(), || Mesh { hierarchy: Bvh::with_level(*level), ..Mesh::default() });
        meshes.par_iter_mut().zip(scene.meshes).for_each(|(mesh, triangles)| mesh.build(*triangles));
        place::place_all(scene, meshes, placed, &mut builder.items);
        flattened.fill(*level, scene, placed);
        let built = builder.build(1);
        nodes.resize(built.nodes, Node::EMPTY);
        *root = Child::node(0);
        built.write_nodes(nodes, 0, |_, items| Child::leaf(items[0].id() as usize, 1));
    }

    /// Bytes of memory, of the hierarchies of meshes and of all that grows with placements.
    #[must_use]
    pub fn bytes(&self) -> [usize; 2] {
        use crate::Structure;
        let of_meshes = self.meshes.iter().map(|mesh| mesh.hierarchy.bytes().triangles).sum();
        let Flattened { hierarchy, positions, indices, ids } = &self.flattened;
        let flattened = hierarchy.bytes().triangles
            + positions.capacity() * size_of::<Vec3>()
            + indices.capacity() * size_of::<[u32; 3]>()
            + ids.capacity() * size_of::<u32>();
        let placed = self.placed.capacity() * size_of::<Placed>() + self.nodes.capacity() * size_of::<Node>();
        [of_meshes, placed + self.builder.bytes() + flattened]
    }

    /// The placement of a triangle, given by its id, and the triangle's index in the mesh.
    ///
    /// # Panics
    /// If there is no such triangle.
    #[must_use]
    pub fn of_triangle(&self, id: u32) -> [u32; 2] {
        // Meshes without triangles share their first id with the next placement.
        let placement = self.placed.partition_point(|placed| placed.first <= id) - 1;
        [placement as u32, id - self.placed[placement].first]
    }

    /// The id of a placement's first triangle.
    ///
    /// # Panics
    /// If there is no such placement.
    #[must_use]
    pub fn first_of(&self, placement: usize) -> u32 {
        self.placed[placement].first
    }

    /// The world-space corners of a triangle.
    ///
    /// # Panics
    /// If there is no such triangle, or one of its vertices isn't there.
    #[must_use]
    pub fn corners(&self, scene: &InstancedTriangles<'_>, id: u32) -> [Vec3; 3] {
        let [placement, triangle] = self.of_triangle(id);
        let placement = &scene.placements[placement as usize];
        scene.mesh(placement).corners(triangle).map(|position| placement.pose(position))
    }

    /// The world-space corners of a triangle, or why no ray can hit it.
    fn usable_corners(&self, scene: &InstancedTriangles<'_>, id: u32) -> Result<[Vec3; 3], Unusable> {
        let [placement, triangle] = self.of_triangle(id);
        let placement = &scene.placements[placement as usize];
        scene.mesh(placement).posed_corners(triangle, |position| placement.pose(position))
    }
}

impl Mesh {
    fn build(&mut self, triangles: Triangles<'_>) {
        if std::mem::replace(&mut self.is_current, true) {
            return;
        }
        self.hierarchy.build(triangles);
        let bounds = triangles.bounds();
        let [low, high] = [bounds.min, bounds.max].map(Vec3::as_dvec3);
        let is_empty = self.hierarchy.nodes.is_empty();
        self.reach = if is_empty { 0.0 } else { low.abs().max(high.abs()).max_element() };
        self.size = if is_empty { 0.0 } else { (high - low).max_element() };
    }
}

impl Flattened {
    /// Takes the triangles of placements that aren't in the tree.
    fn fill(&mut self, level: SimdLevel, scene: &InstancedTriangles<'_>, placed: &[Placed]) {
        let Self { positions, indices, ids, .. } = self;
        positions.clear();
        indices.clear();
        ids.clear();
        for (placement, placed) in scene.placements.iter().zip(placed).filter(|(_, placed)| placed.is_flattened()) {
            let mesh = scene.mesh(placement);
            // An index past the last vertex of its own mesh stays past all vertices.
            let vertices = mesh.positions.len();
            let first = positions.len() as u32;
            positions.extend(mesh.positions.iter().map(|&position| placement.pose(position)));
            let moved = |vertex: u32| if (vertex as usize) < vertices { first + vertex } else { u32::MAX };
            indices.extend(mesh.indices.iter().map(|corners| corners.map(moved)));
            ids.extend((placed.first..).take(mesh.len()));
        }
        if indices.is_empty() {
            self.hierarchy = Bvh::with_level(level);
        } else {
            self.hierarchy.level = level;
            let Self { hierarchy, positions, indices, .. } = self;
            hierarchy.build(Triangles { positions, indices });
        }
    }

    /// A hit with the id among all triangles.
    fn hit(&self, hit: Hit) -> Hit {
        Hit { triangle: self.ids[hit.triangle as usize], ..hit }
    }

    /// The triangle here with an id among all, or none.
    fn own(&self, id: u32) -> u32 {
        self.ids.binary_search(&id).map_or(u32::MAX, |index| index as u32)
    }
}
