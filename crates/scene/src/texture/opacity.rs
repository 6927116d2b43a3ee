//! A texture's opacity at a point, and its bounds around a point.

use glam::Vec2;

use super::wrap::floor;
use super::{Filter, Texture};

/// Half the distance from one to the next f32: the relative error of one rounding.
const HALF_ULP: f32 = f32::EPSILON / 2.0;

/// Beyond this, f32 can't tell texels apart.
const FARTHEST: f32 = (1 << 22) as f32;

/// Each mix of two numbers up to one has an error of at most four half ulps, so two results differ by at most 16; the rest
/// covers the rounding of the bounds themselves.
const ROUNDING: f32 = 32.0 * HALF_ULP;

/// The first and the last texel around each of sixteen points, along each axis.
pub(crate) struct TexelRanges {
    middle: f32,
    x: [[i32; 16]; 2],
    y: [[i32; 16]; 2],
}

impl TexelRanges {
    pub(crate) fn new(filter: Filter) -> Self {
        Self { middle: middle(filter), x: [[0; 16]; 2], y: [[0; 16]; 2] }
    }

    /// Sets a point's, from its coordinates and the reach around it; returns whether they have a meaning.
    #[inline]
    pub(crate) fn set(&mut self, lane: usize, coords: Vec2, reach: Vec2) -> bool {
        let (first, last) = (coords - reach - self.middle, coords + reach - self.middle);
        (self.x[0][lane], self.x[1][lane]) = (near_floor(first.x), near_floor(last.x));
        (self.y[0][lane], self.y[1][lane]) = (near_floor(first.y), near_floor(last.y));
        (first.x > -FARTHEST) & (first.y > -FARTHEST) & (last.x < FARTHEST) & (last.y < FARTHEST)
    }
}

/// The floor of a number of less than [`FARTHEST`]; others have some result.
#[inline]
fn near_floor(value: f32) -> i32 {
    // In this binade f32 has the integers alone, so the sum is rounded to one and its bits count them.
    const INTEGERS: f32 = (3 << 22) as f32;
    let sum = value + INTEGERS;
    let nearest = sum.to_bits().wrapping_sub(INTEGERS.to_bits()) as i32;
    nearest.wrapping_sub(i32::from(sum - INTEGERS > value))
}

/// The distance from a texel's lower edge to the point where it is read alone.
fn middle(filter: Filter) -> f32 {
    if filter == Filter::Linear { 0.5 } else { 0.0 }
}

impl Texture {
    /// The opacity at `coords` in the full image, 0 … 1, which is compared with the cutoff of alpha masks.
    #[must_use]
    pub fn opacity(&self, coords: Vec2) -> f32 {
        let [width, height] = self.size();
        self.opacity_at(coords * Vec2::new(width as f32, height as f32))
    }

    /// The opacity at coordinates in texels.
    fn opacity_at(&self, coords: Vec2) -> f32 {
        let level = &self.levels[0];
        let opacity = |texel: [u8; 4]| f32::from(texel[3]) / 255.0;
        match self.filter {
            Filter::Nearest => {
                let x = self.wrap[0].nearest(coords.x, level.width);
                opacity(level.texel(x, self.wrap[1].nearest(coords.y, level.height)))
            }
            Filter::Linear => {
                let (columns, right) = self.wrap[0].mixed(coords.x, level.width);
                let (rows, down) = self.wrap[1].mixed(coords.y, level.height);
                let mix = |from: f32, to: f32, part: f32| from * (1.0 - part) + to * part;
                level.mixed(columns, rows, |four| {
                    let [upper, lower] = four.map(|row| {
                        let [west, east] = row.map(opacity);
                        mix(west, east, right)
                    });
                    mix(upper, lower, down)
                })
            }
        }
    }

    /// Bounds of [`opacity`](Self::opacity) over all points within `reach` of `coords` along each axis, both in texels;
    /// `None` where that covers too many texels or is too far away.
    #[inline]
    pub(crate) fn opacity_around(&self, coords: Vec2, reach: Vec2) -> Option<[f32; 2]> {
        const MOST_CELLS: i32 = 16;
        let middle = middle(self.filter);
        let (first, last) = (coords - reach - middle, coords + reach - middle);
        if !(first.x > -FARTHEST && first.y > -FARTHEST && last.x < FARTHEST && last.y < FARTHEST) {
            return None;
        }
        let ([x0, y0], [x1, y1]) = ([floor(first.x), floor(first.y)], [floor(last.x), floor(last.y)]);
        if (x1 - x0 + 1).saturating_mul(y1 - y0 + 1) > MOST_CELLS {
            return None;
        }
        let [width, height] = self.size();
        let cells = self.cells();
        let (mut least, mut greatest) = (u8::MAX, 0);
        for y in y0..=y1 {
            let y = self.wrap[1].cell(y, height, self.filter);
            for x in x0..=x1 {
                let x = self.wrap[0].cell(x, width, self.filter);
                let [low, high] = cells.map_or_else(|| self.cell(x, y), |cells| cells[y * width as usize + x]);
                (least, greatest) = (least.min(low), greatest.max(high));
            }
        }
        let [least, greatest] = [least, greatest].map(|byte| f32::from(byte) / 255.0);
        let (mut low, mut high) = (least, greatest);
        let spread = greatest - least;
        if spread > 0.0 && self.filter == Filter::Linear {
            // Per axis, the slope is at most `spread` per texel.
            let change = spread * (reach.x + reach.y);
            let here = self.opacity_at(coords);
            (low, high) = (low.max(here - change), high.min(here + change));
        }
        Some([(low - ROUNDING).max(0.0), high + ROUNDING])
    }

    /// Bounds of [`opacity`](Self::opacity) in the texels around a point, where these are at most two along each axis; wider
    /// than those of [`opacity_around`](Self::opacity_around). `None` for textures on demand, too.
    #[inline]
    pub(crate) fn opacity_of_cells(&self, ranges: &TexelRanges, lane: usize) -> Option<[f32; 2]> {
        let ([x0, x1], [y0, y1]) = (ranges.x.map(|ends| ends[lane]), ranges.y.map(|ends| ends[lane]));
        if x1 - x0 > 1 || y1 - y0 > 1 {
            return None;
        }
        let (cells, [width, height]) = (self.cells()?, self.size());
        let column = |x: i32| self.wrap[0].cell(x, width, self.filter);
        let row = |y: i32| self.wrap[1].cell(y, height, self.filter) * width as usize;
        let (left, above) = (column(x0), row(y0));
        let [mut least, mut greatest] = cells[above + left];
        let mut join = |[low, high]: [u8; 2]| (least, greatest) = (least.min(low), greatest.max(high));
        if x1 > x0 || y1 > y0 {
            let (right, below) = (if x1 > x0 { column(x1) } else { left }, if y1 > y0 { row(y1) } else { above });
            [above + right, below + left, below + right].into_iter().for_each(|at| join(cells[at]));
        }
        let [least, greatest] = [least, greatest].map(|byte| f32::from(byte) / 255.0);
        Some([(least - ROUNDING).max(0.0), greatest + ROUNDING])
    }

    /// The results of [`cell`](Self::cell) for all texels; `None` for textures on demand.
    #[inline]
    fn cells(&self) -> Option<&[[u8; 2]]> {
        let level = &self.levels[0];
        level.pool().is_none().then(|| {
            &**self.opacities.get_or_init(|| {
                let rows = 0..level.height as usize;
                let all = rows.flat_map(|y| (0..level.width as usize).map(move |x| (x, y)));
                all.map(|(x, y)| self.cell(x, y)).collect()
            })
        })
    }

    /// Minimum and maximum opacity of the four mixed texels with the given upper left one; without filtering, of that
    /// texel alone.
    fn cell(&self, x: usize, y: usize) -> [u8; 2] {
        let level = &self.levels[0];
        match self.filter {
            Filter::Nearest => [level.texel(x, y)[3]; 2],
            Filter::Linear => {
                let columns = [x, self.wrap[0].next(x as u32, level.width) as usize];
                let rows = [y, self.wrap[1].next(y as u32, level.height) as usize];
                level.mixed(columns, rows, |four| {
                    let opacities = four.as_flattened().iter().map(|texel| texel[3]);
                    opacities.fold([u8::MAX, 0], |[least, greatest], one| [least.min(one), greatest.max(one)])
                })
            }
        }
    }
}
