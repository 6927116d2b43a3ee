use std::collections::BTreeMap;

use glam::{IVec3, Vec3};
use rayon::prelude::*;

use super::{SLACK, Sculpture};

/// A closed surface with shared vertices.
#[derive(Clone, Debug, Default)]
pub(crate) struct Surface {
    pub(crate) positions: Vec<Vec3>,
    /// Unit normals, outwards.
    pub(crate) normals: Vec<Vec3>,
    /// Counterclockwise seen from outside.
    pub(crate) triangles: Vec<[u32; 3]>,
}

/// Cells along each side of a block.
const SIDE: usize = 4;
/// Lattice points along each side of a block.
const POINTS: usize = SIDE + 1;
/// Value of a cell without a vertex.
const NO_VERTEX: u16 = u16::MAX;

/// A cube of cells near the surface.
struct Block {
    /// Lattice point of the block's lowest corner.
    corner: IVec3,
    /// The sculpture's lumps that matter here.
    lumps: Vec<u16>,
}

/// The surface in a block.
struct Patch {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    /// Index in `positions` of each cell's vertex, or [`NO_VERTEX`].
    vertex_of_cell: Vec<u16>,
    /// Lattice edges that the surface crosses: their lower point, their axis, and whether they lead outwards.
    crossings: Vec<(IVec3, usize, bool)>,
}

/// The surface of `sculpture` in about `triangles` triangles of nearly one size (surface nets, Gibson 1998).
pub(crate) fn mesh(sculpture: &Sculpture, triangles: usize) -> Surface {
    let triangles = triangles.max(60) as f32;
    // Each lattice square of the surface has a quad for each axis that it faces, about 1.5 on average. The number of
    // triangles goes with the cell size to the power of −2, except for fine relief: coarse tries correct the estimate.
    const TRIES: [(f32, f32); 2] = [(1.0, 25_000.0), (0.3, 400_000.0)];
    let mut triangles_per_area = 3.0_f32;
    let cell_for = |triangles: f32, per_area: f32| (per_area * sculpture.area / triangles).sqrt();
    for (part, most) in TRIES {
        let wanted = (part * triangles).min(most);
        if wanted < 25_000.0_f32.min(triangles) {
            continue;
        }
        let cell = cell_for(wanted, triangles_per_area);
        let found = mesh_with_cells(sculpture, cell).triangles.len().max(1);
        triangles_per_area = found as f32 * cell * cell / sculpture.area;
    }
    mesh_with_cells(sculpture, cell_for(triangles, triangles_per_area))
}

fn mesh_with_cells(sculpture: &Sculpture, cell: f32) -> Surface {
    let lattice = Lattice { sculpture, cell };
    let blocks = lattice.blocks();
    let patches: Vec<Patch> = blocks.par_iter().map(|block| lattice.patch(block)).collect();
    let block_at: BTreeMap<[i32; 3], usize> =
        blocks.iter().enumerate().map(|(index, block)| (block.corner.to_array(), index)).collect();
    let mut first_vertices = Vec::with_capacity(patches.len());
    let mut surface = Surface::default();
    for patch in &patches {
        first_vertices.push(surface.positions.len() as u32);
        surface.positions.extend_from_slice(&patch.positions);
        surface.normals.extend_from_slice(&patch.normals);
    }
    let vertex = |cell: IVec3, home: usize| {
        let side = SIDE as i32;
        let corner = cell.div_euclid(IVec3::splat(side)) * side;
        let block = if corner == blocks[home].corner { Some(&home) } else { block_at.get(&corner.to_array()) };
        let block = *block?;
        let local = (cell - corner).as_usizevec3();
        let vertex = patches[block].vertex_of_cell[local.x + SIDE * (local.y + SIDE * local.z)];
        (vertex != NO_VERTEX).then(|| first_vertices[block] + u32::from(vertex))
    };
    let quads: Vec<Vec<[u32; 3]>> = patches
        .par_iter()
        .enumerate()
        .map(|(home, patch)| {
            let mut triangles = Vec::with_capacity(2 * patch.crossings.len());
            for &(point, axis, outwards) in &patch.crossings {
                let [one, other] = [IVec3::AXES[(axis + 1) % 3], IVec3::AXES[(axis + 2) % 3]];
                let around = [point - one - other, point - other, point, point - one];
                let [Some(a), Some(b), Some(c), Some(d)] = around.map(|cell| vertex(cell, home)) else { continue };
                let [a, b, c, d] = if outwards { [a, b, c, d] } else { [a, d, c, b] };
                // The shorter diagonal makes the better triangles.
                let length = |from: u32, to: u32| {
                    surface.positions[from as usize].distance_squared(surface.positions[to as usize])
                };
                if length(a, c) <= length(b, d) {
                    triangles.extend([[a, b, c], [a, c, d]]);
                } else {
                    triangles.extend([[a, b, d], [b, c, d]]);
                }
            }
            triangles
        })
        .collect();
    surface.triangles = quads.concat();
    surface
}

/// Points a cell apart, on which a sculpture is sampled.
struct Lattice<'a> {
    sculpture: &'a Sculpture,
    cell: f32,
}

impl Lattice<'_> {
    fn position(&self, point: Vec3) -> Vec3 {
        self.sculpture.center + point * self.cell
    }

    /// The distance, exact for the ends of every lattice edge that the surface crosses.
    fn distance(&self, lumps: &[u16], position: Vec3) -> f32 {
        self.sculpture.distance(lumps, position, 1.5 * self.cell)
    }

    /// The blocks that the surface may pass through, found by halving a cube around it.
    fn blocks(&self) -> Vec<Block> {
        let blocks_across = (2.0 * self.sculpture.half_size / (self.cell * SIDE as f32)).ceil().max(1.0);
        let mut size = SIDE as i32;
        while (size / SIDE as i32) < blocks_across as i32 + 2 {
            size *= 2;
        }
        let all: Vec<u16> = (0..self.sculpture.lumps.len() as u16).collect();
        let mut blocks = Vec::new();
        self.split(IVec3::splat(-size / 2), size, &all, &mut blocks);
        blocks
    }

    /// Adds the blocks of the cube of `size` cells at `corner`, near which only `lumps` matter.
    fn split(&self, corner: IVec3, size: i32, lumps: &[u16], blocks: &mut Vec<Block>) {
        let middle = self.position(corner.as_vec3() + 0.5 * size as f32);
        // Half a cell more than the cube, because normals are measured a little outside of it.
        let radius = 0.866_03 * self.cell * (size + 1) as f32;
        let lumps = self.sculpture.near(lumps, middle, radius);
        let distance = self.sculpture.smooth_distance(&lumps, middle);
        if distance.abs() > SLACK * radius + self.sculpture.relief.greatest + self.sculpture.relief.greatest_tooth {
            return;
        }
        if size == SIDE as i32 {
            blocks.push(Block { corner, lumps });
            return;
        }
        let half = size / 2;
        for octant in 0..8 {
            let step = IVec3::new(octant & 1, (octant >> 1) & 1, octant >> 2) * half;
            self.split(corner + step, half, &lumps, blocks);
        }
    }

    fn patch(&self, block: &Block) -> Patch {
        let index = |point: [usize; 3]| point[0] + POINTS * (point[1] + POINTS * point[2]);
        let mut distances = vec![0.0_f32; POINTS * POINTS * POINTS];
        // Farther than a cell from the surface only the sign counts, which a neighbour's distance tells.
        let step = SLACK * self.cell;
        let mut before = 0.0_f32;
        for (at, distance) in distances.iter_mut().enumerate() {
            let local = Vec3::new((at % POINTS) as f32, (at / POINTS % POINTS) as f32, (at / POINTS / POINTS) as f32);
            before = if at % POINTS > 0 && before.abs() > 2.0 * step {
                before - step.copysign(before)
            } else {
                self.distance(&block.lumps, self.position(block.corner.as_vec3() + local))
            };
            *distance = before;
        }
        let mut patch = Patch {
            positions: Vec::new(),
            normals: Vec::new(),
            vertex_of_cell: vec![NO_VERTEX; SIDE * SIDE * SIDE],
            crossings: Vec::new(),
        };
        for at in 0..SIDE * SIDE * SIDE {
            let cell = [at % SIDE, at / SIDE % SIDE, at / SIDE / SIDE];
            let corners: [f32; 8] = std::array::from_fn(|corner| {
                distances[index([cell[0] + (corner & 1), cell[1] + (corner >> 1 & 1), cell[2] + (corner >> 2)])]
            });
            let point = IVec3::new(cell[0] as i32, cell[1] as i32, cell[2] as i32) + block.corner;
            for axis in 0..3 {
                if (corners[0] < 0.0) != (corners[1 << axis] < 0.0) {
                    patch.crossings.push((point, axis, corners[0] < 0.0));
                }
            }
            if let Some(inside) = middle_of_crossings(&corners) {
                patch.vertex_of_cell[at] = patch.positions.len() as u16;
                let (position, normal) = self.settle(&block.lumps, self.position(point.as_vec3() + inside));
                patch.positions.push(position);
                patch.normals.push(normal);
            }
        }
        patch
    }

    /// Moves a position onto the surface, by at most a cell, and returns the normal there.
    fn settle(&self, lumps: &[u16], position: Vec3) -> (Vec3, Vec3) {
        let step = 0.3 * self.cell;
        // Differences along a tetrahedron's four corners.
        const CORNERS: [Vec3; 4] =
            [Vec3::ONE, Vec3::new(1.0, -1.0, -1.0), Vec3::new(-1.0, 1.0, -1.0), Vec3::new(-1.0, -1.0, 1.0)];
        let samples = CORNERS.map(|corner| self.distance(lumps, position + corner * step));
        let gradient: Vec3 = (0..4).map(|at| CORNERS[at] * samples[at]).sum::<Vec3>() / (4.0 * step);
        let distance = samples.iter().sum::<f32>() * 0.25;
        let normal = gradient.normalize_or(Vec3::Y);
        let move_by = (distance / gradient.length().max(0.2)).clamp(-0.5 * self.cell, 0.5 * self.cell);
        (position - normal * move_by, normal)
    }
}

/// The mean of the points, in a cell of side 1, where its edges cross the surface; `None` when none does.
fn middle_of_crossings(corners: &[f32; 8]) -> Option<Vec3> {
    let inside = corners.iter().filter(|&&distance| distance < 0.0).count();
    if inside == 0 || inside == 8 {
        return None;
    }
    let (mut sum, mut count) = (Vec3::ZERO, 0.0);
    let at = |corner: usize| Vec3::new((corner & 1) as f32, (corner >> 1 & 1) as f32, (corner >> 2) as f32);
    for low in 0..8 {
        for high in [1, 2, 4].map(|axis| low | axis).into_iter().filter(|&high| high != low) {
            if (corners[low] < 0.0) != (corners[high] < 0.0) {
                sum += at(low) + (at(high) - at(low)) * (corners[low] / (corners[low] - corners[high]));
                count += 1.0;
            }
        }
    }
    Some(sum / count)
}
