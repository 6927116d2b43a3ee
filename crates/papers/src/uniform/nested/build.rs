use std::ops::Range;
use std::sync::atomic::AtomicU32;
use std::sync::atomic::Ordering::Relaxed;

use glam::DVec3;
use rayon::prelude::*;
use umbrage_rays::parallel::{Parallel, both};

use super::super::build::{CHUNK, CHUNK_CELLS, for_each_cell, resize, scan, sort};
use super::super::lattice::{CellBox, Lattice};
use super::super::{UniformGrid, UniformOptions, macrocells};
use super::{Nested, NestedGrid};
use umbrage_rays::{Bounds, Triangles};

/// The largest depth of grids inside of each other, without the scene's.
const MOST_LEVELS: usize = 4;

/// Cost of a ray's step to the next cell, in tests of triangles.
const STEP: f64 = 0.3;

/// Cost of taking a ray into a grid and out again, in tests of triangles.
const ENTER: f64 = 6.0;

/// Memory used only during the build.
#[derive(Default)]
pub(super) struct Building {
    /// For each chunk of cells, those that list many triangles.
    found: Vec<Vec<u32>>,
    crowds: Vec<Crowd>,
    /// The cells of each triangle, in the order of crowds and their triangles.
    boxes: Vec<CellBox>,
    sums: Vec<u32>,
}

impl Building {
    pub(super) fn bytes(&self) -> usize {
        let found = self.found.iter().map(|found| found.capacity() * size_of::<u32>() + size_of::<Vec<u32>>());
        found.sum::<usize>()
            + self.crowds.capacity() * size_of::<Crowd>()
            + self.boxes.capacity() * size_of::<CellBox>()
            + self.sums.capacity() * size_of::<u32>()
    }
}

/// A cell that lists many triangles.
struct Crowd {
    /// The start and end of its references.
    low: usize,
    high: usize,
    /// The index of its first triangle's cells in [`Building::boxes`].
    first_box: usize,
    /// The cell's index in [`Nested::held`].
    interval: usize,
    /// The cell, grown by twice the margin.
    room: Bounds,
    /// Edge of the cell.
    side: f64,
    /// The lattice of the grid inside, if any.
    lattice: Option<Lattice>,
}

impl Crowd {
    fn len(&self) -> usize {
        self.high - self.low
    }

    fn range(&self) -> Range<usize> {
        self.low..self.high
    }
}

/// The limits of the grids of one level.
struct Limits {
    /// Cells for each reference to a triangle of a crowd.
    cells: f64,
    /// References per reference to a triangle of a crowd.
    references: f64,
}

impl UniformGrid {
    /// Makes the grids inside of cells. The scene's cells already list their triangles.
    pub(in super::super) fn nest(&mut self, triangles: Triangles<'_>) {
        // Taken out, since the scene's cells are read meanwhile.
        let mut nested = std::mem::take(&mut self.nested);
        nested.clear(&self.options, self.ids.len());
        if let (Some(_), Some(lattice)) = (self.options.nested_above, self.lattice) {
            let usable = self.triangle_count - self.omitted.total() as usize;
            nested.find(&self.starts, 0..lattice.len());
            nested.list_crowds(&self.starts, [(lattice, 0)].into_iter(), 0);
            nested.plan(triangles, &self.ids, &self.options, usable);
            let mut level = nested.add_level(triangles, Some(&self.ids), &self.options);
            for _ in 1..MOST_LEVELS {
                if level.is_empty() {
                    break;
                }
                level = nested.nest_deeper(triangles, &self.options, usable, level);
            }
        }
        self.nested = nested;
    }
}

impl Nested {
    fn clear(&mut self, options: &UniformOptions, scene_references: usize) {
        self.grids.clear();
        self.held.clear();
        (self.cell_count, self.references) = (0, 0);
        self.macrocell = options.macrocell;
        self.interval = options.nested_above.unwrap_or(0);
        self.scene_intervals = options.nested_above.map_or(0, |above| scene_references / above as usize + 1);
        self.held.resize(self.scene_intervals, None);
    }

    /// Makes the grids inside of the cells of `parents`, the grids of one level.
    fn nest_deeper(
        &mut self,
        triangles: Triangles<'_>,
        options: &UniformOptions,
        usable: usize,
        parents: Range<usize>,
    ) -> Range<usize> {
        let cells = self.grids[parents.start].first as usize..self.cell_count;
        // Taken out, since starts are read while others are written.
        let (starts, ids) = (std::mem::take(&mut self.starts), std::mem::take(&mut self.ids));
        let grids = std::mem::take(&mut self.grids);
        self.find(&starts, cells);
        let parents = grids[parents].iter().map(|grid| (grid.lattice, grid.first as usize));
        self.list_crowds(&starts, parents, self.scene_intervals);
        self.plan(triangles, &ids, options, usable);
        (self.starts, self.ids, self.grids) = (starts, ids, grids);
        self.add_level(triangles, None, options)
    }

    /// Finds the cells that list many triangles.
    fn find(&mut self, starts: &[AtomicU32], cells: Range<usize>) {
        let above = self.interval;
        let found = &mut self.building.found;
        let chunks = cells.len().div_ceil(CHUNK_CELLS);
        if found.len() < chunks {
            found.resize_with(chunks, Vec::new);
        }
        found.par_iter_mut().enumerate().each(|(chunk, found)| {
            found.clear();
            let first = cells.start + chunk * CHUNK_CELLS;
            let end = cells.end.min(first + CHUNK_CELLS);
            if first < end {
                let starts = starts[first..=end].windows(2).zip(first as u32..);
                let many = |pair: &[AtomicU32]| pair[1].load(Relaxed) - pair[0].load(Relaxed) > above;
                found.extend(starts.filter(|(pair, _)| many(pair)).map(|(_, index)| index));
            }
        });
    }

    /// Lists the cells found. `parents` are their lattices, each with its first cell's index; `first_interval` is the index
    /// in [`held`](Self::held) of their first reference.
    fn list_crowds(
        &mut self,
        starts: &[AtomicU32],
        mut parents: impl Iterator<Item = (Lattice, usize)>,
        first_interval: usize,
    ) {
        let Building { found, crowds, boxes, .. } = &mut self.building;
        crowds.clear();
        let mut first_box = 0;
        let Some(mut parent) = parents.next() else { return };
        for index in found.iter().flatten().map(|&index| index as usize) {
            while index - parent.1 >= parent.0.len() {
                let Some(next) = parents.next() else { return };
                parent = next;
            }
            let [low, high] = [index, index + 1].map(|index| starts[index].load(Relaxed) as usize);
            let interval = first_interval + low / self.interval as usize;
            let room = room(&parent.0, index - parent.1);
            let side = parent.0.side;
            crowds.push(Crowd { low, high, first_box, interval, room, side, lattice: None });
            first_box += high - low;
        }
        resize(boxes, first_box, || CellBox::EMPTY);
    }

    /// Chooses each crowd's lattice, and finds the cells of it that each triangle is in.
    fn plan(&mut self, triangles: Triangles<'_>, ids: &[AtomicU32], options: &UniformOptions, usable: usize) {
        let Building { crowds, boxes, .. } = &mut self.building;
        let crowded = boxes.len().max(1) as f64;
        // The limits for all levels together: as many references as the scene's cells, and twice as many cells.
        let most = UniformGrid::MOST_REFERENCES * usable as u64 + UniformGrid::LEAST_LIMIT;
        let most_cells = (2.0 * options.cells_per_triangle * usable as f64).min(Lattice::MOST_CELLS);
        let limits = Limits {
            cells: options.cells_per_triangle.min((most_cells - self.cell_count as f64).max(0.0) / crowded),
            references: (UniformGrid::MOST_REFERENCES as f64)
                .min(most.saturating_sub(self.references as u64) as f64 / crowded),
        };
        let len = |crowd: &Crowd| crowd.len();
        for_each_part(crowds, boxes, &len, &|crowd: &mut Crowd, boxes: &mut [CellBox]| {
            choose(crowd, boxes, &ids[crowd.range()], triangles, &limits);
        });
        crowds.retain(|crowd| crowd.lattice.is_some());
    }

    /// Adds the chosen grids and returns their range. The crowds' triangles are in `scene_ids` if they are the scene's
    /// cells, else in the ids of grids that were added before.
    fn add_level(
        &mut self,
        triangles: Triangles<'_>,
        scene_ids: Option<&[AtomicU32]>,
        options: &UniformOptions,
    ) -> Range<usize> {
        let (first_grid, first_cell, first_id) = (self.grids.len(), self.cell_count, self.references);
        let first_macrocell = self.add_grids(options);
        let Self { grids, starts, ids, occupied, building, .. } = self;
        let Building { crowds, boxes, sums, .. } = building;
        let level = first_grid..grids.len();
        if level.is_empty() {
            return level;
        }
        let cells = first_cell..self.cell_count;
        // Counted two cells on, so that scattering moves starts to their final positions. A level starts at the end of the
        // previous one: at its last two sums.
        if starts.len() < cells.end + 2 {
            resize(starts, cells.end + 2, AtomicU32::default);
        }
        let unset = if first_cell == 0 { 0 } else { first_cell + 2 };
        let fresh = &mut starts[unset..cells.end + 2];
        fresh.par_chunks_mut(CHUNK_CELLS).each(|starts| starts.iter_mut().for_each(|start| *start.get_mut() = 0));
        let visit = |crowd: &Crowd, grid: &NestedGrid, ids: &[AtomicU32], work: &(dyn Fn(usize, u32) + Sync)| {
            let boxes = &boxes[crowd.first_box..][..crowd.len()];
            ids[crowd.range()].par_chunks(CHUNK).zip(boxes.par_chunks(CHUNK)).each(|(ids, boxes)| {
                for (id, cells) in ids.iter().zip(boxes) {
                    let id = id.load(Relaxed);
                    for_each_cell(triangles, &grid.lattice, (id, cells), options.insertion, |cell| {
                        work(grid.first as usize + cell, id);
                    });
                }
            });
        };
        let visit_all = |ids: &[AtomicU32], work: &(dyn Fn(usize, u32) + Sync)| {
            let crowds = crowds.par_iter().zip(&grids[level.clone()]);
            crowds.each(|(crowd, grid)| visit(crowd, grid, ids, work));
        };
        let counted = &*starts;
        visit_all(scene_ids.unwrap_or(ids), &|cell, _| {
            counted[cell + 2].fetch_add(1, Relaxed);
        });
        self.references = scan(&mut starts[first_cell + 1..cells.end + 2], sums) as usize;
        if ids.len() < self.references {
            resize(ids, self.references, AtomicU32::default);
        }
        let (placed, listed) = (&*starts, &*ids);
        visit_all(scene_ids.unwrap_or(ids), &|cell, id| {
            let index = placed[cell + 1].fetch_add(1, Relaxed);
            listed[index as usize].store(id, Relaxed);
        });
        let end = self.references as u32;
        sort(&starts[cells.clone()], end, &mut ids[first_id..self.references]);
        let len = |grid: &NestedGrid| grid.macrocells.element_product() as usize;
        let (side, starts) = (options.macrocell, &*starts);
        for_each_part(&mut grids[level.clone()], &mut occupied[first_macrocell..], &len, &|grid, occupied| {
            macrocells::mark(&grid.lattice, side, &starts[grid.first as usize..], occupied);
        });
        self.held.resize(self.scene_intervals + self.references / self.interval as usize + 1, None);
        level
    }

    /// Adds the chosen grids without their triangles, and returns the index of the first one's macrocells.
    fn add_grids(&mut self, options: &UniformOptions) -> usize {
        let last = self.grids.last();
        let end = |grid: &NestedGrid| grid.first_macrocell + grid.macrocells.element_product();
        let first_macrocell = last.map_or(0, end);
        let mut next = first_macrocell;
        for crowd in &self.building.crowds {
            let Some(lattice) = crowd.lattice else { continue };
            let macrocells = macrocells::count(&lattice, options.macrocell);
            self.held[crowd.interval] = Some(self.grids.len() as u32);
            let first = self.cell_count as u32;
            self.grids.push(NestedGrid { lattice, macrocells, first, first_macrocell: next });
            next += macrocells.element_product();
            self.cell_count += lattice.len();
        }
        self.occupied.resize(next as usize, false);
        first_macrocell as usize
    }
}

/// The bounds of a cell, given its index, grown by twice the margin, so that more than the margin is left after rounding.
fn room(lattice: &Lattice, index: usize) -> Bounds {
    let [columns, rows] = [lattice.cells.x as usize, lattice.cells.y as usize];
    let cell = [index % columns, index / columns % rows, index / (columns * rows)].map(|at| at as f64);
    let low = lattice.corner + (DVec3::from(cell) - 2.0 * Lattice::MARGIN) * lattice.side;
    let high = lattice.corner + (DVec3::from(cell) + 1.0 + 2.0 * Lattice::MARGIN) * lattice.side;
    Bounds { min: low.as_vec3().map(f32::next_down), max: high.as_vec3().map(f32::next_up) }
}

/// Chooses the lattice inside of a crowd's cell, and finds the cells of it that each triangle is in; there is none if it
/// doesn't pay.
///
/// It pays if the expected cost of a ray through the cell is less with the grid than without: a ray that meets a box meets a
/// smaller one inside of it in proportion to their areas (`MacDonald` and Booth, *Heuristics for Ray Tracing Using Space
/// Subdivision*, 1990).
fn choose(crowd: &mut Crowd, boxes: &mut [CellBox], ids: &[AtomicU32], triangles: Triangles<'_>, limits: &Limits) {
    let corners = |id: &AtomicU32| triangles.corners(id.load(Relaxed));
    let bounds = ids.par_chunks(CHUNK).map(|ids| {
        ids.iter().map(corners).fold(Bounds::EMPTY, |bounds, [a, b, c]| {
            bounds.union(Bounds { min: a.min(b).min(c), max: a.max(b).max(c) })
        })
    });
    let bounds = bounds.merge(Bounds::union).unwrap_or(Bounds::EMPTY);
    let bounds = Bounds { min: bounds.min.max(crowd.room.min), max: bounds.max.min(crowd.room.max) };
    let count = ids.len() as f64;
    let limit = (count * limits.references) as u64;
    let mut lattice = Lattice::around(bounds, count * limits.cells);
    while lattice.len() > 1 {
        let parts = ids.par_chunks(CHUNK).zip(boxes.par_chunks_mut(CHUNK)).map(|(ids, boxes)| {
            let located = ids.iter().zip(boxes).map(|(id, cells)| {
                *cells = lattice.cells_around(corners(id));
                cells.len()
            });
            located.sum::<u64>()
        });
        let references: u64 = parts.sum();
        if references <= limit {
            let share = (lattice.side / crowd.side).powi(2);
            let cost = ENTER + share * (STEP * lattice.len() as f64 + references as f64);
            if cost < count {
                crowd.lattice = Some(lattice);
            }
            return;
        }
        let excess = references as f64 / limit.max(1) as f64;
        lattice = Lattice::with_side(bounds, lattice.side * excess.cbrt().max(1.1));
    }
}

/// Calls `work` with each item and its part of `pool`, on all threads. Parts are in the order of items, each `len` long.
fn for_each_part<T: Send, P: Send>(
    items: &mut [T],
    pool: &mut [P],
    len: &(impl Fn(&T) -> usize + Sync),
    work: &(impl Fn(&mut T, &mut [P]) + Sync),
) {
    if items.len() <= 1 || pool.len() <= CHUNK {
        let mut rest = pool;
        for item in items {
            let (part, others) = rest.split_at_mut(len(item));
            work(item, part);
            rest = others;
        }
        return;
    }
    let (low, high) = items.split_at_mut(items.len() / 2);
    let (low_pool, high_pool) = pool.split_at_mut(low.iter().map(len).sum());
    both(|| for_each_part(low, low_pool, len, work), || for_each_part(high, high_pool, len, work));
}
