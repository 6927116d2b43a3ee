use std::collections::{BTreeSet, HashMap};
use std::path::PathBuf;
use std::sync::Arc;

use glam::{DVec3, Vec2, Vec3, Vec4};
use umbrage_scene::{Animated, Error, Frame, Material, Materials, Mesh};

use crate::memory::Budget;

/// The result of reading a motionless file.
#[derive(Clone, Debug, Default)]
pub(crate) struct Still {
    /// Without lights and cameras.
    pub(crate) frame: Frame,
    /// Messages for users about content that the reader left out or guessed.
    pub(crate) warnings: Vec<String>,
    /// Origin of the frame's coordinates in the world.
    pub(crate) origin: DVec3,
    /// The files that were read.
    pub(crate) files: BTreeSet<PathBuf>,
}

/// Attributes of a frame's vertices; lists that the file doesn't fill are empty.
#[derive(Debug, Default)]
pub(crate) struct Vertices {
    pub(crate) positions: Vec<Vec3>,
    pub(crate) normals: Vec<Vec3>,
    pub(crate) tex_coords: Vec<Vec2>,
    /// Linear.
    pub(crate) colors: Vec<Vec4>,
}

impl Vertices {
    /// Gives each triangle the linear colour of the same index, or none where there are no `colors`. Vertices between triangles
    /// of different colours are copied.
    ///
    /// # Errors
    /// Where there is no memory for it, or there are more vertices than a 32-bit index counts.
    fn color_triangles(&mut self, triangles: &mut [[u32; 3]], colors: &[Vec4], budget: &Budget) -> Result<(), String> {
        if colors.is_empty() {
            return Ok(());
        }
        let bits = |color: Vec4| color.to_array().map(f32::to_bits);
        let mut copies: HashMap<(u32, [u32; 4]), u32> = HashMap::new();
        let vertices = self.positions.len();
        let mut is_colored = Vec::new();
        budget.reserve(&mut is_colored, vertices, "vertices' colours")?;
        is_colored.resize(vertices, false);
        self.colors.clear();
        budget.reserve(&mut self.colors, vertices, "vertices' colours")?;
        self.colors.resize(vertices, Vec4::ONE);
        let corners = triangles.iter_mut().zip(colors);
        for (vertex, &color) in
            corners.flat_map(|(corners, color)| corners.iter_mut().map(move |vertex| (vertex, color)))
        {
            let old = *vertex as usize;
            if !std::mem::replace(&mut is_colored[old], true) {
                self.colors[old] = color;
            } else if bits(self.colors[old]) != bits(color) {
                budget.reserve_map(&mut copies, 1, "vertices")?;
                let next =
                    u32::try_from(self.positions.len()).map_err(|_| "more vertices than a 32-bit index counts")?;
                *vertex = *copies.entry((*vertex, bits(color))).or_insert(next);
                if *vertex == next {
                    budget.reserve(&mut self.colors, 1, "vertices' colours")?;
                    self.colors.push(color);
                    add_copy(&mut self.positions, old, budget)?;
                    add_copy(&mut self.normals, old, budget)?;
                    add_copy(&mut self.tex_coords, old, budget)?;
                }
            }
        }
        Ok(())
    }

    /// Makes a frame of one material without lights and cameras: clay, or the vertices' own colours, or else those of the
    /// triangles.
    ///
    /// # Errors
    /// As [`Vertices::color_triangles`].
    pub(crate) fn into_plain_frame(
        mut self,
        mut triangles: Vec<[u32; 3]>,
        triangle_colors: &[Vec4],
        budget: &Budget,
    ) -> Result<Frame, String> {
        if self.colors.is_empty() {
            self.color_triangles(&mut triangles, triangle_colors, budget)?;
        }
        let material = if self.colors.is_empty() {
            Material::clay()
        } else {
            // The only colours are the vertices' or the triangles' own.
            Material { double_sided: true, ..Material::default() }
        };
        let materials = Arc::new(Materials { materials: vec![material], textures: Vec::new() });
        budget.take_for::<u32>(triangles.len(), "triangles' materials")?;
        let material_of_triangle = vec![0; triangles.len()];
        Ok(self.into_frame(triangles, material_of_triangle, materials))
    }

    /// Makes a frame of triangles between these vertices, without lights and cameras.
    pub(crate) fn into_frame(
        self,
        triangles: Vec<[u32; 3]>,
        material_of_triangle: Vec<u32>,
        materials: Arc<Materials>,
    ) -> Frame {
        let Self { positions, normals, tex_coords, colors } = self;
        let mesh =
            Mesh { triangles, material_of_triangle, tex_coords: [tex_coords, Vec::new()], colors, ..Mesh::default() };
        Frame { positions, normals, mesh: Arc::new(mesh), materials, ..Frame::default() }
    }
}

/// Adds a copy of element `index` to a list that isn't empty.
fn add_copy<T: Copy>(list: &mut Vec<T>, index: usize, budget: &Budget) -> Result<(), String> {
    if let Some(&value) = list.get(index) {
        budget.reserve(list, 1, "vertices")?;
        list.push(value);
    }
    Ok(())
}

impl Animated for Still {
    fn duration_seconds(&self) -> f64 {
        0.0
    }

    fn pose(&self, _seconds: f64, frame: &mut Frame) -> Result<(), Error> {
        frame.copy_surfaces(&self.frame);
        Ok(())
    }

    fn origin(&self) -> [f64; 3] {
        self.origin.into()
    }

    fn warnings(&self) -> &[String] {
        &self.warnings
    }
}
