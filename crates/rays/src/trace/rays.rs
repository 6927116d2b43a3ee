use glam::DVec3;

use crate::Ray;

/// Rays as somebody has them; all are brought to [`Ray`] one by one, without a copy of all.
#[derive(Clone, Copy, Debug)]
pub enum Rays<'a> {
    /// As they are, each with its own interval.
    These(&'a [Ray]),
    /// An origin and a direction each, for all t above 0.
    Single(&'a [[f32; 6]]),
    /// The same, of twice the precision.
    Double(&'a [[f64; 6]]),
}

impl<'a> Rays<'a> {
    /// How many there are.
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

    /// One of them.
    ///
    /// # Panics
    /// If there are fewer.
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

    /// The same in pieces of so many.
    ///
    /// # Panics
    /// If that is zero.
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
