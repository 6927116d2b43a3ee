use std::ops::Range;
use std::sync::Arc;

use glam::{Vec2, Vec3, Vec4};
use rayon::prelude::*;
use umbrage_rays::{Bounds, Camera, Parts, Triangles};

use crate::{Light, Marks, Material, Materials, Objects, Texture};

/// A scene at one moment: triangles in world space, materials, lights and cameras.
///
/// Keep one `Frame` and pose it again with [`Scene::pose`](crate::Scene::pose): its memory is reused. Triangles of your own
/// become one with [`Frame::from_triangles`].
#[derive(Clone, Debug, Default)]
pub struct Frame {
    /// The moment.
    pub seconds: f64,
    /// The point of the world that all coordinates count from ([`Scene::origin`](crate::Scene::origin)).
    pub origin: [f64; 3],
    /// World position of each vertex, from `origin`.
    pub positions: Vec<Vec3>,
    /// Unit normal of each vertex, or zero where the surface is flat. Empty when all of it is.
    pub normals: Vec<Vec3>,
    /// Unit tangent of each vertex and, in w, the sign of its bitangent; zero where the surface has no normal map. Empty
    /// when all are zero: a normal map then follows the texture coordinates of each triangle.
    pub tangents: Vec<Vec4>,
    /// Triangles between the vertices, and their other attributes.
    pub mesh: Arc<Mesh>,
    /// Materials, indexed by [`Mesh::material_of_triangle`].
    pub materials: Arc<Materials>,
    /// The lights; when the file has none, one that is made ([`Scene::made_light`](crate::Scene::made_light)).
    pub lights: Vec<Light>,
    /// Whether the light is one that was made.
    pub light_is_made: bool,
    /// The file's cameras; may be empty, see [`Frame::camera`].
    pub cameras: Vec<NamedCamera>,
    /// A box around the scene over the whole animation, as far as it is known without posing every moment. Empty if
    /// unknown: a made camera then frames the frame's own triangles.
    pub animation_bounds: Bounds,
}

/// The part of a frame that usually stays the same from frame to frame.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Three vertices for each triangle, all in range.
    pub triangles: Vec<[u32; 3]>,
    /// Index of each triangle's material in [`Materials::materials`], in range.
    pub material_of_triangle: Vec<u32>,
    /// The part of each triangle, for [`Parts`]: all motionless triangles are one part, and so are those of one animated
    /// node, or those that mostly follow one joint of a skin. Empty where that isn't known.
    pub part_of_triangle: Vec<u32>,
    /// The object of each part, for [`Parts`]: parts of one skin are of one object. Empty where each part is an object.
    pub object_of_part: Vec<u32>,
    /// Two sets of texture coordinates for each vertex, (0, 0) being the image's upper left corner. An unused set is
    /// empty.
    pub tex_coords: [Vec<Vec2>; 2],
    /// Linear colour and opacity of each vertex, which multiply the material's. Empty when all are white.
    pub colors: Vec<Vec4>,
    /// The names of objects, for layers of pictures; empty where all triangles are one without a name.
    pub objects: Objects,
    /// Number of triangles, at the end, of a [`Ground`](crate::Ground) under the scene.
    pub ground_triangles: usize,
    /// Points and lines.
    pub marks: Marks,
}

impl Mesh {
    /// The same vertices with the triangles of `runs`, in rising order, each of one object, and the points and lines that
    /// `shows_marks` accepts, given the number of each run of these and its object.
    #[must_use]
    pub fn with_only(
        &self,
        runs: impl Iterator<Item = Range<usize>>,
        shows_marks: impl Fn(usize, Option<u32>) -> bool,
    ) -> Self {
        let nothing = (Vec::new(), Vec::new(), Vec::new());
        let (triangles, material_of_triangle, part_of_triangle) = nothing;
        let (objects, marks) = (self.objects.without_triangles(), self.marks.only(shows_marks));
        let mut mesh = Self { triangles, material_of_triangle, part_of_triangle, objects, marks, ..self.clone() };
        for run in runs {
            if let Some(object) = self.objects.of_triangle(run.start as u32) {
                mesh.objects.begin(mesh.triangles.len(), &self.objects.names()[object as usize]);
            }
            mesh.triangles.extend_from_slice(&self.triangles[run.clone()]);
            mesh.material_of_triangle.extend_from_slice(&self.material_of_triangle[run.clone()]);
            mesh.part_of_triangle.extend(self.part_of_triangle.get(run).into_iter().flatten());
        }
        mesh
    }
}

/// A camera that came with a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedCamera {
    /// Its name in the file; may be empty.
    pub name: Arc<str>,
    /// The camera at the frame's moment.
    pub camera: Camera,
}

impl Frame {
    /// Triangles in world space, each of three indices into `positions`: flat, in [clay](Material::clay), without lights and
    /// cameras.
    ///
    /// All fields may be changed; [`Frame::check`] validates the result.
    #[must_use]
    pub fn from_triangles(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Self {
        let material_of_triangle = vec![0; triangles.len()];
        let materials = Materials { materials: vec![Material::clay()], textures: Vec::new() };
        Self {
            positions,
            mesh: Arc::new(Mesh { triangles, material_of_triangle, ..Mesh::default() }),
            materials: Arc::new(materials),
            ..Self::default()
        }
    }

    /// Takes the vertices, mesh and materials of `other`, in its own memory. All else stays.
    pub fn copy_surfaces(&mut self, other: &Self) {
        self.positions.clone_from(&other.positions);
        self.normals.clone_from(&other.normals);
        self.tangents.clone_from(&other.tangents);
        self.mesh.clone_from(&other.mesh);
        self.materials.clone_from(&other.materials);
    }

    /// The frame's triangles, for building structures.
    #[must_use]
    pub fn triangles(&self) -> Triangles<'_> {
        Triangles { positions: &self.positions, indices: &self.mesh.triangles }
    }

    /// A box around all visible content: triangles that rays can hit, points and lines.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        self.triangles().bounds().union(Bounds::of_points(self.mark_positions()))
    }

    /// Positions of points and of lines' ends, if finite.
    fn mark_positions(&self) -> impl Iterator<Item = Vec3> + Clone + '_ {
        let vertices = self.mesh.marks.vertices();
        vertices
            .filter_map(|vertex| self.positions.get(vertex as usize).copied().filter(|position| position.is_finite()))
    }

    /// Groups of triangles that move together, as far as is known.
    #[must_use]
    pub fn parts(&self) -> Parts<'_> {
        Parts { of_triangle: &self.mesh.part_of_triangle, objects: &self.mesh.object_of_part }
    }

    /// Bytes held by vertices, triangles and textures.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let mesh = &*self.mesh;
        size_of_val(self.positions.as_slice())
            + size_of_val(self.normals.as_slice())
            + size_of_val(self.tangents.as_slice())
            + size_of_val(mesh.triangles.as_slice())
            + size_of_val(mesh.material_of_triangle.as_slice())
            + size_of_val(mesh.part_of_triangle.as_slice())
            + mesh.tex_coords.iter().map(|coords| size_of_val(coords.as_slice())).sum::<usize>()
            + size_of_val(mesh.colors.as_slice())
            + mesh.marks.bytes()
            + self.materials.textures.iter().map(Texture::bytes).sum::<usize>()
            + self.materials.texture_traffic().map_or(0, |traffic| traffic.resident_bytes as usize)
    }

    /// The file's first camera, or else one that sees the whole scene over the whole animation, for an image of
    /// `aspect` (width over height).
    #[must_use]
    pub fn camera(&self, aspect: f32) -> Camera {
        self.cameras.first().map_or_else(|| self.framing_camera(aspect), |named| named.camera)
    }

    /// A camera that sees the whole scene from the front, one side and a little above, in an image of `aspect` (width
    /// over height).
    #[must_use]
    pub fn framing_camera(&self, aspect: f32) -> Camera {
        const FORWARD: Vec3 = Vec3::new(-0.5, -0.3, -1.0);
        const VERTICAL_FOV_RADIANS: f32 = 0.7;
        // Without a ground: it reaches far beyond.
        let indices = &self.mesh.triangles[..self.mesh.triangles.len().saturating_sub(self.mesh.ground_triangles)];
        let triangles = Triangles { indices, ..self.triangles() };
        let bounds = triangles.bounds().union(Bounds::of_points(self.mark_positions()));
        if self.animation_bounds.is_empty() || bounds == self.animation_bounds {
            // Nothing moves, as far as is known: the triangles themselves make a tighter view than their box.
            let vertices = indices.as_flattened().par_iter();
            let corners = vertices.filter_map(|&vertex| self.positions.get(vertex as usize).copied());
            let marks: Vec<Vec3> = self.mark_positions().collect();
            Camera::framing(corners.chain(marks), FORWARD, aspect, VERTICAL_FOV_RADIANS)
        } else {
            Camera::framing(self.animation_bounds.corners(), FORWARD, aspect, VERTICAL_FOV_RADIANS)
        }
    }
}
