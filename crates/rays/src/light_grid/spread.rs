use super::cells::{Axis, strip};
use super::pass::LightPass;
use super::pixel_map::{COLUMN, DEPTH, ONE, PixelMap, ROW};
use crate::shot::SeenImage;
use crate::simd::vectors::LANES;

/// About how many pixels are looked at. Each is a cache miss: twice as many spare 3 % of the cluster tests, and cost more.
const SAMPLES: usize = 1 << 12;

impl LightPass {
    /// Divides `self.face` into cells such that each has about as many points, going by a sample of the pixels.
    pub(crate) fn spread(&mut self, image: &SeenImage<'_>) {
        let Self { survey, face, cells, samples, .. } = self;
        let map = PixelMap::new(face, &survey.rays);
        for strips in samples.iter_mut() {
            strips.clear();
            strips.resize(Axis::STRIPS, 0);
        }
        let blocks = image.seen.inverse_depth.chunks_exact(LANES).enumerate();
        // An odd step goes through all columns of blocks.
        for (block, depths) in blocks.step_by((survey.slots / (LANES * SAMPLES)) | 1) {
            let lane = block % LANES;
            let depth = f64::from(depths[lane]);
            let (column, row) = survey.rays.order.column_and_row(block * LANES + lane);
            let s = if map.is_reciprocal { 1.0 / depth } else { depth };
            let of = |r: &[f64; 4]| r[COLUMN] * f64::from(column) + (r[ROW] * f64::from(row) + (r[ONE] + r[DEPTH] * s));
            let divisor = of(&map.rows[3]);
            let (x, y) = (of(&map.rows[0]) / divisor, of(&map.rows[1]) / divisor);
            // Also false for pixels that show nothing.
            if divisor > 0.0 && x.abs() <= 1.0 && y.abs() <= 1.0 {
                samples[0][strip(x as f32)] += 1;
                samples[1][strip(y as f32)] += 1;
            }
        }
        let expected = survey.tiles.iter().filter(|tile| face.may_own(tile));
        let points = expected.map(|tile| tile.points as usize).sum();
        cells.choose(points, [&samples[0], &samples[1]]);
    }
}
