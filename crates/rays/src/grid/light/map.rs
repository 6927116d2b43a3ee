use std::sync::atomic::{AtomicUsize, Ordering};

use fearless_simd::prelude::*;
use fearless_simd::{Simd, dispatch, f32x16, f64x8, i32x16};
use rayon::prelude::*;

use super::LightGrid;
use super::block::Cells;
use super::face::Layer;
use super::lanes::LANES;
use super::locate::{CHUNK_PIXELS, Points};

/// A point on a layer. 16 bytes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Mapped {
    pub(super) x: f32,
    pub(super) y: f32,
    pub(super) nearness: f32,
    pub(super) pixel: u32,
}

/// What one thread has mapped.
#[derive(Default)]
pub(super) struct Slab {
    /// For each band of cells its points.
    pub(super) bands: Vec<Vec<Mapped>>,
    /// Pixels whose points belong to the face and to no class.
    pub(super) outliers: Vec<u32>,
    /// How many points belong to each class.
    pub(super) points_of_class: [u32; Layer::CLASSES.len()],
}

impl Slab {
    pub(super) fn bytes(&self) -> usize {
        let bands: usize = self.bands.iter().map(Vec::capacity).sum();
        bands * size_of::<Mapped>() + self.outliers.capacity() * size_of::<u32>()
    }
}

impl LightGrid {
    /// Maps all points of `self.layer` and lists them by band.
    pub(super) fn map(&mut self) {
        let Self { slabs, points, layer, cells, .. } = self;
        slabs.resize_with(rayon::current_num_threads(), Slab::default);
        let (next, level) = (AtomicUsize::new(0), self.level.0);
        slabs.par_iter_mut().for_each(|slab| {
            if slab.bands.len() < cells.bands() {
                slab.bands.resize_with(cells.bands(), Vec::new);
            }
            slab.bands.iter_mut().for_each(Vec::clear);
            slab.outliers.clear();
            slab.points_of_class = Default::default();
            loop {
                let chunk = next.fetch_add(1, Ordering::Relaxed);
                let Some(bounds) = points.boxes.get(chunk) else { break };
                if bounds.points > 0 {
                    dispatch!(level, simd => map(simd, points, layer, cells, slab, chunk));
                }
            }
        });
    }
}

/// Maps the points of a chunk of pixels.
#[inline(always)]
fn map<S: Simd>(simd: S, points: &Points, layer: &Layer, cells: &Cells, slab: &mut Slab, chunk: usize) {
    let first = chunk * CHUNK_PIXELS;
    let t = &points.t[first..(first + CHUNK_PIXELS).min(points.t.len())];
    let shift = cells.rows_per_band.trailing_zeros();
    let scale = f32x16::splat(simd, cells.scale()[1]);
    let last = i32x16::splat(simd, cells.rows as i32 - 1);
    for (group, t) in t.chunks(LANES).enumerate() {
        let first = first + group * LANES;
        let mut padded = [f64::NAN; LANES];
        padded[..t.len()].copy_from_slice(t);
        let (low, high) = padded.split_at(8);
        let low = map_eight(simd, points, layer, first, f64x8::from_slice(simd, low));
        let high = map_eight(simd, points, layer, first + 8, f64x8::from_slice(simd, high));
        for (class, count) in slab.points_of_class.iter_mut().enumerate() {
            *count += (low.classes[class] | high.classes[class] << 8).count_ones();
        }
        let lost = low.lost | high.lost << 8;
        if lost != 0 {
            slab.outliers.extend((0..LANES).filter(|lane| lost >> lane & 1 == 1).map(|lane| (first + lane) as u32));
        }
        let mut members = low.classes[layer.class] | high.classes[layer.class] << 8;
        if members == 0 {
            continue;
        }
        let [x, y, nearness] = [0, 1, 2].map(|axis| low.at[axis].narrow(high.at[axis]));
        let rows: i32x16<S> = (y * scale + scale).to_int();
        let bands = rows.max(i32x16::splat(simd, 0)).min(last).to_array();
        let (x, y, nearness) = (x.to_array(), y.to_array(), nearness.to_array());
        while members != 0 {
            let lane = members.trailing_zeros() as usize;
            members &= members - 1;
            let point = Mapped { x: x[lane], y: y[lane], nearness: nearness[lane], pixel: (first + lane) as u32 };
            slab.bands[(bands[lane] >> shift) as usize].push(point);
        }
    }
}

/// Eight points on a face.
struct MappedEight<S: Simd> {
    at: [f64x8<S>; 3],
    /// Which belong to each class.
    classes: [u64; Layer::CLASSES.len()],
    /// Which belong to the face and no class.
    lost: u64,
}

#[inline(always)]
fn map_eight<S: Simd>(simd: S, points: &Points, layer: &Layer, first: usize, t: f64x8<S>) -> MappedEight<S> {
    let face = &layer.face;
    let (origin, direction) = points.rays.eight(simd, first);
    let at = |axis: usize| t.mul_add(direction[axis], origin[axis] - face.origin.to_array()[axis]);
    let v = [at(0), at(1), at(2)];
    let is_point = t.simd_eq(t) & face.owns(simd, v);
    let (at, inverse) = face.project(simd, v);
    let one = f64x8::splat(simd, 1.0);
    let is_inside = at[0].abs().simd_le(one)
        & at[1].abs().simd_le(one)
        & inverse.simd_gt(f64x8::splat(simd, 0.0))
        & at[2].abs().simd_lt(f64x8::splat(simd, 1e15));
    let slack = layer.point_errors.slack(t, inverse);
    let is_point = is_point.to_bitmask();
    let inside = is_point & is_inside.to_bitmask();
    let mut below = 0;
    let classes = Layer::CLASSES.map(|largest| {
        let within = inside & slack.simd_le(f64x8::splat(simd, largest)).to_bitmask();
        let class = within & !below;
        below |= within;
        class
    });
    MappedEight { at, classes, lost: is_point & !below }
}
