//! Curved rectangles: the shape behind most others.

use glam::{Vec2, Vec3};
use rayon::prelude::*;
use umbrage_rays::parallel::Parallel;

use super::MeshBuilder;

/// A rectangle of `columns` × `rows` quads, each two triangles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sheet {
    /// Quads along u, above zero.
    pub(crate) columns: u32,
    /// Quads along v, above zero.
    pub(crate) rows: u32,
    /// Relation of the edges at u = 0 and u = 1.
    pub(crate) across: Join,
    /// Relation of the edges at v = 0 and v = 1.
    pub(crate) along: Join,
}

/// Relation of two opposite edges of a sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Join {
    /// Apart.
    Open,
    /// The same line: the surface goes on smoothly across it.
    Joined,
}

impl Sheet {
    /// A sheet whose edges are all apart.
    pub(crate) fn open(columns: u32, rows: u32) -> Self {
        Self { columns: columns.max(1), rows: rows.max(1), across: Join::Open, along: Join::Open }
    }

    /// A sheet bent to a tube, u going around it.
    pub(crate) fn tube(columns: u32, rows: u32) -> Self {
        Self { columns: columns.max(3), rows: rows.max(1), across: Join::Joined, along: Join::Open }
    }

    /// A sheet bent to a ring, u going around the short way and v the long way.
    pub(crate) fn ring(columns: u32, rows: u32) -> Self {
        Self { columns: columns.max(3), rows: rows.max(3), across: Join::Joined, along: Join::Joined }
    }

    /// An open sheet of about `triangles` triangles whose columns are to its rows as `aspect` to 1.
    pub(crate) fn of_triangles(triangles: usize, aspect: f32) -> Self {
        let quads = (triangles as f32 * 0.5).max(1.0);
        let columns = (quads * aspect).sqrt().round().max(1.0);
        Self::open(columns as u32, (quads / columns).round() as u32)
    }

    /// Vertices of the sheet: the joined edges have theirs twice, for the sake of texture coordinates.
    pub(crate) fn vertices(&self) -> usize {
        (self.columns as usize + 1) * (self.rows as usize + 1)
    }

    /// Position of vertex `index` on the sheet: u and v from 0 to 1, and exactly 0 at the far end of a joined edge.
    pub(crate) fn coords(&self, index: usize) -> Vec2 {
        let stride = self.columns as usize + 1;
        let part = |at: usize, count: u32, join: Join| {
            if join == Join::Joined && at == count as usize { 0.0 } else { at as f32 / count as f32 }
        };
        Vec2::new(part(index % stride, self.columns, self.across), part(index / stride, self.rows, self.along))
    }

    /// The two triangles of each quad, counting vertices from 0; ∂u × ∂v is their outer side.
    pub(crate) fn triangles(&self) -> impl Iterator<Item = [u32; 3]> {
        let stride = self.columns + 1;
        let columns = self.columns;
        (0..self.rows).flat_map(move |row| (0..columns).map(move |column| row * stride + column)).flat_map(
            move |corner| [[corner, corner + 1, corner + stride + 1], [corner, corner + stride + 1, corner + stride]],
        )
    }

    /// The smooth unit normals of a sheet with `positions`: each vertex's quads count by their area.
    ///
    /// A row that is only a point, like a sphere's pole, has one normal. The slices hold [`Sheet::vertices`].
    pub(crate) fn write_normals(&self, positions: &[Vec3], normals: &mut [Vec3]) {
        let stride = self.columns as usize + 1;
        let rows = self.rows as usize;
        // Twice the area of the quad at (column, row), along its normal.
        let quad = |column: usize, row: usize| {
            let at = row * stride + column;
            let [a, b, c, d] = [at, at + 1, at + stride, at + stride + 1].map(|vertex| positions[vertex]);
            (d - a).cross(c - b)
        };
        // The quads before and after a line, across the join if there is one.
        let beside = |line: usize, count: usize, join: Join| {
            let around = join == Join::Joined && (line == 0 || line == count);
            let before = if around { Some(count - 1) } else { line.checked_sub(1) };
            let after = if around { Some(0) } else { Some(line).filter(|&line| line < count) };
            [before, after].into_iter().flatten()
        };
        normals.par_chunks_mut(stride).enumerate().each(|(row, normals)| {
            for (column, normal) in normals.iter_mut().enumerate() {
                let quads = beside(row, rows, self.along)
                    .flat_map(|row| beside(column, stride - 1, self.across).map(move |column| (column, row)));
                *normal = quads.map(|(column, row)| quad(column, row)).sum();
            }
            let line = &positions[row * stride..][..stride];
            if line.iter().all(|position| *position == line[0]) {
                let pole = normals[1..].iter().sum::<Vec3>();
                normals.fill(pole);
            }
            for normal in normals {
                // Lengths may be tiny for fine sheets: scale up first, so that squares don't vanish.
                *normal = (*normal / normal.abs().max_element().max(f32::MIN_POSITIVE)).normalize_or_zero();
            }
        });
    }
}

impl MeshBuilder {
    /// Adds a smooth sheet whose point at (u, v), each 0 … 1, is `position`; ∂u × ∂v is its outer side.
    ///
    /// Texture coordinates are (u, 1 − v). Triangles with two equal corners are left out.
    pub(crate) fn sheet(&mut self, sheet: Sheet, position: impl Fn(f32, f32) -> Vec3 + Sync) -> &mut Self {
        self.any_sheet(sheet, &position)
    }

    /// Adds a [`sheet`](Self::sheet): compiled once, not for each shape.
    fn any_sheet(&mut self, sheet: Sheet, position: &(dyn Fn(f32, f32) -> Vec3 + Sync)) -> &mut Self {
        let first = self.positions.len();
        let positions: Vec<Vec3> = (0..sheet.vertices())
            .into_par_iter()
            .map(|index| {
                let at = sheet.coords(index);
                position(at.x, at.y)
            })
            .collect();
        let mut normals = vec![Vec3::ZERO; positions.len()];
        sheet.write_normals(&positions, &mut normals);
        let stride = sheet.columns as usize + 1;
        for (index, (&position, &normal)) in positions.iter().zip(&normals).enumerate() {
            let u = (index % stride) as f32 / sheet.columns as f32;
            let v = (index / stride) as f32 / sheet.rows as f32;
            self.vertex(position, normal, Vec2::new(u, 1.0 - v));
        }
        let is_there = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|vertex| positions[vertex as usize]);
            a != b && b != c && c != a
        };
        self.triangles_from(first, sheet.triangles().filter(is_there));
        self
    }
}
