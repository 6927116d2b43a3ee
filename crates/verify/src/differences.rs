use umbrage::{Renderer, Settings};

/// How the last frames of two renderers differ.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Differences {
    /// Number of pixels.
    pub pixels: usize,
    /// Pixels with another triangle.
    pub triangles: usize,
    /// Pairs of a pixel and a light with another answer whether the light reaches the pixel.
    pub shadows: usize,
    /// Pixels that differ by more than one level of 255 in some channel.
    pub colors: usize,
}

impl Differences {
    /// Compares the last frames of two renderers, both with `settings`.
    ///
    /// # Panics
    /// If they have rendered different numbers of lights.
    #[must_use]
    pub fn between(one: &Renderer, other: &Renderer, settings: &Settings) -> Self {
        let Settings { width, height, .. } = *settings;
        let pixels = || (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let is_other = |&(x, y): &(u32, u32)| one.seen().triangle_at(x, y) != other.seen().triangle_at(x, y);
        assert_eq!(one.light_masks().len(), other.light_masks().len());
        let masks = one.light_masks().iter().zip(other.light_masks());
        let shadows =
            masks.map(|(one, other)| pixels().filter(|&(x, y)| one.is_lit(x, y) != other.is_lit(x, y)).count());
        let [developed, others] = [one, other].map(|renderer| renderer.film().develop(settings).pixels);
        let levels = |(one, other): &(&[u16; 3], &[u16; 3])| {
            one.iter().zip(*other).any(|(one, other)| one.abs_diff(*other) > u16::MAX / 255)
        };
        Self {
            pixels: developed.len(),
            triangles: pixels().filter(is_other).count(),
            shadows: shadows.sum(),
            colors: developed.iter().zip(&others).filter(levels).count(),
        }
    }

    /// Asserts that triangles and shadows are the same, and colours up to the precision of f32.
    ///
    /// # Panics
    /// If they aren't.
    pub fn expect_none(&self, name: &str) {
        println!("{name}: {self:?}");
        assert_eq!((self.triangles, self.shadows), (0, 0), "{name}: {self:?}");
        assert!(self.colors <= self.pixels / 10_000, "{name}: {self:?}");
    }
}
