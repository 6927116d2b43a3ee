use glam::{DVec4, Vec3};

use crate::Image;

/// At most 256 colours that represent a picture's, and their mixtures. Like all colours here, they are weighted by the
/// visibility of differences.
pub(crate) struct Palette {
    colors: Vec<Vec3>,
    /// For each coarse colour, the two palette colours to mix it from; filled on demand.
    mixtures: Vec<Option<[u8; 2]>>,
}

/// Colours that share the upper five bits of each channel.
struct Bin {
    mean: Vec3,
    count: f32,
}

const MAX_COLORS: usize = 256;

/// Visibility of a difference of one level in each channel.
const WEIGHTS: Vec3 = Vec3::new(1.732_050_8, 2.0, std::f32::consts::SQRT_2);

/// The bits of each channel that choose the two colours to mix; the proportion follows from the exact colour.
const MIXTURE_BITS: u32 = 6;

impl Palette {
    /// The palette of one picture: median cut by variance (Wu 1991).
    pub(crate) fn of(image: &Image) -> Self {
        // Written colours are whole levels, so errors must be measured from them.
        let colors = cut(bins(image)).into_iter().map(|color| (color / WEIGHTS).round() * WEIGHTS).collect();
        Self { colors, mixtures: vec![None; 1 << (3 * MIXTURE_BITS)] }
    }

    /// Red, green and blue of each colour in turn.
    pub(crate) fn bytes(&self) -> Vec<u8> {
        let levels = self.colors.iter().flat_map(|&color| (color / WEIGHTS).round().to_array());
        levels.map(|level| level as u8).collect()
    }

    /// The palette's colour for `pixel` at column `x` and row `y`: one of two, in the proportion that mixes to the pixel's
    /// own colour over 8 by 8 pixels (Bayer 1973).
    pub(crate) fn pick(&mut self, pixel: [u16; 3], x: usize, y: usize) -> u8 {
        let color = color_of(pixel);
        let mixture = &mut self.mixtures[coarse(pixel, MIXTURE_BITS)];
        let [near, far] = *mixture.get_or_insert_with(|| self::mixture(&self.colors, color));
        let share = share_of_far(self.colors[usize::from(near)], self.colors[usize::from(far)], color);
        if share > threshold(x, y) { far } else { near }
    }
}

fn color_of(pixel: [u16; 3]) -> Vec3 {
    Vec3::from(pixel.map(f32::from)) / 257.0 * WEIGHTS
}

/// The upper `bits` of each channel, together.
fn coarse(pixel: [u16; 3], bits: u32) -> usize {
    pixel.into_iter().fold(0, |index, level| index << bits | usize::from(level) >> (16 - bits))
}

fn bins(image: &Image) -> Vec<Bin> {
    const BITS: u32 = 5;
    let mut sums = vec![DVec4::ZERO; 1 << (3 * BITS)];
    for &pixel in &image.pixels {
        let [red, green, blue] = pixel.map(f64::from);
        sums[coarse(pixel, BITS)] += DVec4::new(red, green, blue, 1.0);
    }
    let used = sums.into_iter().filter(|sum| sum.w > 0.0);
    let mean = |sum: DVec4| (sum.truncate() / sum.w / 257.0).as_vec3() * WEIGHTS;
    used.map(|sum| Bin { mean: mean(sum), count: sum.w as f32 }).collect()
}

/// Bins that will become one colour.
struct Group {
    bins: Vec<Bin>,
    mean: Vec3,
    /// The bins' squared error along each axis.
    error: Vec3,
}

impl Group {
    fn new(bins: Vec<Bin>) -> Self {
        let count: f32 = bins.iter().map(|bin| bin.count).sum();
        let mean = bins.iter().map(|bin| bin.mean * bin.count).sum::<Vec3>() / count;
        let error = bins.iter().map(|bin| (bin.mean - mean) * (bin.mean - mean) * bin.count).sum();
        Self { bins, mean, error }
    }
}

/// Halves the group with the largest error, at its mean, until there is one for each colour of the palette.
fn cut(bins: Vec<Bin>) -> Vec<Vec3> {
    if bins.is_empty() {
        return vec![Vec3::ZERO];
    }
    let mut groups = vec![Group::new(bins)];
    while groups.len() < MAX_COLORS {
        let splittable = groups.iter().enumerate().filter(|(_, group)| group.bins.len() > 1);
        let errors = splittable.map(|(index, group)| (index, group.error.element_sum()));
        let Some((worst, _)) = errors.max_by(|(_, a), (_, b)| a.total_cmp(b)) else { break };
        let Group { mut bins, mean, error } = groups.swap_remove(worst);
        let axis = error.max_position();
        bins.sort_by(|a, b| a.mean[axis].total_cmp(&b.mean[axis]));
        let below = bins.partition_point(|bin| bin.mean[axis] < mean[axis]);
        // Rounding may put the mean outside of colours that hardly differ.
        let above = bins.split_off(below.clamp(1, bins.len() - 1));
        groups.extend([Group::new(bins), Group::new(above)]);
    }
    groups.into_iter().map(|group| group.mean).collect()
}

/// The index of the least error, the first of several.
fn least(errors: impl Iterator<Item = f32>) -> usize {
    let mut best = (0, f32::INFINITY);
    for (index, error) in errors.enumerate() {
        best = if error < best.1 { (index, error) } else { best };
    }
    best.0
}

/// The colour nearest to `wanted`, and the one that mixes with it to the least error.
fn mixture(colors: &[Vec3], wanted: Vec3) -> [u8; 2] {
    /// Weight of the squared distance of two mixed colours, beside the squared error of their mean: without it, single
    /// specks of a far colour appear.
    const GRAIN: f32 = 0.05;
    let index = least(colors.iter().map(|color| color.distance_squared(wanted)));
    let near = colors[index];
    let errors = colors.iter().enumerate().map(|(other, &far)| {
        let mixed = near.lerp(far, share_of_far(near, far, wanted));
        let error = mixed.distance_squared(wanted) + GRAIN * far.distance_squared(near);
        if other == index { f32::INFINITY } else { error }
    });
    [index as u8, least(errors) as u8]
}

/// The share of `far`, 0 … 1, that mixed into `near` comes closest to `wanted`.
fn share_of_far(near: Vec3, far: Vec3, wanted: Vec3) -> f32 {
    let way = far - near;
    let length_squared = way.length_squared();
    if length_squared > 0.0 { ((wanted - near).dot(way) / length_squared).clamp(0.0, 1.0) } else { 0.0 }
}

/// Bayer's 8 by 8 matrix: 64 evenly spaced values inside 0 … 1, each once.
fn threshold(x: usize, y: usize) -> f32 {
    let mut rank = 0;
    for bit in 0..3 {
        let (x, y) = (x >> bit & 1, y >> bit & 1);
        rank = rank << 2 | (x ^ y) << 1 | y;
    }
    (rank as f32 + 0.5) / 64.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thresholds_are_each_there_once() {
        let mut ranks: Vec<u32> = (0..64).map(|pixel| (threshold(pixel % 8, pixel / 8) * 64.0) as u32).collect();
        assert_eq!(ranks[..4], [0, 32, 8, 40], "the first row begins as Bayer's");
        ranks.sort_unstable();
        assert_eq!(ranks, (0..64).collect::<Vec<u32>>());
    }

    #[test]
    fn few_colours_are_kept_exactly() {
        let pixels = (0..256_u16).map(|pixel| [pixel % 16 * 17, pixel / 16 * 17, 128].map(|level| level * 257));
        let image = Image { width: 16, height: 16, pixels: pixels.collect(), ..Image::default() };
        let mut palette = Palette::of(&image);
        let bytes = palette.bytes();
        for (index, &pixel) in image.pixels.iter().enumerate() {
            let color = usize::from(palette.pick(pixel, index % 16, index / 16));
            let shown: [u8; 3] = bytes[3 * color..3 * color + 3].try_into().unwrap();
            assert_eq!(shown.map(|level| u16::from(level) * 257), pixel);
        }
    }

    #[test]
    fn an_empty_picture_has_a_palette() {
        assert_eq!(Palette::of(&Image::default()).bytes(), [0, 0, 0]);
    }
}
