use glam::DVec2;
use umbrage_rays::{Ray, View};

/// One of the rays that each pixel casts: the same one in all pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Which one, counted from 0.
    pub index: u32,
    /// Of how many.
    pub of: u32,
    /// Where in the pixel, from (0, 0) at its upper left to (1, 1).
    pub offset_pixels: DVec2,
}

impl Sample {
    /// The only one, in the middle of the pixel.
    pub const MIDDLE: Self = Self { index: 0, of: 1, offset_pixels: DVec2::splat(0.5) };

    /// All samples of a pixel: a Hammersley set, which has one in each of `count` columns and each of `count` rows. A
    /// single sample is in the middle.
    pub fn all(count: u32) -> impl Iterator<Item = Self> {
        let side = f64::from(count);
        (0..count).map(move |index| {
            let row = rank_of_mirrored_bits(index, count);
            let offset_pixels = DVec2::new((f64::from(index) + 0.5) / side, (f64::from(row) + 0.5) / side);
            Self { index, of: count, offset_pixels }
        })
    }

    /// The ray of the pixel in column `x` and row `y`.
    #[must_use]
    pub fn ray(&self, view: &View, x: u32, y: u32) -> Ray {
        view.ray(f64::from(x) + self.offset_pixels.x, f64::from(y) + self.offset_pixels.y)
    }
}

/// Rank of `sample` when 0 … `samples` − 1 are sorted by their bits read backwards (van der Corput's order).
fn rank_of_mirrored_bits(sample: u32, samples: u32) -> u32 {
    (0..samples).filter(|other| other.reverse_bits() < sample.reverse_bits()).count() as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_sample_is_in_the_middle() {
        assert!(Sample::all(1).eq([Sample::MIDDLE]));
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
