use fearless_simd::prelude::*;
use fearless_simd::{Simd, dispatch, f64x8, i32x16};
use rayon::prelude::*;

use super::LightGrid;
use super::block::{Cells, cells_at};
use super::face::{CLASSES, Layer};
use super::lanes::{LANES, Vectors, minus, narrow, splat, splat_vector};
use super::locate::{CHUNK_PIXELS, Points};

/// A point on a layer. 20 bytes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Mapped {
    pub(super) x: f32,
    pub(super) y: f32,
    pub(super) nearness: f32,
    pub(super) pixel: u32,
    pub(super) cell: u32,
}

/// What a slab of the image's pixels holds.
#[derive(Default)]
pub(super) struct Slab {
    /// For each band of cells its points.
    pub(super) bands: Vec<Vec<Mapped>>,
    /// Pixels whose points belong to the face and to no class.
    pub(super) outliers: Vec<u32>,
    /// How many points belong to each class.
    pub(super) points_of_class: [u32; CLASSES],
}

impl Slab {
    pub(super) fn bytes(&self) -> usize {
        let bands: usize = self.bands.iter().map(Vec::capacity).sum();
        bands * size_of::<Mapped>() + self.outliers.capacity() * size_of::<u32>()
    }
}

impl LightGrid {
    /// Maps all points of `self.layer` and lists them by band.
    ///
    /// Slabs are the same from frame to frame, so that their lists' memory can be kept.
    pub(super) fn map(&mut self) {
        const SLABS_PER_THREAD: usize = 4;
        let Self { slabs, points, layer, cells, level, .. } = self;
        let count = SLABS_PER_THREAD * rayon::current_num_threads();
        slabs.resize_with(count, Slab::default);
        let chunks = points.boxes.len();
        slabs.par_iter_mut().enumerate().for_each(|(place, slab)| {
            if slab.bands.len() < cells.bands() {
                slab.bands.resize_with(cells.bands(), Vec::new);
            }
            slab.bands.iter_mut().for_each(Vec::clear);
            slab.outliers.clear();
            slab.points_of_class = Default::default();
            for chunk in place * chunks / count..(place + 1) * chunks / count {
                if points.boxes[chunk].points > 0 && layer.face.may_own(&points.boxes[chunk]) {
                    dispatch!(level.0, simd => map(simd, points, layer, cells, slab, chunk));
                }
            }
        });
    }
}

impl Slab {
    /// Adds a point to a band; memory grows by little, since there are many lists.
    #[inline(always)]
    fn push(&mut self, band: usize, point: Mapped) {
        let band = &mut self.bands[band];
        if band.len() == band.capacity() {
            band.reserve_exact(512);
        }
        band.push(point);
    }
}

/// Maps the points of a chunk of pixels.
#[inline(always)]
fn map<S: Simd>(simd: S, points: &Points, layer: &Layer, cells: &Cells, slab: &mut Slab, chunk: usize) {
    let first = chunk * CHUNK_PIXELS;
    let t = &points.t[first..(first + CHUNK_PIXELS).min(points.t.len())];
    let shift = cells.rows_per_band.trailing_zeros();
    let [scale_x, scale_y] = cells.scale();
    let (scale_x, scale_y) = (splat(simd, scale_x), splat(simd, scale_y));
    let columns = i32x16::splat(simd, cells.columns as i32);
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
        let [x, y, nearness] = narrow(low.at, high.at);
        let column = cells_at(simd, x, scale_x, cells.columns);
        let row = cells_at(simd, y, scale_y, cells.rows);
        let cell = (row * columns + column).to_array();
        let (row, x, y, nearness) = (row.to_array(), x.to_array(), y.to_array(), nearness.to_array());
        while members != 0 {
            let lane = members.trailing_zeros() as usize % LANES;
            members &= members - 1;
            let pixel = (first + lane) as u32;
            let point = Mapped { x: x[lane], y: y[lane], nearness: nearness[lane], pixel, cell: cell[lane] as u32 };
            slab.push((row[lane] >> shift) as usize, point);
        }
    }
}

/// Eight points on a face.
struct MappedEight<S: Simd> {
    at: Vectors<S>,
    /// Which belong to each class.
    classes: [u64; CLASSES],
    /// Which belong to the face and no class.
    lost: u64,
}

#[inline(always)]
fn map_eight<S: Simd>(simd: S, points: &Points, layer: &Layer, first: usize, t: f64x8<S>) -> MappedEight<S> {
    let face = &layer.face;
    let (origin, direction) = points.rays.eight(simd, first);
    let from = minus(origin, splat_vector(simd, face.origin));
    let v = [t.mul_add(direction[0], from[0]), t.mul_add(direction[1], from[1]), t.mul_add(direction[2], from[2])];
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
    let mut classes = [0; CLASSES];
    for (class, largest) in classes.iter_mut().zip(layer.limits) {
        let within = inside & slack.simd_le(f64x8::splat(simd, largest)).to_bitmask();
        *class = within & !below;
        below |= within;
    }
    MappedEight { at, classes, lost: is_point & !below }
}
