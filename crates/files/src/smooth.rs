//! Smooth normals with creases for meshes without normals.

use std::ops::Range;
use std::sync::Arc;

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use umbrage_rays::HashKey;
use umbrage_rays::parallel::Parallel;
use umbrage_scene::{Frame, Mesh};

use crate::memory::Budget;

/// Default crease angle in degrees: edges between neighbouring triangles up to this angle are smooth. With 0 all triangles
/// are flat.
pub(crate) const DEFAULT_CREASE_DEGREES: f32 = 60.0;

/// The purpose of memory, for error messages.
const SMOOTH_NORMALS: &str = "smooth normals, which --crease 0 leaves out,";

/// Treatment of triangles whose vertices all have the triangle's own normal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FlatTriangles {
    /// They get no normals and share their vertices, which takes less memory.
    Shared,
    /// They get normals like all others, since they may bend later.
    Normals,
}

/// Adds normals to a frame without any: averages of the triangles' normals, weighted by area and by the angle at the vertex.
///
/// Vertices with bitwise equal positions count as one. Triangles around a position that share an edge are smoothed together
/// where their angle is at most the crease angle. A normal farther than that from a triangle's own is replaced by the
/// latter, as at the apex of a cone. Vertices with several normals are split: their copies come last, and the original of
/// each copy is returned. Positions and triangles stay as they are. Takes O(n log n) time for all input.
///
/// # Errors
/// A message, where memory is too small, or there are too many vertices.
pub(crate) fn smooth(
    frame: &mut Frame,
    crease_degrees: f32,
    flat: FlatTriangles,
    budget: &Budget,
) -> Result<Vec<u32>, String> {
    if crease_degrees <= 0.0 || !frame.normals.is_empty() || frame.mesh.triangles.is_empty() {
        return Ok(Vec::new());
    }
    let fans = Fans::new(&frame.positions, &frame.mesh.triangles, budget)?;
    budget.take_for::<CornerNormal>(fans.corners.len(), SMOOTH_NORMALS)?;
    let mut corner_normals = vec![CornerNormal::default(); fans.corners.len()];
    let least_cosine = libm::cos(f64::from(crease_degrees.min(180.0)).to_radians());
    fans.each(&mut corner_normals, |corners, normals| {
        fans.smooth(corners, &frame.positions, &frame.mesh.triangles, least_cosine, normals);
    });
    if flat == FlatTriangles::Shared {
        let mut bends = vec![false; frame.mesh.triangles.len()];
        for (corner, normal) in fans.corners.iter().zip(&corner_normals) {
            bends[*corner as usize / 3] |= !normal.is_own;
        }
        if !bends.contains(&true) {
            return Ok(Vec::new());
        }
        for (corner, normal) in fans.corners.iter().zip(&mut corner_normals) {
            if !bends[*corner as usize / 3] {
                normal.normal = Vec3::ZERO;
            }
        }
    }
    split(frame, &fans, &corner_normals, budget)
}

/// The normal of a corner of a triangle; zero for triangles without an area.
#[derive(Clone, Copy, Debug, Default)]
struct CornerNormal {
    normal: Vec3,
    /// Whether this is the triangle's own normal.
    is_own: bool,
}

/// The corners of triangles by position. A corner's number is three times its triangle's index, plus 0 to 2.
#[derive(Debug)]
struct Fans {
    /// Each vertex's position index, in order of appearance.
    position_of_vertex: Vec<u32>,
    /// Start of each position's range in `corners`, and the last one's end.
    first_corner: Vec<u32>,
    /// By position, ascending.
    corners: Vec<u32>,
}

impl Fans {
    fn new(positions: &[Vec3], triangles: &[[u32; 3]], budget: &Budget) -> Result<Self, String> {
        let corners = triangles.len().checked_mul(3).filter(|&corners| u32::try_from(corners).is_ok());
        let corners = corners.ok_or("smooth normals of more corners than a 32-bit index counts (--crease 0)")?;
        let slots = (2 * positions.len()).next_power_of_two();
        budget.take_for::<u32>(slots + 2 * positions.len() + corners, SMOOTH_NORMALS)?;
        let (position_of_vertex, count) = joined(positions, slots);
        let position = |corner: u32| position_of_vertex[triangles[corner as usize / 3][corner as usize % 3] as usize];
        // A counting sort.
        let mut first_corner = vec![0; count as usize + 2];
        for corner in 0..corners as u32 {
            first_corner[position(corner) as usize + 2] += 1;
        }
        for index in 2..first_corner.len() {
            first_corner[index] += first_corner[index - 1];
        }
        let mut sorted = vec![0; corners];
        for corner in 0..corners as u32 {
            let next = &mut first_corner[position(corner) as usize + 1];
            sorted[*next as usize] = corner;
            *next += 1;
        }
        first_corner.pop();
        Ok(Self { position_of_vertex, first_corner, corners: sorted })
    }

    fn len(&self) -> usize {
        self.first_corner.len() - 1
    }

    fn corners_of(&self, positions: Range<usize>) -> Range<usize> {
        self.first_corner[positions.start] as usize..self.first_corner[positions.end] as usize
    }

    /// Calls `work` in parallel for each position with its part of `values`, which has an element per corner.
    fn each<T: Send>(&self, values: &mut [T], work: impl Fn(&[u32], &mut [T]) + Sync) {
        /// Positions per task.
        const GRAIN: usize = 1024;
        let mut pieces = Vec::with_capacity(self.len() / GRAIN + 1);
        let mut rest = values;
        for start in (0..self.len()).step_by(GRAIN) {
            let positions = start..(start + GRAIN).min(self.len());
            let (piece, others) = rest.split_at_mut(self.corners_of(positions.clone()).len());
            pieces.push((positions, piece));
            rest = others;
        }
        pieces.into_par_iter().each(|(positions, mut piece)| {
            for position in positions {
                let corners = self.corners_of(position..position + 1);
                let (own, others) = piece.split_at_mut(corners.len());
                work(&self.corners[corners], own);
                piece = others;
            }
        });
    }

    /// Edges with more triangles than this are creases, since comparing all pairs would take too long.
    const MOST_AT_AN_EDGE: usize = 8;
    /// Normals with at least this cosine, 0.02°, count as equal.
    const SAME: f64 = 1.0 - 6e-8;

    /// Finds the normals of the corners at one position.
    fn smooth(
        &self,
        corners: &[u32],
        positions: &[Vec3],
        triangles: &[[u32; 3]],
        least_cosine: f64,
        normals: &mut [CornerNormal],
    ) {
        // The corner's vertex, and the next two of its triangle.
        let around = |corner: u32| {
            let (triangle, first) = (triangles[corner as usize / 3], corner as usize % 3);
            [0, 1, 2].map(|step| triangle[(first + step) % 3])
        };
        let facet = |&corner: &u32| Facet::new(around(corner).map(|vertex| positions[vertex as usize]));
        let facets: Vec<Facet> = corners.iter().map(facet).collect();
        let mut edges = Vec::with_capacity(2 * corners.len());
        for (index, &corner) in (0_u32..).zip(corners) {
            if facets[index as usize].is_there() {
                let [_, next, last] = around(corner).map(|vertex| self.position_of_vertex[vertex as usize]);
                edges.extend([(next, index), (last, index)]);
            }
        }
        edges.sort_unstable();
        let mut groups = Groups((0..corners.len() as u32).collect());
        for edge in edges.chunk_by(|(left, _), (right, _)| left == right) {
            if edge.len() > Self::MOST_AT_AN_EDGE {
                continue;
            }
            for (number, &(_, first)) in edge.iter().enumerate() {
                for &(_, second) in &edge[number + 1..] {
                    let [one, other] = [first, second].map(|index| facets[index as usize].normal);
                    if one.dot(other) >= least_cosine {
                        groups.unite(first, second);
                    }
                }
            }
        }
        let mut sums = vec![DVec3::ZERO; corners.len()];
        for (index, facet) in (0..).zip(&facets) {
            sums[groups.first(index) as usize] += facet.normal * facet.weight;
        }
        for (index, (facet, normal)) in (0..).zip(facets.iter().zip(normals)) {
            let mean = sums[groups.first(index) as usize].normalize_or_zero();
            let cosine = mean.dot(facet.normal);
            let is_own = cosine >= Self::SAME || cosine < least_cosine || !facet.is_there();
            let own_or_mean = if cosine < least_cosine { facet.normal } else { mean };
            let shown = if facet.is_there() { own_or_mean } else { DVec3::ZERO };
            *normal = CornerNormal { normal: shown.as_vec3(), is_own };
        }
    }
}

/// A triangle's normal and weight at one of its corners.
#[derive(Clone, Copy)]
struct Facet {
    /// Unit length; zero for a triangle that is degenerate or not finite.
    normal: DVec3,
    /// The triangle's area times its angle at the corner.
    weight: f64,
}

impl Facet {
    /// The facet at the first of three corners. f64 holds the squares of all f32 coordinates.
    fn new(corners: [Vec3; 3]) -> Self {
        let [at, next, last] = corners.map(Vec3::as_dvec3);
        let (next, last) = (next - at, last - at);
        let doubled_area = next.cross(last);
        let length = doubled_area.length();
        let normal = doubled_area / length;
        if !(length > 0.0 && normal.is_finite()) {
            return Self { normal: DVec3::ZERO, weight: 0.0 };
        }
        Self { normal, weight: length * libm::atan2(length, next.dot(last)) }
    }

    fn is_there(&self) -> bool {
        self.weight > 0.0
    }
}

/// Disjoint sets of numbers; a set's representative is its least number.
struct Groups(Vec<u32>);

impl Groups {
    fn first(&mut self, mut number: u32) -> u32 {
        while self.0[number as usize] != number {
            // Path halving.
            self.0[number as usize] = self.0[self.0[number as usize] as usize];
            number = self.0[number as usize];
        }
        number
    }

    fn unite(&mut self, one: u32, other: u32) {
        let [one, other] = [self.first(one), self.first(other)];
        self.0[one.max(other) as usize] = one.min(other);
    }
}

/// Returns each vertex's position index and the number of positions. A random hash key keeps files from forcing collisions;
/// its value doesn't affect the result.
fn joined(positions: &[Vec3], slots: usize) -> (Vec<u32>, u32) {
    const FREE: u32 = u32::MAX;
    let key = HashKey::default();
    // Adding zero turns -0 into 0.
    let bits = |vertex: usize| (positions[vertex] + Vec3::ZERO).to_array().map(f32::to_bits);
    let mut table = vec![FREE; slots];
    let mut position_of_vertex = Vec::with_capacity(positions.len());
    let mut count = 0;
    for vertex in 0..positions.len() {
        let own = bits(vertex);
        let hash = own.iter().fold(key.start(), |hash, &bits| key.mix(hash, bits.into()));
        let mut slot = hash as usize & (slots - 1);
        while table[slot] != FREE && bits(table[slot] as usize) != own {
            slot = (slot + 1) & (slots - 1);
        }
        if table[slot] == FREE {
            table[slot] = vertex as u32;
            position_of_vertex.push(count);
            count += 1;
        } else {
            position_of_vertex.push(position_of_vertex[table[slot] as usize]);
        }
    }
    (position_of_vertex, count)
}

/// Assigns each vertex one normal, and splits vertices whose corners have several.
fn split(frame: &mut Frame, fans: &Fans, corner_normals: &[CornerNormal], budget: &Budget) -> Result<Vec<u32>, String> {
    let mut originals = Vec::new();
    let vertices = frame.positions.len();
    budget.reserve(&mut frame.normals, vertices, SMOOTH_NORMALS)?;
    frame.normals.resize(vertices, Vec3::ZERO);
    let mesh = Arc::make_mut(&mut frame.mesh);
    let mut sorted = Vec::new();
    for position in 0..fans.len() {
        let corners = fans.corners_of(position..position + 1);
        sorted.clear();
        sorted.extend(corners.map(|index| {
            let corner = fans.corners[index];
            let vertex = mesh.triangles[corner as usize / 3][corner as usize % 3];
            let normal = corner_normals[index].normal;
            (vertex, normal.to_array().map(f32::to_bits), corner)
        }));
        sorted.sort_unstable();
        let mut last_vertex = None;
        for alike in sorted.chunk_by(|one, other| (one.0, one.1) == (other.0, other.1)) {
            let (original, normal, _) = alike[0];
            let normal = Vec3::from_array(normal.map(f32::from_bits));
            let vertex = if last_vertex.replace(original) == Some(original) {
                budget.reserve(&mut originals, 1, SMOOTH_NORMALS)?;
                budget.reserve(&mut frame.normals, 1, SMOOTH_NORMALS)?;
                originals.push(original);
                frame.normals.push(normal);
                u32::try_from(frame.normals.len() - 1).map_err(|_| "more vertices than a 32-bit index counts")?
            } else {
                frame.normals[original as usize] = normal;
                original
            };
            for &(.., corner) in alike {
                mesh.triangles[corner as usize / 3][corner as usize % 3] = vertex;
            }
        }
    }
    let Mesh { tex_coords: [first_coords, second_coords], colors, .. } = mesh;
    copy(&mut frame.positions, &originals, budget)?;
    copy(first_coords, &originals, budget)?;
    copy(second_coords, &originals, budget)?;
    copy(colors, &originals, budget)?;
    Ok(originals)
}

/// Appends copies of some vertices' values, unless the attribute is absent.
fn copy<T: Copy>(values: &mut Vec<T>, originals: &[u32], budget: &Budget) -> Result<(), String> {
    if !values.is_empty() {
        budget.reserve(values, originals.len(), SMOOTH_NORMALS)?;
        for &original in originals {
            values.push(values[original as usize]);
        }
    }
    Ok(())
}
