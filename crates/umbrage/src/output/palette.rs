use crate::Image;

/// A colour of 0 … 255 a channel.
type Color = [f32; 3];

/// At most 256 colours that stand for a picture's, and how to mix them.
pub(crate) struct Palette {
    colors: Vec<Color>,
    /// For each coarse colour, the two palette colours to mix it from, once that has been asked for.
    mixtures: Vec<Option<[u8; 2]>>,
}

/// Colours that are alike in the upper five bits of each channel.
#[derive(Clone, Copy)]
struct Bin {
    mean: Color,
    count: f32,
}

const MAX_COLORS: usize = 256;

/// How much a difference in each channel is seen.
const WEIGHTS: Color = [3.0, 4.0, 2.0];

/// Bits a channel that decide which two colours are mixed; the proportion follows from the exact colour.
const MIXTURE_BITS: u32 = 6;

impl Palette {
    /// The palette of one picture: median cut by variance (Wu 1991), then refined as k-means does.
    pub(crate) fn of(image: &Image) -> Self {
        const REFINEMENTS: u32 = 3;
        let bins = bins(image);
        let mut colors = cut(bins.clone());
        for _ in 0..REFINEMENTS {
            refine(&mut colors, &bins);
        }
        // What is written is whole levels: errors must be measured from them.
        let colors = colors.into_iter().map(|color| color.map(f32::round)).collect();
        Self { colors, mixtures: vec![None; 1 << (3 * MIXTURE_BITS)] }
    }

    /// Red, green and blue of each colour in turn.
    pub(crate) fn bytes(&self) -> Vec<u8> {
        self.colors.iter().flatten().map(|&level| level as u8).collect()
    }

    /// The colour that stands for `pixel` at column `x` and row `y`: one of two, in the proportion that mixes to the
    /// pixel's own colour over 8 by 8 pixels (Bayer 1973).
    pub(crate) fn pick(&mut self, pixel: [u16; 3], x: usize, y: usize) -> u8 {
        let color = color_of(pixel);
        let coarse = pixel.map(|level| u32::from(level) >> (16 - MIXTURE_BITS));
        let index = coarse.into_iter().fold(0, |index, level| index << MIXTURE_BITS | level) as usize;
        let [near, far] = match self.mixtures[index] {
            Some(mixture) => mixture,
            None => *self.mixtures[index].insert(mixture(&self.colors, color)),
        };
        let share = share_of_far(self.colors[usize::from(near)], self.colors[usize::from(far)], color);
        if share > threshold(x, y) { far } else { near }
    }
}

fn color_of(pixel: [u16; 3]) -> Color {
    pixel.map(|level| f32::from(level) / 257.0)
}

fn minus(a: Color, b: Color) -> Color {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// The weighted dot product.
fn dot(a: Color, b: Color) -> f32 {
    WEIGHTS[0] * a[0] * b[0] + WEIGHTS[1] * a[1] * b[1] + WEIGHTS[2] * a[2] * b[2]
}

fn squared_distance(a: Color, b: Color) -> f32 {
    let difference = minus(a, b);
    dot(difference, difference)
}

fn bins(image: &Image) -> Vec<Bin> {
    const BITS: u32 = 5;
    let mut sums = vec![([0_u64; 3], 0_u32); 1 << (3 * BITS)];
    for pixel in &image.pixels {
        let bin = pixel.iter().fold(0, |bin, &level| bin << BITS | u32::from(level) >> (16 - BITS));
        let (sum, count) = &mut sums[bin as usize];
        *sum = std::array::from_fn(|channel| sum[channel] + u64::from(pixel[channel]));
        *count += 1;
    }
    let used = sums.into_iter().filter(|(_, count)| *count > 0);
    used.map(|(sum, count)| Bin {
        mean: sum.map(|level| (level as f64 / f64::from(count) / 257.0) as f32),
        count: count as f32,
    })
    .collect()
}

/// The count-weighted mean of `bins`, and their squared error from it along each channel.
fn spread(bins: &[Bin]) -> (Color, Color) {
    let count: f32 = bins.iter().map(|bin| bin.count).sum();
    let mean = std::array::from_fn(|axis| bins.iter().map(|bin| bin.mean[axis] * bin.count).sum::<f32>() / count);
    let error = std::array::from_fn(|axis| {
        bins.iter().map(|bin| WEIGHTS[axis] * bin.count * (bin.mean[axis] - mean[axis]).powi(2)).sum()
    });
    (mean, error)
}

/// Halves the group with the largest error, at its mean, until there is one for each colour of the palette.
fn cut(bins: Vec<Bin>) -> Vec<Color> {
    struct Group {
        bins: Vec<Bin>,
        mean: Color,
        error: Color,
    }
    let group = |bins: Vec<Bin>| {
        let (mean, error) = spread(&bins);
        Group { bins, mean, error }
    };
    if bins.is_empty() {
        return vec![[0.0; 3]];
    }
    let mut groups = vec![group(bins)];
    while groups.len() < MAX_COLORS {
        let total = |group: &Group| group.error.iter().sum::<f32>();
        let splittable = groups.iter().enumerate().filter(|(_, group)| group.bins.len() > 1);
        let Some((worst, _)) = splittable.max_by(|(_, a), (_, b)| total(a).total_cmp(&total(b))) else { break };
        let Group { bins, mean, error } = groups.swap_remove(worst);
        let axis = if error[0] >= error[1] && error[0] >= error[2] { 0 } else { 1 + usize::from(error[2] > error[1]) };
        let (below, above): (Vec<Bin>, Vec<Bin>) = bins.iter().partition(|bin| bin.mean[axis] < mean[axis]);
        if below.is_empty() || above.is_empty() {
            // Rounding put the mean outside of colours that hardly differ.
            let half = bins.len() / 2;
            groups.push(group(bins[..half].to_vec()));
            groups.push(group(bins[half..].to_vec()));
        } else {
            groups.push(group(below));
            groups.push(group(above));
        }
    }
    groups.into_iter().map(|group| group.mean).collect()
}

/// Moves each colour to the mean of the bins that are nearest to it.
fn refine(colors: &mut [Color], bins: &[Bin]) {
    let mut sums = vec![([0.0_f32; 3], 0.0_f32); colors.len()];
    for bin in bins {
        let (sum, count) = &mut sums[nearest(colors, bin.mean)];
        *sum = std::array::from_fn(|axis| sum[axis] + bin.mean[axis] * bin.count);
        *count += bin.count;
    }
    for (color, (sum, count)) in colors.iter_mut().zip(sums) {
        if count > 0.0 {
            *color = sum.map(|level| level / count);
        }
    }
}

fn nearest(colors: &[Color], wanted: Color) -> usize {
    let mut best = (0, f32::INFINITY);
    for (index, &color) in colors.iter().enumerate() {
        let distance = squared_distance(color, wanted);
        if distance < best.1 {
            best = (index, distance);
        }
    }
    best.0
}

/// The colour nearest to `wanted`, and the one that mixes with it to the least error.
fn mixture(colors: &[Color], wanted: Color) -> [u8; 2] {
    /// How much the squared distance of two mixed colours counts beside the squared error of their mean: without it,
    /// single specks of a far colour appear.
    const GRAIN: f32 = 0.05;
    let near = nearest(colors, wanted);
    let mut best = (near, f32::INFINITY);
    for (index, &far) in colors.iter().enumerate().filter(|(index, _)| *index != near) {
        let share = share_of_far(colors[near], far, wanted);
        let mixed: Color = std::array::from_fn(|axis| colors[near][axis] + share * (far[axis] - colors[near][axis]));
        let error = squared_distance(mixed, wanted) + GRAIN * squared_distance(far, colors[near]);
        if error < best.1 {
            best = (index, error);
        }
    }
    [near as u8, best.0 as u8]
}

/// How much of `far` mixed into `near` comes closest to `wanted`, 0 … 1.
fn share_of_far(near: Color, far: Color, wanted: Color) -> f32 {
    let way = minus(far, near);
    let length_squared = dot(way, way);
    if length_squared > 0.0 { (dot(minus(wanted, near), way) / length_squared).clamp(0.0, 1.0) } else { 0.0 }
}

/// Bayer's 8 by 8 matrix: each of 64 evenly spaced values inside 0 … 1 once.
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
        let image = Image { width: 16, height: 16, pixels: pixels.collect() };
        let mut palette = Palette::of(&image);
        let bytes = palette.bytes();
        for (index, &pixel) in image.pixels.iter().enumerate() {
            let color = usize::from(palette.pick(pixel, index % 16, index / 16));
            let shown: [u8; 3] = bytes[3 * color..3 * color + 3].try_into().unwrap();
            assert_eq!(shown.map(|level| u16::from(level) * 257), pixel);
        }
    }

    #[test]
    fn flat_colours_between_the_palettes_are_mixed() {
        let level = |step: u32| (step * 65_535 / 63) as u16;
        let plane = (0..64 * 64).map(|pixel| [level(pixel % 64), level(pixel / 64), 30_000]);
        let mut palette = Palette::of(&Image { width: 64, height: 64, pixels: plane.collect() });
        let bytes = palette.bytes();
        for number in 0..100_u32 {
            let pixel = [level(7 + number % 10 * 5), level(7 + number / 10 * 5), 30_000];
            let picks: Vec<u8> = (0..64).map(|index| palette.pick(pixel, index % 8, index / 8)).collect();
            for (axis, wanted) in color_of(pixel).into_iter().enumerate() {
                let sum: f32 = picks.iter().map(|&color| f32::from(bytes[3 * usize::from(color) + axis])).sum();
                // A mixture lies on the line between two colours, so a little error across it stays.
                assert!((sum / 64.0 - wanted).abs() < 3.0, "{pixel:?} axis {axis}: {} for {wanted}", sum / 64.0);
            }
        }
    }

    #[test]
    fn an_empty_picture_has_a_palette() {
        assert_eq!(Palette::of(&Image::default()).bytes(), [0, 0, 0]);
    }
}
