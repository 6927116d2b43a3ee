//! The light buffer (Haines and Greenberg, *The Light Buffer: A Shadow-Testing Accelerator*, 1986; the thesis' §2.3): a
//! cube around a point light whose cells list the triangles seen through them, the nearest first.

use std::ops::ControlFlow;

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use umbrage_rays::{Ray, Triangles};

use crate::single::{Visit, answers_single_rays};

/// The triangles around a light, listed by direction. [Rays](Visit) must start at the light, as its shadow rays do.
///
/// **Completeness.** Positions relative to the light have an error of one rounding each. Cells are grown by `MARGIN`,
/// and a triangle is left out of a cell only if all of its corners are beyond one of the cell's sides by more than
/// `ROUNDINGS` of the scene's reach. Points so near to the light that their direction may be wrong by a tenth of the
/// margin are compared with all triangles.
///
/// A triangle hidden behind a covering one is behind it for the predicate too, for points that are known to within 10⁻⁸
/// of the reach: all hits of rays that start no farther away than 10⁶ times the reach.
#[derive(Debug)]
pub struct LightBuffer {
    light: DVec3,
    /// Cells along an edge of the cube.
    side: u32,
    /// Largest magnitude of a coordinate.
    reach: f64,
    /// Index of each cell's first entry, and the end of the last cell.
    starts: Vec<u32>,
    entries: Vec<Entry>,
    /// Number of entries left out because a nearer triangle covers their cell.
    hidden: usize,
    triangle_count: u32,
}

/// A triangle in a cell.
#[derive(Clone, Copy, Debug)]
struct Entry {
    cell: u32,
    id: u32,
    /// Lower bound on its distance, along the axis of the cube's face.
    near: f64,
}

/// Margin of cells, in halves of the cube's edge.
const MARGIN: f64 = 1e-5;

/// Rounding error of a position relative to the light, in units of the reach.
const ROUNDINGS: f64 = 1.0 / (1_u64 << 48) as f64;

/// Relative distance behind a covering triangle from which on triangles are hidden.
const BEHIND: f64 = 1e-4;

impl LightBuffer {
    /// Lists `triangles` around a point light, on all threads. `is_opaque` tells which of them let no light through
    /// anywhere: only these hide others.
    ///
    /// # Panics
    /// If `side`, cells along an edge of the cube, isn't from 1 to 4096.
    #[must_use]
    pub fn new(triangles: Triangles<'_>, light: Vec3, side: u32, is_opaque: &(dyn Fn(u32) -> bool + Sync)) -> Self {
        assert!((1..=4096).contains(&side), "{side} cells");
        let light = light.as_dvec3();
        let usable: Vec<u32> = (0..triangles.len() as u32).filter(|&id| triangles.usable_corners(id).is_ok()).collect();
        let corners = usable.iter().flat_map(|&id| triangles.corners(id));
        let far = corners.fold(0.0_f64, |far, corner| far.max(corner.as_dvec3().abs().max_element()));
        let reach = far.max(light.abs().max_element());
        let listed = usable.par_iter().map(|&id| {
            let corners = triangles.corners(id).map(|corner| corner.as_dvec3() - light);
            let mut found = Vec::new();
            for face in 0..6 {
                let corners = corners.map(|corner| on_face(face, corner));
                let near = corners.iter().fold(f64::INFINITY, |near, corner| near.min(corner.z)) - ROUNDINGS * reach;
                let listing = Listing { side, corners, slack: 2.0 * ROUNDINGS * reach };
                listing.descend([[0, side]; 2], &mut |[column, row]| {
                    found.push(Entry { cell: (face * side + row) * side + column, id, near });
                });
            }
            found
        });
        let mut entries: Vec<Entry> = listed.flatten().collect();
        entries.par_sort_unstable_by(|a, b| {
            (a.cell, a.near, a.id).partial_cmp(&(b.cell, b.near, b.id)).unwrap_or(std::cmp::Ordering::Equal)
        });
        let all = entries.len();
        let mut buffer =
            Self { light, side, reach, starts: vec![0], entries, hidden: 0, triangle_count: triangles.len() as u32 };
        buffer.drop_hidden(triangles, is_opaque);
        buffer.hidden = all - buffer.entries.len();
        buffer
    }

    /// Leaves out entries behind a triangle that covers their cell, and finds the first entry of each cell.
    fn drop_hidden(&mut self, triangles: Triangles<'_>, is_opaque: &(dyn Fn(u32) -> bool + Sync)) {
        let entries = std::mem::take(&mut self.entries);
        let cells: Vec<&[Entry]> = entries.chunk_by(|a, b| a.cell == b.cell).collect();
        let kept = cells.par_iter().map(|entries| {
            let mut farthest = f64::INFINITY;
            let kept = entries.iter().take_while(|entry| {
                let is_kept = entry.near <= farthest * (1.0 + BEHIND);
                if is_kept && is_opaque(entry.id) {
                    farthest = farthest.min(self.cover(triangles.corners(entry.id), entry.cell));
                }
                is_kept
            });
            kept.count()
        });
        let kept: Vec<usize> = kept.collect();
        self.entries.reserve_exact(kept.iter().sum());
        for (entries, kept) in cells.iter().zip(kept) {
            self.starts.resize(entries[0].cell as usize + 1, self.entries.len() as u32);
            self.entries.extend(&entries[..kept]);
        }
        self.starts.resize(6 * (self.side * self.side) as usize + 1, self.entries.len() as u32);
    }

    /// Upper bound on a triangle's distance anywhere in a cell, if the triangle certainly covers the whole cell; else
    /// infinity.
    fn cover(&self, corners: [Vec3; 3], cell: u32) -> f64 {
        let (face, row, column) = (cell / (self.side * self.side), cell / self.side % self.side, cell % self.side);
        let corners = corners.map(|corner| on_face(face, corner.as_dvec3() - self.light));
        let [[left, right], [low, high]] = [column, row].map(|at| grown(self.side, [at, at + 1]));
        let [a, b, c] = corners;
        let error = ROUNDINGS * self.reach;
        // The planes through the light and the edges, with bounds on their rounding errors.
        let planes =
            [[a, b], [b, c], [c, a]].map(|[from, to]| (from.cross(to), 8.0 * error * (from.length() + to.length())));
        let normal = (b - a).cross(c - a);
        let height = normal.dot(a);
        // So steep that the relative error of distances above a thousandth of the reach is below 10⁻⁶.
        let least_slope = 1e10 * error * ((b - a).length() + (c - a).length());
        let mut farthest = 0.0_f64;
        for direction in [[left, low], [left, high], [right, low], [right, high]] {
            let direction = DVec3::new(direction[0], direction[1], 1.0);
            let is_inside = |(plane, error): &(DVec3, f64)| plane.dot(direction) * height.signum() > *error;
            let slope = normal.dot(direction) * height.signum();
            let distance = height.abs() / slope;
            if !planes.iter().all(is_inside)
                || slope <= least_slope
                || distance.is_nan()
                || distance <= 1e-3 * self.reach
            {
                return f64::INFINITY;
            }
            farthest = farthest.max(distance);
        }
        farthest
    }

    /// Number of entries in all cells.
    #[must_use]
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Whether there are no entries.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Number of hidden entries.
    #[must_use]
    pub fn hidden(&self) -> usize {
        self.hidden
    }

    /// Bytes of memory.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.starts.capacity() * size_of::<u32>() + self.entries.capacity() * size_of::<Entry>()
    }
}

answers_single_rays!(LightBuffer);

impl Visit for LightBuffer {
    /// # Panics
    /// If the ray doesn't start at the light.
    fn visit(
        &self,
        _: Triangles<'_>,
        ray: &Ray,
        mut test: impl FnMut(u32, &mut f64) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        assert_eq!(ray.origin, self.light, "a light buffer's rays start at its light");
        let mut t_max = ray.t_max;
        let magnitudes = ray.direction.abs();
        let axis = (0..3).max_by(|&a, &b| magnitudes[a].total_cmp(&magnitudes[b])).unwrap_or_default();
        let face = 2 * axis as u32 + u32::from(ray.direction[axis] < 0.0);
        let along = on_face(face, ray.direction);
        if along.z.is_nan() || ROUNDINGS * self.reach > 0.1 * MARGIN * along.z {
            return (0..self.triangle_count).try_for_each(|id| test(id, &mut t_max));
        }
        let [column, row] = [along.x, along.y].map(|at| {
            let cell = (at / along.z + 1.0) * (0.5 * f64::from(self.side));
            (cell as u32).min(self.side - 1)
        });
        let cell = ((face * self.side + row) * self.side + column) as usize;
        for entry in &self.entries[self.starts[cell] as usize..self.starts[cell + 1] as usize] {
            if entry.near > t_max * along.z * (1.0 + BEHIND) {
                break;
            }
            test(entry.id, &mut t_max)?;
        }
        ControlFlow::Continue(())
    }
}

/// A triangle to be listed in the cells of a face.
struct Listing {
    side: u32,
    corners: [DVec3; 3],
    slack: f64,
}

impl Listing {
    /// Calls `list` with each cell of the columns and rows that the triangle may be in; divides the ranges in halves.
    fn descend(&self, cells: [[u32; 2]; 2], list: &mut impl FnMut([u32; 2])) {
        for axis in 0..2 {
            let [low, high] = grown(self.side, cells[axis]);
            let is_outside =
                |beyond: &dyn Fn(&DVec3) -> f64| self.corners.iter().all(|corner| beyond(corner) > self.slack);
            if is_outside(&|corner| low * corner.z - corner[axis])
                || is_outside(&|corner| corner[axis] - high * corner.z)
            {
                return;
            }
        }
        // A triangle wholly behind the light is in no cell of the face.
        if self.corners.iter().all(|corner| corner.z < -self.slack) {
            return;
        }
        let longer = usize::from(cells[1][1] - cells[1][0] > cells[0][1] - cells[0][0]);
        let [first, end] = cells[longer];
        if end - first == 1 {
            return list([cells[0][0], cells[1][0]]);
        }
        let middle = first + (end - first) / 2;
        for half in [[first, middle], [middle, end]] {
            let mut cells = cells;
            cells[longer] = half;
            self.descend(cells, list);
        }
    }
}

/// Start and end of cells on a face, from −1 to 1, grown by the margin.
fn grown(side: u32, [first, end]: [u32; 2]) -> [f64; 2] {
    let at = |cell: u32| 2.0 * f64::from(cell) / f64::from(side) - 1.0;
    [at(first) - MARGIN, at(end) + MARGIN]
}

/// A vector in the coordinates of one of the cube's faces, which come in pairs for x, y and z: z points away from the
/// light, through the face.
fn on_face(face: u32, vector: DVec3) -> DVec3 {
    let turned = match face / 2 {
        0 => DVec3::new(vector.y, vector.z, vector.x),
        1 => DVec3::new(vector.z, vector.x, vector.y),
        _ => vector,
    };
    if face.is_multiple_of(2) { turned } else { -turned }
}
