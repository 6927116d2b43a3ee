use std::sync::atomic::AtomicU32;
use std::sync::atomic::Ordering::Relaxed;

use rayon::prelude::*;
use umbrage_rays::parallel::{Parallel, both};

use super::lattice::{CellBox, Lattice, VertexCells};
use super::overlap::ExactTriangle;
use super::{Insertion, UniformGrid};
use umbrage_rays::{Bounds, Omitted, Triangles};

/// Triangles in a thread's chunk.
pub(super) const CHUNK: usize = 1 << 12;

/// Cells in a thread's chunk.
pub(super) const CHUNK_CELLS: usize = 1 << 14;

/// The bounds and omissions of a chunk of triangles.
#[derive(Default)]
pub(super) struct Chunk {
    bounds: Bounds,
    omitted: Omitted,
}

impl UniformGrid {
    /// The largest number of references per triangle, besides [`LEAST_LIMIT`](Self::LEAST_LIMIT) in all: cells are enlarged
    /// until there are no more.
    pub const MOST_REFERENCES: u64 = 7;

    /// References that any number of triangles may have.
    pub const LEAST_LIMIT: u64 = 1 << 16;

    /// Replaces the grid by one over `triangles`, on all threads of the current pool. The result is the same for any number
    /// of threads.
    ///
    /// # Panics
    /// If there are 2²⁸ triangles or more.
    pub fn build(&mut self, triangles: Triangles<'_>) {
        assert!(triangles.len() < 1 << 28, "{} triangles are too many for references", triangles.len());
        self.triangle_count = triangles.len();
        self.survey(triangles);
        let lattice = self.choose_lattice(triangles);
        self.lattice = Some(lattice);
        self.count(triangles, &lattice);
        self.scan();
        self.scatter(triangles, &lattice);
        let end = self.ids.len() as u32;
        sort(&self.starts[..lattice.len()], end, &mut self.ids);
        self.macrocells.mark(&lattice, self.options.macrocell, &self.starts);
        self.nest(triangles);
    }

    /// Finds the bounds of all triangles, and those that can't be hit.
    fn survey(&mut self, triangles: Triangles<'_>) {
        let Self { chunks, bounds, omitted, .. } = self;
        chunks.resize_with(triangles.len().div_ceil(CHUNK), Chunk::default);
        chunks.par_iter_mut().enumerate().each(|(index, chunk)| {
            chunk.bounds = Bounds::EMPTY;
            chunk.omitted.clear();
            let first = index * CHUNK;
            for id in first as u32..triangles.len().min(first + CHUNK) as u32 {
                match triangles.usable_corners(id) {
                    Ok([a, b, c]) => {
                        let bounds = Bounds { min: a.min(b).min(c), max: a.max(b).max(c) };
                        chunk.bounds = chunk.bounds.union(bounds);
                    }
                    Err(why) => chunk.omitted.note(id, why),
                }
            }
        });
        *bounds = Bounds::EMPTY;
        omitted.clear();
        for chunk in chunks {
            *bounds = bounds.union(chunk.bounds);
            omitted.append(&chunk.omitted);
        }
    }

    /// The lattice for the options, or one with larger cells if triangles would have too many references. Finds the cells of
    /// each triangle as well.
    fn choose_lattice(&mut self, triangles: Triangles<'_>) -> Lattice {
        let usable = self.triangle_count - self.omitted.total() as usize;
        let mut lattice = Lattice::around(self.bounds, self.options.cells_per_triangle * usable as f64);
        let limit = Self::MOST_REFERENCES * usable as u64 + Self::LEAST_LIMIT;
        loop {
            let references = self.locate(triangles, &lattice);
            if references <= limit {
                return lattice;
            }
            // References of boxes that are large in all directions grow with the third power of the resolution, those of
            // flat boxes with the second. If a step is too small, another one follows.
            let excess = references as f64 / limit as f64;
            lattice = Lattice::with_side(self.bounds, lattice.side * excess.cbrt().max(1.1));
        }
    }

    /// Finds the cells of each triangle's box; returns their total number.
    fn locate(&mut self, triangles: Triangles<'_>, lattice: &Lattice) -> u64 {
        // Where triangles share vertices, each vertex's cells are computed once: 3.2 ms instead of 7.7 ms for 270,000
        // triangles on two busy cores.
        let is_shared = 2 * triangles.positions.len() <= 3 * triangles.len();
        let positions = if is_shared { triangles.positions } else { &[] };
        let Self { vertices, boxes, chunks, .. } = self;
        resize(vertices, positions.len(), VertexCells::default);
        vertices.par_chunks_mut(CHUNK).zip(positions.par_chunks(CHUNK)).each(|(cells, positions)| {
            cells.iter_mut().zip(positions).for_each(|(cells, &position)| *cells = lattice.cells_at(position));
        });
        let vertices = &*vertices;
        resize(boxes, triangles.len(), || CellBox::EMPTY);
        let chunks = boxes.par_chunks_mut(CHUNK).zip(&*chunks).enumerate().map(|(index, (boxes, chunk))| {
            let is_sound = chunk.omitted.total() == 0;
            let mut references = 0;
            let ids = (index * CHUNK) as u32..;
            for (cells, id) in boxes.iter_mut().zip(ids) {
                let of_vertices = || triangles.indices[id as usize].map(|vertex| vertices[vertex as usize]);
                *cells = if is_shared && (is_sound || triangles.usable_corners(id).is_ok()) {
                    CellBox::around(of_vertices())
                } else if is_shared {
                    CellBox::EMPTY
                } else {
                    triangles.usable_corners(id).map_or(CellBox::EMPTY, |corners| lattice.cells_around(corners))
                };
                references += cells.len();
            }
            references
        });
        chunks.sum()
    }

    /// Counts each cell's triangles, two cells on, so that [`scatter`](Self::scatter) moves starts to their final positions.
    fn count(&mut self, triangles: Triangles<'_>, lattice: &Lattice) {
        let Self { starts, boxes, options, .. } = self;
        let len = lattice.len() + 2;
        starts.truncate(len);
        starts.par_chunks_mut(CHUNK_CELLS).each(|starts| starts.iter_mut().for_each(|start| *start.get_mut() = 0));
        resize(starts, len, AtomicU32::default);
        let starts = &*starts;
        for_each_reference(triangles, lattice, boxes, options.insertion, |cell, _| {
            starts[cell + 2].fetch_add(1, Relaxed);
        });
    }

    /// Sums the counts up, and makes room for all references.
    fn scan(&mut self) {
        let Self { starts, ids, sums, .. } = self;
        let references = scan(starts, sums);
        resize(ids, references as usize, AtomicU32::default);
    }

    /// Writes each triangle's id into its cells.
    fn scatter(&self, triangles: Triangles<'_>, lattice: &Lattice) {
        for_each_reference(triangles, lattice, &self.boxes, self.options.insertion, |cell, id| {
            let index = self.starts[cell + 1].fetch_add(1, Relaxed);
            self.ids[index as usize].store(id, Relaxed);
        });
    }
}

/// Resizes `items`. If that needs more memory, it takes a little more for later frames, but never twice as much.
pub(super) fn resize<T>(items: &mut Vec<T>, count: usize, item: fn() -> T) {
    if count > items.capacity() {
        items.reserve_exact(count + count / 64 - items.len());
    }
    items.resize_with(count, item);
}

/// Replaces counts by their running sums, and returns the last one.
pub(super) fn scan(starts: &mut [AtomicU32], sums: &mut Vec<u32>) -> u32 {
    // One part a thread. The last part's sum isn't needed, so a single thread reads nothing twice.
    let part = starts.len().div_ceil(rayon::current_num_threads()).max(CHUNK_CELLS);
    let all_but_last = &starts[..(starts.len() - 1) / part * part];
    let parts = all_but_last.par_chunks(part).map(|counts| counts.iter().map(|count| count.load(Relaxed)).sum());
    parts.collect_into_vec(sums);
    sums.insert(0, 0);
    for index in 1..sums.len() {
        sums[index] += sums[index - 1];
    }
    starts.par_chunks_mut(part).zip(&*sums).each(|(starts, &before)| {
        let mut sum = before;
        for start in starts {
            let start = start.get_mut();
            sum += *start;
            *start = sum;
        }
    });
    starts.last_mut().map_or(0, |last| *last.get_mut())
}

/// Calls `visit` with each cell's index and the id of each triangle in it, on all threads.
fn for_each_reference(
    triangles: Triangles<'_>,
    lattice: &Lattice,
    boxes: &[CellBox],
    insertion: Insertion,
    visit: impl Fn(usize, u32) + Sync,
) {
    boxes.par_chunks(CHUNK).enumerate().each(|(chunk, boxes)| {
        for (index, cells) in boxes.iter().enumerate() {
            let id = (chunk * CHUNK + index) as u32;
            for_each_cell(triangles, lattice, (id, cells), insertion, |cell| visit(cell, id));
        }
    });
}

/// Calls `visit` with the index of each cell that lists the triangle `id`, whose box overlaps `cells`.
#[inline(always)]
pub(super) fn for_each_cell(
    triangles: Triangles<'_>,
    lattice: &Lattice,
    (id, cells): (u32, &CellBox),
    insertion: Insertion,
    mut visit: impl FnMut(usize),
) {
    // A box of one or two cells mostly overlaps the triangle in each.
    if insertion == Insertion::Boxes || cells.len() <= 2 {
        return lattice.for_each_of(cells, |_, cell| visit(cell));
    }
    let triangle = ExactTriangle::new(lattice, triangles.corners(id));
    lattice.for_each_of(cells, |at, cell| {
        if triangle.overlaps(at) {
            visit(cell);
        }
    });
}

/// Sorts the ids of each cell, which threads may have written in any order. `starts` are the starts of the cells' ids,
/// counted so that `ids` begins with the first cell's; the last cell's ids end at `end`.
pub(super) fn sort(starts: &[AtomicU32], end: u32, mut ids: &mut [AtomicU32]) {
    if starts.len() > CHUNK_CELLS {
        let (low, high) = starts.split_at(starts.len() / 2);
        let (first, boundary) = (low[0].load(Relaxed), high[0].load(Relaxed));
        let (low_ids, high_ids) = ids.split_at_mut((boundary - first) as usize);
        both(|| sort(low, boundary, low_ids), || sort(high, end, high_ids));
        return;
    }
    for (cell, start) in starts.iter().enumerate() {
        let end = starts.get(cell + 1).map_or(end, |next| next.load(Relaxed));
        let (own, rest) = ids.split_at_mut((end - start.load(Relaxed)) as usize);
        if !own.is_sorted_by_key(|id| id.load(Relaxed)) {
            own.sort_unstable_by_key(|id| id.load(Relaxed));
        }
        ids = rest;
    }
}
