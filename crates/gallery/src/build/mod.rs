//! Building blocks of the demos: meshes from simple shapes, random numbers, noise, textures and materials.

mod balls;
pub(crate) mod math;
mod paint;
mod random;
mod shapes;
mod sheet;

use std::sync::Arc;

use glam::{Affine3A, Mat3A, Vec2, Vec3, Vec4};

use umbrage_scene::{Frame, Material, Materials, Mesh, Objects};

pub(crate) use balls::{ball_triangles, fineness_of_balls};
pub(crate) use paint::{Paint, checker, color_texture, mottled_texture, srgb};
pub(crate) use random::{Random, fractal_noise, hash, noise};
pub(crate) use shapes::on_sphere;
pub(crate) use sheet::{Join, Sheet};

/// A mesh that grows shape by shape.
///
/// Shapes take the material and the tint that were set last. Triangles run counterclockwise seen from outside.
#[derive(Clone, Debug)]
pub(crate) struct MeshBuilder {
    /// Position of each vertex.
    pub(crate) positions: Vec<Vec3>,
    /// Unit normal of each vertex, or zero if the surface is flat.
    pub(crate) normals: Vec<Vec3>,
    /// Texture coordinates of each vertex.
    pub(crate) tex_coords: Vec<Vec2>,
    /// Three vertices for each triangle.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Material of each triangle.
    pub(crate) material_of_triangle: Vec<u32>,
    /// Tint of each vertex; empty while all are white.
    colors: Vec<Vec4>,
    /// Materials of the mesh so far.
    stuff: Vec<Stuff>,
    /// The first triangle of each part but the first, and the part's number in the frame.
    parts: Vec<(usize, u32)>,
    material: u32,
    tint: Vec3,
}

/// A material of the finished mesh.
#[derive(Clone, Debug)]
enum Stuff {
    Paint(Paint),
    Made(Box<Material>),
}

impl MeshBuilder {
    /// An empty mesh without a material or a tint.
    pub(crate) fn new() -> Self {
        Self {
            positions: Vec::new(),
            normals: Vec::new(),
            tex_coords: Vec::new(),
            triangles: Vec::new(),
            material_of_triangle: Vec::new(),
            colors: Vec::new(),
            stuff: Vec::new(),
            parts: Vec::new(),
            material: 0,
            tint: Vec3::ONE,
        }
    }

    /// Begins a part that moves by itself.
    pub(crate) fn part(&mut self) -> &mut Self {
        let last = self.parts.iter().map(|(_, part)| *part).max().unwrap_or(0);
        self.parts.push((self.triangles.len(), last + 1));
        self
    }

    /// Begins triangles that don't move, like those before the first [`part`](Self::part).
    pub(crate) fn still(&mut self) -> &mut Self {
        self.parts.push((self.triangles.len(), 0));
        self
    }

    /// Sets `paint`, without a tint, for the next shapes.
    pub(crate) fn paint(&mut self, paint: Paint) -> &mut Self {
        self.material = self.index_of(&Stuff::Paint(paint));
        self.tint = Vec3::ONE;
        self
    }

    /// Sets a material of its own, without a tint, for the next shapes.
    pub(crate) fn material(&mut self, material: Material) -> &mut Self {
        self.material = self.index_of(&Stuff::Made(Box::new(material)));
        self.tint = Vec3::ONE;
        self
    }

    /// The index of a material, which is added if it is new.
    fn index_of(&mut self, stuff: &Stuff) -> u32 {
        let is_same = |known: &Stuff| match (known, stuff) {
            (Stuff::Paint(known), Stuff::Paint(paint)) => known.name == paint.name,
            _ => false,
        };
        let index = self.stuff.iter().position(is_same).unwrap_or(self.stuff.len());
        if index == self.stuff.len() {
            self.stuff.push(stuff.clone());
        }
        index as u32
    }

    /// Sets a linear colour that multiplies the material's for the next shapes.
    pub(crate) fn tint(&mut self, tint: Vec3) -> &mut Self {
        self.tint = tint;
        self
    }

    /// Gives the existing vertex `index` the linear tint `tint`.
    pub(crate) fn tint_vertex(&mut self, index: usize, tint: Vec3) {
        self.colors.resize(self.positions.len(), Vec4::ONE);
        self.colors[index] = tint.extend(1.0);
    }

    /// Adds a vertex and returns its index. `normal` is of unit length, or zero for flat surfaces.
    pub(crate) fn vertex(&mut self, position: Vec3, normal: Vec3, tex_coords: Vec2) -> u32 {
        let index = self.positions.len();
        if self.tint != Vec3::ONE || !self.colors.is_empty() {
            self.colors.resize(index, Vec4::ONE);
            self.colors.push(self.tint.extend(1.0));
        }
        self.positions.push(position);
        self.normals.push(normal);
        self.tex_coords.push(tex_coords);
        index as u32
    }

    /// Adds a triangle between existing vertices.
    pub(crate) fn triangle(&mut self, vertices: [u32; 3]) {
        self.triangles.push(vertices);
        self.material_of_triangle.push(self.material);
    }

    /// Adds triangles between the vertices from `first` on.
    pub(crate) fn triangles_from(&mut self, first: usize, triangles: impl IntoIterator<Item = [u32; 3]>) {
        for triangle in triangles {
            self.triangle(triangle.map(|vertex| vertex + first as u32));
        }
    }

    /// Adds the shapes of `make`, moved from their own space into this one.
    pub(crate) fn place(&mut self, world_from_part: Affine3A, make: impl FnOnce(&mut Self)) -> &mut Self {
        let first = self.positions.len();
        make(self);
        self.move_from(first, world_from_part);
        self
    }

    /// Moves the vertices from `first` on into another space.
    fn move_from(&mut self, first: usize, world_from_part: Affine3A) {
        let normals = normals_matrix(world_from_part);
        for position in &mut self.positions[first..] {
            *position = world_from_part.transform_point3(*position);
        }
        for normal in &mut self.normals[first..] {
            *normal = (normals * *normal).normalize_or_zero();
        }
    }

    /// Gives the vertices from `first` on texture coordinates that follow from their positions.
    pub(crate) fn wrap(&mut self, first: usize, coords: impl Fn(Vec3) -> Vec2) {
        for (position, own) in self.positions[first..].iter().zip(&mut self.tex_coords[first..]) {
            *own = coords(*position);
        }
    }

    /// Adds a copy of `part`, in its own materials and tints, moved from its space into this one.
    pub(crate) fn instance(&mut self, part: &Self, world_from_part: Affine3A) -> &mut Self {
        let first = self.positions.len();
        let normals = normals_matrix(world_from_part);
        if !part.colors.is_empty() || !self.colors.is_empty() {
            self.colors.resize(first, Vec4::ONE);
            self.colors.extend_from_slice(&part.colors);
            self.colors.resize(first + part.positions.len(), Vec4::ONE);
        }
        self.positions.extend(part.positions.iter().map(|&position| world_from_part.transform_point3(position)));
        self.normals.extend(part.normals.iter().map(|&normal| (normals * normal).normalize_or_zero()));
        self.tex_coords.extend_from_slice(&part.tex_coords);
        self.triangles.extend(part.triangles.iter().map(|triangle| triangle.map(|vertex| vertex + first as u32)));
        let own: Vec<u32> = part.stuff.iter().map(|stuff| self.index_of(stuff)).collect();
        self.material_of_triangle.extend(part.material_of_triangle.iter().map(|&material| own[material as usize]));
        self
    }

    /// The finished mesh with its materials.
    pub(crate) fn finish(mut self) -> Frame {
        let mut materials = Materials::default();
        for stuff in self.stuff {
            let material = match stuff {
                Stuff::Paint(paint) => paint.material(&mut materials.textures),
                Stuff::Made(material) => *material,
            };
            materials.materials.push(material);
        }
        if !self.colors.is_empty() {
            self.colors.resize(self.positions.len(), Vec4::ONE);
        }
        let mut part_of_triangle = Vec::new();
        if !self.parts.is_empty() {
            let ends = self.parts.iter().map(|(first, _)| *first).chain([self.triangles.len()]);
            let parts = [0].into_iter().chain(self.parts.iter().map(|(_, part)| *part));
            parts.zip(ends).for_each(|(part, end)| part_of_triangle.resize(end, part));
        }
        let objects = objects(&materials.materials, &self.material_of_triangle, &part_of_triangle);
        let mesh = Mesh {
            objects,
            triangles: self.triangles,
            part_of_triangle,
            material_of_triangle: self.material_of_triangle,
            tex_coords: [self.tex_coords, Vec::new()],
            colors: self.colors,
            ..Mesh::default()
        };
        Frame {
            positions: self.positions,
            normals: self.normals,
            mesh: Arc::new(mesh),
            materials: Arc::new(materials),
            ..Frame::default()
        }
    }
}

/// Objects of a frame: the triangles of one material in a part, named by the material and the part's number.
fn objects(materials: &[Material], material_of_triangle: &[u32], part_of_triangle: &[u32]) -> Objects {
    let mut objects = Objects::default();
    let mut last = None;
    for (triangle, &material) in material_of_triangle.iter().enumerate() {
        let part = part_of_triangle.get(triangle).copied().unwrap_or(0);
        if last.replace((material, part)) != Some((material, part)) {
            let name = &materials[material as usize].name;
            match part {
                0 => objects.begin(triangle, name),
                part => objects.begin(triangle, &format!("{name} {part}")),
            }
        }
    }
    objects
}

/// Matrix for normals where `world_from_part` moves surfaces; it doesn't keep their length.
fn normals_matrix(world_from_part: Affine3A) -> Mat3A {
    world_from_part.matrix3.inverse().transpose()
}

/// Fineness of a scene, relative to its usual number of triangles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Detail {
    /// Factor on the number of quads along a line.
    scale: f32,
}

impl Detail {
    /// The detail at which a scene that usually has `usual` triangles has `triangles`.
    pub(crate) fn for_triangles(triangles: usize, usual: usize) -> Self {
        Self { scale: (triangles as f32 / usual as f32).sqrt() }
    }

    /// Quads along a line that usually has `usual`, at least `least`.
    pub(crate) fn quads(self, usual: u32, least: u32) -> u32 {
        ((usual as f32 * self.scale).round() as u32).max(least)
    }

    /// Number of small things, usually `usual`: fewer in a coarse scene, no more in a fine one.
    pub(crate) fn things(self, usual: u32) -> u32 {
        ((usual as f32 * (self.scale * self.scale).min(1.0)).round() as u32).min(usual)
    }

    /// Whether ornaments are worth their triangles.
    pub(crate) fn is_ornate(self) -> bool {
        const PLAIN: f32 = 0.12;
        self.scale > PLAIN
    }

    /// Makes a part with this detail, or less until it has no more than `limit` triangles or can't be coarser.
    pub(crate) fn within<T>(mut self, limit: usize, make: impl Fn(Self) -> T, triangles: impl Fn(&T) -> usize) -> T {
        const COARSEST: f32 = 0.01;
        let mut part = make(self);
        while triangles(&part) > limit && self.scale > COARSEST {
            self.scale *= 0.8;
            part = make(self);
        }
        part
    }
}
