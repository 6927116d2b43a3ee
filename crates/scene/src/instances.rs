//! Scenes of rigid objects: meshes, each with an id and a transform.

use std::ops::Range;
use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec3};
use umbrage_rays::{Hit, Triangles};

use crate::rig::{Placement, Pose, Rig};
use crate::{Error, Frame, Objects, Scene};

/// Meshes with transforms, each an instance with an id: the nodes of a glTF file, or your own.
///
/// Its [triangles](Self::triangles) are those of all instances in world space, one after the other, for every structure.
/// [`Instances::hit`] turns a hit among them into the instance, its triangle, and the position in its own space.
///
/// ```
/// use glam::{DAffine3, DVec3, Vec3};
/// use umbrage_rays::{Hit, Ray, Scanned, Trace, Tracer};
/// use umbrage_scene::Instances;
///
/// let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
/// let mut instances = Instances::default();
/// let [_floor, sign] = ["floor", "sign"].map(|name| instances.add(name, &corners, &[[0, 1, 2]]).expect("it is small"));
/// instances.set_transform(sign, DAffine3::from_translation(DVec3::new(10.0, 0.0, 0.0)));
///
/// let (mut tracer, mut traced) = (Tracer::default(), Scanned::default());
/// let rays = [Ray::new(DVec3::new(10.25, 0.5, 3.0), DVec3::NEG_Z)];
/// tracer.trace(&Trace::new(instances.triangles(), &rays), &mut traced);
/// let hit: Hit = traced.hits(0).next().expect("the sign is there");
/// let there = instances.hit(&hit);
/// assert_eq!((there.instance, there.triangle, there.position), (sign, 0, DVec3::new(0.25, 0.5, 0.0)));
/// assert_eq!(instances.all()[sign as usize].name(), "sign");
/// ```
#[derive(Clone, Debug, Default)]
pub struct Instances {
    positions: Vec<Vec3>,
    indices: Vec<[u32; 3]>,
    all: Vec<Instance>,
    origin: DVec3,
}

/// A mesh with a transform.
#[derive(Clone, Debug)]
pub struct Instance {
    name: Arc<str>,
    vertices: Range<usize>,
    triangles: Range<usize>,
    /// `None` where the mesh's own space is the world's, from `origin`.
    placed: Option<Placed>,
    origin: DVec3,
}

/// A mesh's transform to the world, and its own vertices.
#[derive(Clone, Debug)]
struct Placed {
    world_from_object: DAffine3,
    /// In the mesh's own space.
    vertices: Vec<Vec3>,
}

/// A hit of an instance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InstanceHit {
    /// The instance's id.
    pub instance: u32,
    /// The triangle's number among the instance's own.
    pub triangle: u32,
    /// Position in the instance's own space, interpolated from its own corners by the hit's weights rather than
    /// transformed back from the world, so it is in the triangle for every transform.
    pub position: DVec3,
}

/// Why a mesh can't be an instance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BadInstance {
    /// A triangle has a vertex that isn't there.
    #[error("a triangle has vertex {index}, but there are {vertices}")]
    Index {
        /// The vertex's index.
        index: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// All instances together would have more vertices or triangles than there are ids.
    #[error("instances have at most 4294967295 vertices and triangles together")]
    TooMany,
}

impl Instance {
    /// Its name; several instances may have the same one.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The ids of its triangles among those of all instances.
    #[must_use]
    pub fn triangles(&self) -> Range<usize> {
        self.triangles.clone()
    }

    /// Number of its vertices.
    #[must_use]
    pub fn vertices(&self) -> usize {
        self.vertices.len()
    }

    /// Its last transform, in the world's coordinates; at first the translation to the [origin](Instances::origin).
    #[must_use]
    pub fn world_from_object(&self) -> DAffine3 {
        let at_origin = || DAffine3::from_translation(self.origin);
        self.placed.as_ref().map_or_else(at_origin, |placed| placed.world_from_object)
    }
}

impl Placed {
    /// In f64, then rounded once.
    fn apply(&self, origin: DVec3, local: &mut [Vec3]) {
        let translation = self.world_from_object.translation - origin;
        let local_from_object = DAffine3 { translation, ..self.world_from_object };
        for (local, vertex) in local.iter_mut().zip(&self.vertices) {
            *local = local_from_object.transform_point3(vertex.as_dvec3()).as_vec3();
        }
    }
}

impl Instances {
    /// No instances; triangles count from a point of the world, for the reasons of [`Scene::origin`].
    #[must_use]
    pub fn with_origin(origin: DVec3) -> Self {
        Self { origin, ..Self::default() }
    }

    /// The point of the world that positions of [triangles](Self::triangles) count from; a scene's, or zero.
    #[must_use]
    pub fn origin(&self) -> DVec3 {
        self.origin
    }

    /// The instances of a scene at a moment; triangles have the same order and positions as in its frames.
    ///
    /// In a glTF file each node that has a mesh is one, or each copy that it shows of one (of several materials: each copy of each
    /// part). Meshes that follow a skin or morph have no rigid place: their own space is the world's, as it is for the objects of
    /// OBJ files and built-in scenes, and for a mesh without any. Vertices that several objects share become vertices of each.
    ///
    /// # Errors
    /// As [`Scene::at`].
    pub fn of_scene(scene: &Scene, seconds: f64) -> Result<Self, Error> {
        let (mut frame, mut pose) = (Frame::default(), Pose::default());
        let rig = scene.pose_rig(seconds, &mut frame, &mut pose)?;
        match &rig {
            Some(rig) => rig.pose(&pose, &mut frame),
            None => scene.pose(seconds, &mut frame)?,
        }
        let posed = rig.as_deref().map(|rig| (rig, &pose));
        let mut instances = Self::with_origin(scene.origin().into());
        let mut numbers = Numbers { of_vertex: vec![(u32::MAX, 0); frame.positions.len()], taken: Vec::new() };
        let (mut first, all) = (0, frame.mesh.triangles.len());
        while first < all {
            let of = Object::of(&frame, posed, first);
            let end = (first + 1..all).find(|&id| Object::of(&frame, posed, id) != of).unwrap_or(all);
            instances.take(&frame, posed, of, first..end, &mut numbers);
            first = end;
        }
        Ok(instances)
    }

    /// Takes a range of a frame's triangles as an instance.
    fn take(
        &mut self,
        frame: &Frame,
        posed: Option<(&Rig, &Pose)>,
        of: Object,
        range: Range<usize>,
        numbers: &mut Numbers,
    ) {
        let (first, first_triangle) = (self.positions.len(), self.indices.len());
        let triangles = &frame.mesh.triangles[range];
        numbers.taken.clear();
        let instance = self.all.len() as u32;
        self.indices
            .extend(triangles.iter().map(|corners| corners.map(|vertex| first as u32 + numbers.of(vertex, instance))));
        self.positions.extend(numbers.taken.iter().map(|&vertex| frame.positions[vertex as usize]));
        let placed = posed.zip(of.matrix).map(|((rig, pose), matrix)| {
            let matrix = &pose.matrices[matrix as usize];
            let own = |&vertex: &u32| {
                let part = part_of(rig, vertex);
                rig.shapes[rig.parts[part].shape as usize].positions[(vertex - rig.parts[part].first_vertex) as usize]
            };
            let world_from_object = DAffine3 {
                matrix3: glam::Mat3::from(matrix.matrix3).as_dmat3(),
                translation: Vec3::from(matrix.translation).as_dvec3() + self.origin,
            };
            Placed { world_from_object, vertices: numbers.taken.iter().map(own).collect() }
        });
        let names = frame.mesh.objects.names();
        let name = of.name.map_or_else(|| Objects::WHOLE.into(), |name| Arc::clone(&names[name as usize]));
        let (vertices, triangles) = (first..self.positions.len(), first_triangle..self.indices.len());
        self.all.push(Instance { name, vertices, triangles, placed, origin: self.origin });
    }

    /// Adds a copy of a mesh, whose own space is the world's until [`set_transform`](Self::set_transform), and returns
    /// its id: the number of earlier instances.
    ///
    /// # Errors
    /// Where a triangle has a vertex that isn't there, or there would be too many vertices or triangles.
    pub fn add(&mut self, name: &str, vertices: &[Vec3], triangles: &[[u32; 3]]) -> Result<u32, BadInstance> {
        let most = triangles.as_flattened().iter().copied().max();
        if let Some(index) = most.filter(|&index| index as usize >= vertices.len()) {
            return Err(BadInstance::Index { index, vertices: vertices.len() });
        }
        let (first, first_triangle) = (self.positions.len(), self.indices.len());
        // The highest id stands for no triangle.
        let most = u32::MAX as usize;
        if first + vertices.len() >= most || first_triangle + triangles.len() >= most || self.all.len() + 1 >= most {
            return Err(BadInstance::TooMany);
        }
        self.positions.extend_from_slice(vertices);
        self.indices.extend(triangles.iter().map(|corners| corners.map(|corner| corner + first as u32)));
        self.all.push(Instance {
            name: name.into(),
            vertices: first..self.positions.len(),
            triangles: first_triangle..self.indices.len(),
            placed: None,
            origin: self.origin,
        });
        Ok(self.all.len() as u32 - 1)
    }

    /// Moves the vertices of an instance, in its own space.
    ///
    /// # Panics
    /// If there is no such instance, or it has more or fewer vertices.
    pub fn update(&mut self, instance: u32, vertices: &[Vec3]) {
        let Instance { vertices: range, placed, origin, .. } = &mut self.all[instance as usize];
        let world = &mut self.positions[range.clone()];
        match placed {
            None => world.copy_from_slice(vertices),
            Some(placed) => {
                placed.vertices.copy_from_slice(vertices);
                placed.apply(*origin, world);
            }
        }
    }

    /// Replaces an instance's transform to the world: positions are computed in f64 and rounded to f32 once.
    ///
    /// # Panics
    /// If there is no such instance.
    pub fn set_transform(&mut self, instance: u32, world_from_object: DAffine3) {
        let Instance { vertices, placed, origin, .. } = &mut self.all[instance as usize];
        let world = &mut self.positions[vertices.clone()];
        let placed = placed.get_or_insert_with(|| Placed { world_from_object, vertices: world.to_vec() });
        placed.world_from_object = world_from_object;
        placed.apply(*origin, world);
    }

    /// All instances; an id is an index.
    #[must_use]
    pub fn all(&self) -> &[Instance] {
        &self.all
    }

    /// The vertices of an instance in its own space, and its triangles, as indices of these.
    ///
    /// # Panics
    /// If there is no such instance.
    pub fn mesh(&self, instance: u32) -> (&[Vec3], impl ExactSizeIterator<Item = [u32; 3]>) {
        let Instance { vertices, triangles, placed, .. } = &self.all[instance as usize];
        let own = placed.as_ref().map_or(&self.positions[vertices.clone()], |placed| &placed.vertices);
        let first = vertices.start as u32;
        (own, self.indices[triangles.clone()].iter().map(move |corners| corners.map(|corner| corner - first)))
    }

    /// The triangles of all instances in world space, from [`origin`](Self::origin), those of the first one first.
    #[must_use]
    pub fn triangles(&self) -> Triangles<'_> {
        Triangles { positions: &self.positions, indices: &self.indices }
    }

    /// The instance of a triangle, given by its id among all, and the triangle's number within the instance.
    ///
    /// # Panics
    /// If there is no such triangle.
    #[must_use]
    pub fn of_triangle(&self, triangle: u32) -> [u32; 2] {
        let id = triangle as usize;
        // Instances without triangles have empty ranges.
        let instance = self.all.partition_point(|instance| instance.triangles.end <= id);
        [instance as u32, (id - self.all[instance].triangles.start) as u32]
    }

    /// Converts a hit among [triangles](Self::triangles) to the instance and the position in its own space.
    ///
    /// # Panics
    /// If there is no such triangle.
    #[must_use]
    pub fn hit(&self, hit: &Hit) -> InstanceHit {
        let [instance, triangle] = self.of_triangle(hit.triangle);
        let Instance { vertices, placed, .. } = &self.all[instance as usize];
        let [a, b, c] = self.indices[hit.triangle as usize].map(|vertex| {
            let vertex = vertex as usize;
            placed.as_ref().map_or(self.positions[vertex], |placed| placed.vertices[vertex - vertices.start]).as_dvec3()
        });
        let [u, v] = hit.barycentric.map(f64::from);
        InstanceHit { instance, triangle, position: a * (1.0 - u - v) + b * u + c * v }
    }
}

/// Key by which consecutive triangles form an instance: the index of their object's name, and that of their rigid matrix.
#[derive(Clone, Copy, PartialEq)]
struct Object {
    name: Option<u32>,
    matrix: Option<u32>,
}

impl Object {
    fn of(frame: &Frame, posed: Option<(&Rig, &Pose)>, triangle: usize) -> Self {
        let matrix = posed.and_then(|(rig, _)| {
            let part = &rig.parts[part_of(rig, frame.mesh.triangles[triangle][0])];
            match part.placement {
                Placement::Rigid { matrix } if rig.shapes[part.shape as usize].morph_targets.is_empty() => Some(matrix),
                _ => None,
            }
        });
        Self { name: frame.mesh.objects.of_triangle(triangle as u32), matrix }
    }
}

/// The part of a vertex; parts have no gaps.
fn part_of(rig: &Rig, vertex: u32) -> usize {
    rig.parts.partition_point(|part| part.first_vertex <= vertex) - 1
}

/// New numbers for the vertices of one instance after the other.
struct Numbers {
    /// The last instance that has the vertex, and its number there.
    of_vertex: Vec<(u32, u32)>,
    /// The vertices of this instance.
    taken: Vec<u32>,
}

impl Numbers {
    fn of(&mut self, vertex: u32, instance: u32) -> u32 {
        let (last, number) = &mut self.of_vertex[vertex as usize];
        if *last != instance {
            (*last, *number) = (instance, self.taken.len() as u32);
            self.taken.push(vertex);
        }
        *number
    }
}
