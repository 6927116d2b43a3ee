use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::lines::{Face, Lines, largest_axis};

/// Lines of a tile on average, where they are spread evenly over what they cover.
const TILE_LINES: usize = 160;

/// Most lines of a tile: where more are close together it is split.
pub(super) const MOST_LINES: usize = 1024;

/// Most tiles along a side of a face.
const MOST_TILES: usize = 512;

/// Lines that a thread finds the tiles of at once.
const CHUNK: usize = 1 << 12;

/// Stands for a line that goes nowhere.
const NOWHERE: u32 = u32::MAX;

/// Lines sorted to tiles: those of a tile are next to each other on the same face. 20 bytes a line.
#[derive(Debug, Default)]
pub(super) struct Spread {
    /// Where lines cross which face; roughly, which is enough to sort them.
    crossings: Vec<Crossing>,
    keys: Vec<u32>,
    starts: Vec<u32>,
    pub(super) order: Vec<u32>,
    pub(super) tiles: Vec<Tile>,
    /// How many lines go nowhere.
    pub(super) nowhere: usize,
}

#[derive(Clone, Copy, Debug, Default)]
struct Crossing {
    at: [f32; 2],
    /// Or [`NOWHERE`].
    face: u32,
}

#[derive(Clone, Debug)]
pub(super) struct Tile {
    pub(super) face: Face,
    /// Of `order`.
    pub(super) lines: Range<usize>,
}

/// The rectangle in which tiles are, and how many along each side.
#[derive(Clone, Copy)]
struct Raster {
    low: [f32; 2],
    scale: [f32; 2],
    side: usize,
}

impl Raster {
    fn new(low: [f32; 2], high: [f32; 2], lines: usize) -> Self {
        let side = ((lines / TILE_LINES) as f32).sqrt().ceil().clamp(1.0, MOST_TILES as f32) as usize;
        // Nothing where it has no size.
        let scale = [0, 1].map(|axis| {
            let scale = side as f32 / (high[axis] - low[axis]);
            if scale.is_finite() { scale } else { 0.0 }
        });
        Self { low, scale, side }
    }

    fn tile(&self, [u, v]: [f32; 2]) -> usize {
        let [column, row] =
            [(u, 0), (v, 1)].map(|(at, axis)| (((at - self.low[axis]) * self.scale[axis]) as usize).min(self.side - 1));
        row * self.side + column
    }
}

impl Spread {
    /// Sorts `count` lines to tiles.
    pub(super) fn spread(&mut self, lines: &Lines<'_>, count: usize) {
        let Self { crossings, keys, starts, order, tiles, nowhere } = self;
        let faces = lines.faces();
        let faces = &faces[..];
        let [low, high] = find_crossings(lines, faces, count, crossings);
        let raster = match faces {
            // Cubes are seen as wide as they are.
            [_, _, ..] => Raster::new([-1.0; 2], [1.0; 2], count / 3),
            _ => Raster::new(low, high, count),
        };
        let per_face = raster.side * raster.side;
        keys.resize(count, 0);
        keys.par_chunks_mut(CHUNK).zip(crossings.par_chunks(CHUNK)).for_each(|(keys, crossings)| {
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
            + self.tiles.capacity() * size_of::<Tile>()
    }
}

/// Makes tiles of lines of a face: halves of them, across the longer side, while they are too many.
fn split(lines: &Lines<'_>, face: Face, order: &mut [u32], range: Range<usize>, tiles: &mut Vec<Tile>) {
    if range.is_empty() {
        return;
    }
    if range.len() <= MOST_LINES {
        tiles.push(Tile { face, lines: range });
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

/// Finds where lines cross which face; between what all do.
fn find_crossings(lines: &Lines<'_>, faces: &[Face], count: usize, crossings: &mut Vec<Crossing>) -> [[f32; 2]; 2] {
    crossings.resize(count, Crossing::default());
    let bounds = crossings.par_chunks_mut(CHUNK).enumerate().map(|(chunk, crossings)| {
        let first = chunk * CHUNK;
        // The kind of lines is asked once for all of them, not for each.
        match *lines {
            Lines::Directions { directions, .. } => {
                cross(faces, directions[first..].iter().map(|direction| direction.as_dvec3()), crossings)
            }
            Lines::Points { points, .. } => {
                let origin = lines.origin();
                cross(faces, points[first..].iter().map(|of| of.point.position - origin), crossings)
            }
        }
    });
    let nothing = || [[f32::INFINITY; 2], [f32::NEG_INFINITY; 2]];
    bounds.reduce(nothing, |[low, high], [other_low, other_high]| {
        [[0, 1].map(|axis| low[axis].min(other_low[axis])), [0, 1].map(|axis| high[axis].max(other_high[axis]))]
    })
}

/// Finds where some lines cross which face; between what those do that do so at numbers.
#[inline]
fn cross(faces: &[Face], lines: impl Iterator<Item = DVec3>, crossings: &mut [Crossing]) -> [[f32; 2]; 2] {
    let (mut low, mut high) = ([f32::INFINITY; 2], [f32::NEG_INFINITY; 2]);
    for (crossing, line) in crossings.iter_mut().zip(lines) {
        let Some(face) = face_of(faces, line) else {
            crossing.face = NOWHERE;
            continue;
        };
        let at = faces[face].across(line).map(|value| value as f32);
        *crossing = Crossing { at, face: face as u32 };
        if at[0].is_finite() && at[1].is_finite() {
            for axis in [0, 1] {
                (low[axis], high[axis]) = (low[axis].min(at[axis]), high[axis].max(at[axis]));
            }
        }
    }
    [low, high]
}

/// Which of the faces a line goes through.
#[inline]
fn face_of(faces: &[Face], line: DVec3) -> Option<usize> {
    if !line.is_finite() {
        return None;
    }
    if faces.len() == 1 {
        return Some(0);
    }
    (line != DVec3::ZERO).then(|| {
        let axis = largest_axis(line);
        axis * 2 + usize::from(line[axis] < 0.0)
    })
}
