use glam::DVec2;
use umbrage_rays::{Ray, Shifts, Shot, View};

/// One of the rays that each pixel casts: the same one in all pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Its index, from 0.
    pub index: u32,
    /// The number of samples.
    pub of: u32,
    /// Position in the pixel, from (0, 0) at its upper left to (1, 1); outside of it where the camera is at another point of
    /// its lens.
    pub offset_pixels: DVec2,
}

impl Sample {
    /// The only one, in the middle of the pixel.
    pub const MIDDLE: Self = Self { index: 0, of: 1, offset_pixels: DVec2::splat(0.5) };

    /// All samples of a pixel: a Hammersley set, which has one in each of `count` columns and each of `count` rows. A single
    /// sample is in the middle. Where `count` is a power of two, the first 4ᵏ of them are in 2ᵏ columns and rows of squares,
    /// so a caller may stop there.
    pub fn all(count: u32) -> impl Iterator<Item = Self> {
        (0..count).map(move |index| Self::number(index, count))
    }

    fn number(index: u32, of: u32) -> Self {
        let column = if of.is_power_of_two() { spread_bits(index, of.trailing_zeros()) } else { index };
        let (row, side) = (rank_of_mirrored_bits(column, of), f64::from(of));
        let offset_pixels = DVec2::new((f64::from(column) + 0.5) / side, (f64::from(row) + 0.5) / side);
        Self { index, of, offset_pixels }
    }

    /// The ray of the pixel in column `x` and row `y`.
    #[must_use]
    pub fn ray(&self, view: &View, x: u32, y: u32) -> Ray {
        view.ray(f64::from(x) + self.offset_pixels.x, f64::from(y) + self.offset_pixels.y)
    }
}

/// Samples of each pixel that are traced together: one, or four, each in another quarter of the pixel.
///
/// To structures, four are the pixels of an image with twice as many columns and rows: they are built once for all.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Samples {
    /// By number; of four, the one at i + 2 j is in the quarter in column i and row j.
    samples: [Sample; 4],
    are_four: bool,
    offset_pixels: DVec2,
    shifts: Shifts,
}

impl Samples {
    /// A single one.
    #[must_use]
    pub fn one(sample: Sample) -> Self {
        let Sample { offset_pixels, .. } = sample;
        Self { samples: [sample; 4], are_four: false, offset_pixels, shifts: Shifts::NONE }
    }

    /// All samples of a pixel, four by four where `by_four` is set and their number allows it.
    pub fn all(count: u32, by_four: bool) -> impl Iterator<Item = Self> {
        let by_four = by_four && Self::can_be_four(count);
        (0..if by_four { count / 4 } else { count }).map(move |index| Self::group(index, count, by_four))
    }

    /// Whether so many samples may be traced four by four: a power of two from 4 to 4096. Others aren't at points that f32
    /// can represent in all pixels of a tile.
    pub(crate) fn can_be_four(count: u32) -> bool {
        count.is_multiple_of(4) && (0..count / 4).all(|group| Self::four(group, count / 4).is_some())
    }

    /// One group of `count` samples, four by four or alone.
    pub(crate) fn group(index: u32, count: u32, by_four: bool) -> Self {
        let four = if by_four { Self::four(index, count / 4) } else { None };
        four.unwrap_or_else(|| Self::one(Sample::number(index, count)))
    }

    /// Four of 4 × `groups` samples.
    ///
    /// A number's lowest bit is set for a sample on the right of the pixel, the next one for a sample below.
    fn four(group: u32, groups: u32) -> Option<Self> {
        let samples = [0, 1, 2, 3].map(|index| Sample::number(4 * group + index, 4 * groups));
        let (offset_pixels, shifts) = Shifts::of_quarters(samples.map(|sample| sample.offset_pixels))?;
        Some(Self { samples, are_four: true, offset_pixels, shifts })
    }

    /// The samples, in the order of their numbers.
    #[must_use]
    pub fn as_slice(&self) -> &[Sample] {
        if self.are_four { &self.samples } else { &self.samples[..1] }
    }

    /// Number of samples along a pixel's sides: one or two.
    #[must_use]
    pub fn side(&self) -> u32 {
        1 + u32::from(self.are_four)
    }

    /// The column and row, in the pixel, of sample number `which` of these.
    #[must_use]
    pub fn quarter(&self, which: usize) -> [u32; 2] {
        if self.are_four { [which as u32 % 2, which as u32 / 2] } else { [0; 2] }
    }

    /// The same samples with shifted rays: by `pixels` to the right and downwards in the image.
    pub(crate) fn shifted(mut self, pixels: DVec2) -> Self {
        self.samples.iter_mut().for_each(|sample| sample.offset_pixels += pixels);
        self.offset_pixels += pixels * f64::from(self.side());
        self
    }

    /// The shot of these samples, as one image, from a shot of an image's pixels.
    #[must_use]
    pub fn question<'a>(&self, shot: Shot<'a>) -> Shot<'a> {
        let &Self { offset_pixels, shifts, .. } = self;
        let View { camera, width, height } = shot.view;
        let view = View { camera, width: width * self.side(), height: height * self.side() };
        Shot { view, offset_pixels, shifts, ..shot }
    }
}

/// Reorders the lowest `bits` bits of a number: the first, third, fifth … become the highest ones downwards, the others the
/// lowest ones upwards.
fn spread_bits(number: u32, bits: u32) -> u32 {
    (0..bits).fold(0, |spread, bit| {
        let to = if bit % 2 == 0 { bits - 1 - bit / 2 } else { bit / 2 };
        spread | (number >> bit & 1) << to
    })
}

/// Rank of `sample` when 0 … `samples` − 1 are sorted by their bits read backwards (van der Corput's order).
fn rank_of_mirrored_bits(sample: u32, samples: u32) -> u32 {
    (0..samples).filter(|other| other.reverse_bits() < sample.reverse_bits()).count() as u32
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use umbrage_rays::{Camera, Projection, Triangles};

    use super::*;

    #[test]
    fn one_sample_is_in_the_middle() {
        assert!(Sample::all(1).eq([Sample::MIDDLE]));
    }

    #[test]
    fn samples_are_together_or_alone() {
        for count in 1..=70 {
            let together: Vec<Samples> = Samples::all(count, true).collect();
            assert_eq!(together.len() as u32 * 4 == count, count.is_power_of_two() && count >= 4, "{count}");
            let mut samples: Vec<Sample> = together.iter().flat_map(|some| some.as_slice().to_vec()).collect();
            samples.sort_unstable_by_key(|sample| sample.index);
            assert!(samples.into_iter().eq(Sample::all(count)), "{count}");
            assert!(Samples::all(count, false).eq(Sample::all(count).map(Samples::one)), "{count}");
        }
        assert_eq!(Samples::all(4096, true).count(), 1024);
    }

    #[test]
    fn four_samples_are_four_pixels() {
        let camera = Camera::look_at(Vec3::new(3.1, -1.7, 2.3), Vec3::ZERO, Vec3::Y, 0.83);
        let parallel = Camera { projection: Projection::Orthographic { half_height: 1.7 }, ..camera };
        for (camera, count) in [(camera, 4), (parallel, 4), (camera, 8), (camera, 64)] {
            let view = View { camera, width: 1921, height: 1083 };
            for samples in Samples::all(count, true) {
                let shot = samples.question(Shot::new(Triangles::default(), view));
                for (which, sample) in samples.as_slice().iter().enumerate() {
                    let [i, j] = samples.quarter(which);
                    for [x, y] in [[0, 0], [7, 1082], [1920, 511]] {
                        // Bit for bit.
                        assert_eq!(shot.ray(2 * x + i, 2 * y + j), sample.ray(&view, x, y));
                    }
                }
            }
        }
    }

    #[test]
    fn one_may_stop_after_a_power_of_four() {
        for count in [4, 16, 32, 64, 1024, 4096_u32] {
            for side in [2, 4, 8].into_iter().filter(|side| side * side <= count) {
                let square = |sample: Sample| (sample.offset_pixels * f64::from(side)).floor().as_uvec2();
                let mut squares: Vec<[u32; 2]> =
                    Sample::all(count).take((side * side) as usize).map(|sample| square(sample).to_array()).collect();
                squares.sort_unstable();
                squares.dedup();
                assert_eq!(squares.len() as u32, side * side, "the first {} of {count}", side * side);
            }
        }
    }

    #[test]
    fn every_column_and_row_has_one_sample() {
        for samples in 1..=33 {
            for axis in 0..2 {
                let stratum = |sample: Sample| (sample.offset_pixels[axis] * f64::from(samples)).floor() as u32;
                let mut strata: Vec<_> = Sample::all(samples).map(stratum).collect();
                strata.sort_unstable();
                assert_eq!(strata, (0..samples).collect::<Vec<_>>());
            }
        }
    }
}
