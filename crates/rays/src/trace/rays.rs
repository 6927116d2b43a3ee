use glam::DVec3;

use crate::Ray;

/// Rays in the caller's form; each is converted to a [`Ray`] when it is read, without a copy of all.
#[derive(Clone, Copy, Debug)]
pub enum Rays<'a> {
    /// Rays, each with its own interval.
    These(&'a [Ray]),
    /// An origin and a direction each, for all t above 0.
    Single(&'a [[f32; 6]]),
    /// The same in f64.
    Double(&'a [[f64; 6]]),
}

impl<'a> Rays<'a> {
    /// The number of rays.
    #[must_use]
    pub fn len(self) -> usize {
        match self {
            Self::These(all) => all.len(),
            Self::Single(all) => all.len(),
            Self::Double(all) => all.len(),
        }
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(self) -> bool {
        self.len() == 0
    }

    /// The ray at `index`.
    ///
    /// # Panics
    /// If `index` is out of range.
    #[inline]
    #[must_use]
    pub fn get(self, index: usize) -> Ray {
        let [x, y, z, dx, dy, dz] = match self {
            Self::These(all) => return all[index],
            Self::Single(all) => all[index].map(f64::from),
            Self::Double(all) => all[index],
        };
        Ray::new(DVec3::new(x, y, z), DVec3::new(dx, dy, dz))
    }

    /// Chunks of at most `rays` rays.
    ///
    /// # Panics
    /// If `rays` is zero.
    pub fn chunks(self, rays: usize) -> impl Iterator<Item = Self> {
        (0..self.len()).step_by(rays).map(move |first| {
            let range = first..self.len().min(first.saturating_add(rays));
            match self {
                Self::These(all) => Self::These(&all[range]),
                Self::Single(all) => Self::Single(&all[range]),
                Self::Double(all) => Self::Double(&all[range]),
            }
        })
    }
}

impl<'a> From<&'a [Ray]> for Rays<'a> {
    fn from(rays: &'a [Ray]) -> Self {
        Self::These(rays)
    }
}

impl<'a> From<&'a Vec<Ray>> for Rays<'a> {
    fn from(rays: &'a Vec<Ray>) -> Self {
        Self::These(rays)
    }
}

impl<'a, const N: usize> From<&'a [Ray; N]> for Rays<'a> {
    fn from(rays: &'a [Ray; N]) -> Self {
        Self::These(rays)
    }
}
