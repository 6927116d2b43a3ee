use std::ops::Range;

use crate::parallel::Parallel;
use rayon::prelude::*;

use super::lines::{Face, Lines};

/// Average lines of a tile, if they are spread evenly.
const TILE_LINES: usize = 160;

/// The largest number of lines in a tile; denser tiles are split.
pub(super) const MOST_LINES: usize = 1024;

/// The largest number of tiles along a side of a face.
const MOST_TILES: usize = 512;

/// Lines that a thread sorts into tiles at once.
const CHUNK: usize = 1 << 12;

/// Face of a line whose direction is zero or not finite.
const NOWHERE: u32 = u32::MAX;

/// Lines sorted into tiles of neighbours on the same face. 20 bytes a line.
#[derive(Debug, Default)]
pub(super) struct Spread {
    /// The face and position of each line: approximate, which is enough for sorting.
    crossings: Vec<Crossing>,
    keys: Vec<u32>,
    starts: Vec<u32>,
    pub(super) order: Vec<u32>,
    pub(super) tiles: Vec<LineTile>,
    /// The number of lines whose direction is zero or not finite.
    pub(super) nowhere: usize,
}

#[derive(Clone, Copy, Debug, Default)]
struct Crossing {
    at: [f32; 2],
    /// Number of the face, or [`NOWHERE`].
    face: u32,
}

#[derive(Clone, Debug)]
pub(super) struct LineTile {
    pub(super) face: Face,
    /// Range of `order`.
    pub(super) lines: Range<usize>,
}

/// The tiles of a face, which reaches from −1 to 1, given by the number along each side.
#[derive(Clone, Copy)]
struct Raster {
    side: usize,
}

impl Raster {
    /// A raster for this number of lines on a face.
    fn new(lines: usize) -> Self {
        let side = ((lines / TILE_LINES) as f32).sqrt().ceil().clamp(1.0, MOST_TILES as f32) as usize;
        Self { side }
    }

    fn tile(&self, at: [f32; 2]) -> usize {
        let [column, row] = at.map(|at| (((at + 1.0) * 0.5 * self.side as f32) as usize).min(self.side - 1));
        row * self.side + column
    }
}

impl Spread {
    /// Sorts lines into tiles.
    pub(super) fn spread(&mut self, lines: &Lines<'_>) {
        let count = lines.directions.len();
        let Self { crossings, keys, starts, order, tiles, nowhere } = self;
        let faces = &Face::CUBE;
        find_crossings(lines, crossings);
        // Most sets of lines don't cover all six faces.
        let raster = Raster::new(count / 3);
        let per_face = raster.side * raster.side;
        keys.resize(count, 0);
        keys.par_chunks_mut(CHUNK).zip(crossings.par_chunks(CHUNK)).each(|(keys, crossings)| {
            for (key, Crossing { at, face }) in keys.iter_mut().zip(crossings) {
                *key = if *face == NOWHERE { NOWHERE } else { face * per_face as u32 + raster.tile(*at) as u32 };
            }
        });
        let keyed = keys.iter().enumerate().filter(|(_, key)| **key != NOWHERE);
        starts.clear();
        starts.resize(faces.len() * per_face + 2, 0);
        keyed.clone().for_each(|(_, &key)| starts[key as usize + 2] += 1);
        let mut sum = 0;
        for start in starts.iter_mut() {
            sum += *start;
            *start = sum;
        }
        *nowhere = count - sum as usize;
        order.resize(sum as usize, 0);
        for (index, &key) in keyed {
            let next = &mut starts[key as usize + 1];
            order[*next as usize] = index as u32;
            *next += 1;
        }
        tiles.clear();
        for key in 0..faces.len() * per_face {
            let range = starts[key] as usize..starts[key + 1] as usize;
            let face = faces[key / per_face];
            split(lines, face, order, range, tiles);
        }
    }

    pub(super) fn bytes(&self) -> usize {
        self.crossings.capacity() * size_of::<Crossing>()
            + (self.keys.capacity() + self.starts.capacity() + self.order.capacity()) * size_of::<u32>()
            + self.tiles.capacity() * size_of::<LineTile>()
    }
}

/// Makes tiles of the lines of a face: halves them across the longer side while they are too many.
fn split(lines: &Lines<'_>, face: Face, order: &mut [u32], range: Range<usize>, tiles: &mut Vec<LineTile>) {
    if range.is_empty() {
        return;
    }
    if range.len() <= MOST_LINES {
        tiles.push(LineTile { face, lines: range });
        return;
    }
    let at = |line: u32| face.across(lines.get(line as usize));
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for &line in &order[range.clone()] {
        let at = at(line);
        for axis in [0, 1] {
            (low[axis], high[axis]) = (low[axis].min(at[axis]), high[axis].max(at[axis]));
        }
    }
    let axis = usize::from(high[1] - low[1] > high[0] - low[0]);
    let middle = range.start + range.len() / 2;
    if low[axis] < high[axis] {
        let of = &mut order[range.clone()];
        of.select_nth_unstable_by(middle - range.start, |&a, &b| at(a)[axis].total_cmp(&at(b)[axis]));
    }
    split(lines, face, order, range.start..middle, tiles);
    split(lines, face, order, middle..range.end, tiles);
}

/// Finds the face of each line and its position there.
fn find_crossings(lines: &Lines<'_>, crossings: &mut Vec<Crossing>) {
    crossings.resize(lines.directions.len(), Crossing::default());
    let of_chunks = crossings.par_chunks_mut(CHUNK).zip(lines.directions.par_chunks(CHUNK));
    of_chunks.each(|(crossings, directions)| {
        for (crossing, direction) in crossings.iter_mut().zip(directions) {
            let line = direction.as_dvec3();
            *crossing = match Face::of(line) {
                Some(face) => {
                    let at = Face::CUBE[face].across(line).map(|value| value as f32);
                    Crossing { at, face: face as u32 }
                }
                None => Crossing { at: [0.0; 2], face: NOWHERE },
            };
        }
    });
}
