//! The coarseness of pictures in motion.

/// Divisor of the sides of pictures in motion, chosen for twenty pictures a second where fewer pixels help.
#[derive(Debug, Default)]
pub(crate) struct Coarseness {
    /// The divisor of sides, minus one.
    level: usize,
    /// Milliseconds of the last picture of each level.
    milliseconds: [Option<f64>; Self::LEVELS],
}

impl Coarseness {
    const LEVELS: usize = 4;
    /// Target time of a picture in motion, in milliseconds.
    const MOST: f64 = 50.0;
    /// Maximum time of a useful coarser picture, relative to the finer one's.
    const HELPS: f64 = 0.8;

    /// The size of the next picture in motion, whose full size is `whole`.
    pub(crate) fn size(&self, whole: [u32; 2]) -> [u32; 2] {
        whole.map(|side| side.div_ceil(self.level as u32 + 1))
    }

    /// Records the time of a picture of [`size`](Self::size), and adapts the level.
    pub(crate) fn add(&mut self, milliseconds: f64) {
        let level = self.level;
        self.milliseconds[level] = Some(milliseconds);
        let of = |level: usize| self.milliseconds.get(level).copied().flatten();
        if milliseconds > Self::MOST {
            let has_coarser = level + 1 < Self::LEVELS;
            if has_coarser && of(level + 1).is_none_or(|coarser| coarser < Self::HELPS * milliseconds) {
                self.level += 1;
            } else if level > 0 && of(level - 1).is_some_and(|finer| milliseconds > Self::HELPS * finer) {
                self.level -= 1;
            }
        } else if level > 0 {
            // Assumes that time is proportional to pixels.
            let pixels = ((level + 1) as f64 / level as f64).powi(2);
            if milliseconds * pixels < 0.9 * Self::MOST {
                self.level -= 1;
            }
        }
    }

    /// Starts over, before pictures with other times.
    pub(crate) fn clear(&mut self) {
        *self = Self::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The width of the last of many pictures, each with a constant time and a time for each pixel.
    fn play(coarseness: &mut Coarseness, always: f64, of_pixel: f64) -> u32 {
        let whole = [1200, 800];
        for _ in 0..30 {
            let [width, height] = coarseness.size(whole);
            coarseness.add(always + of_pixel * f64::from(width * height));
        }
        coarseness.size(whole)[0]
    }

    #[test]
    fn slow_pictures_are_coarse_and_fast_ones_whole() {
        let mut coarseness = Coarseness::default();
        assert_eq!(play(&mut coarseness, 1.0, 2e-5), 1200);
        assert_eq!(play(&mut coarseness, 5.0, 1.5e-4), 600);
        assert_eq!(play(&mut coarseness, 5.0, 1e-2), 300);
        assert_eq!(play(&mut coarseness, 1.0, 2e-5), 1200, "they recover");
    }

    #[test]
    fn pictures_that_take_long_at_any_size_are_whole() {
        assert_eq!(play(&mut Coarseness::default(), 90.0, 1e-5), 1200);
    }

    #[test]
    fn windows_of_a_pixel_keep_it() {
        let mut coarseness = Coarseness::default();
        play(&mut coarseness, 5.0, 1e-2);
        assert_eq!(coarseness.size([1, 2]), [1, 1]);
    }
}
