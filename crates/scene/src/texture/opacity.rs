//! A texture's opacity, at points and around them.

use glam::Vec2;

use super::{Filter, Level, Texture, Wrap};

/// Half the distance from one to the next f32: the relative error of one rounding.
const HALF_ULP: f32 = f32::EPSILON / 2.0;

impl Texture {
    /// The opacity at `coords` in the full image, 0 … 1: what decides whether an alpha-masked point is there.
    #[must_use]
    pub fn opacity(&self, coords: Vec2) -> f32 {
        let [width, height] = self.size();
        self.opacity_at(coords * Vec2::new(width as f32, height as f32))
    }

    /// The opacity at coordinates counted in texels.
    fn opacity_at(&self, coords: Vec2) -> f32 {
        let level = &self.levels[0];
        let texel = |x: usize, y: usize| f32::from(level.texels[y * level.width as usize + x][3]) / 255.0;
        match self.filter {
            Filter::Nearest => {
                texel(self.wrap[0].nearest(coords.x, level.width), self.wrap[1].nearest(coords.y, level.height))
            }
            Filter::Linear => {
                let ([west, east], right) = self.wrap[0].mixed(coords.x, level.width);
                let ([north, south], down) = self.wrap[1].mixed(coords.y, level.height);
                let mix = |from: f32, to: f32, part: f32| from * (1.0 - part) + to * part;
                let upper = mix(texel(west, north), texel(east, north), right);
                let lower = mix(texel(west, south), texel(east, south), right);
                mix(upper, lower, down)
            }
        }
    }

    /// Bounds of what [`opacity`](Self::opacity) gives for coordinates that, counted in texels, are within `reach` of
    /// `coords` along each axis; `None` where that is too far to look at.
    #[inline]
    pub(crate) fn opacity_around(&self, coords: Vec2, reach: Vec2) -> Option<[f32; 2]> {
        // Beyond, texels could no longer be told apart.
        const FARTHEST: f32 = (1 << 22) as f32;
        const MOST_CELLS: i32 = 16;
        let middle = if self.filter == Filter::Linear { 0.5 } else { 0.0 };
        let (first, last) = ((coords - reach - middle).floor(), (coords + reach - middle).floor());
        if !(first.x > -FARTHEST && first.y > -FARTHEST && last.x < FARTHEST && last.y < FARTHEST) {
            return None;
        }
        let ([x0, y0], [x1, y1]) = ([first.x as i32, first.y as i32], [last.x as i32, last.y as i32]);
        if (x1 - x0 + 1).saturating_mul(y1 - y0 + 1) > MOST_CELLS {
            return None;
        }
        let cells = self.opacities.get_or_init(|| self.levels[0].opacities(self.filter, self.wrap));
        let [width, height] = self.size();
        let (mut least, mut greatest) = (u8::MAX, 0);
        for y in y0..=y1 {
            let row = self.wrap[1].cell(y, height, self.filter) * width as usize;
            for x in x0..=x1 {
                let [low, high] = cells[row + self.wrap[0].cell(x, width, self.filter)];
                (least, greatest) = (least.min(low), greatest.max(high));
            }
        }
        let [least, greatest] = [least, greatest].map(|byte| f32::from(byte) / 255.0);
        let (mut low, mut high) = (least, greatest);
        let spread = greatest - least;
        if spread > 0.0 && self.filter == Filter::Linear {
            // Along an axis it changes no faster than from one texel to the next.
            let change = spread * (reach.x + reach.y);
            let here = self.opacity_at(coords);
            (low, high) = (low.max(here - change), high.min(here + change));
        }
        // Each mix of two numbers up to one is wrong by at most four half ulps, so two results differ by 16 of them; the
        // rest is for the roundings of the bounds themselves.
        const ROUNDING: f32 = 32.0 * HALF_ULP;
        Some([(low - ROUNDING).max(0.0), high + ROUNDING])
    }
}

impl Level {
    /// For each upper left one of four texels that are mixed, the least and the greatest opacity of them.
    fn opacities(&self, filter: Filter, wrap: [Wrap; 2]) -> Vec<[u8; 2]> {
        let opacity = |x: u32, y: u32| self.texels[y as usize * self.width as usize + x as usize][3];
        let cells = (0..self.height).flat_map(|y| (0..self.width).map(move |x| (x, y)));
        let bounds = cells.map(|(x, y)| match filter {
            Filter::Nearest => [opacity(x, y); 2],
            Filter::Linear => {
                let (right, below) = (wrap[0].next(x, self.width), wrap[1].next(y, self.height));
                let four = [opacity(x, y), opacity(right, y), opacity(x, below), opacity(right, below)];
                four.into_iter().fold([u8::MAX, 0], |[least, greatest], one| [least.min(one), greatest.max(one)])
            }
        });
        bounds.collect()
    }
}
