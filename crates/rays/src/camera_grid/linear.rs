use super::general::{Depth, General};
use super::lanes::LANES;
use super::pixel_space::HALF_ULP;
use super::samples::BLOCKS;
use super::tile::Batch;

/// One triangle's edge functions and inverse depth in f32, as linear functions of x and y relative to an origin.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Linear {
    /// Factor of x of each edge function; positive edge functions are inside.
    pub(crate) a: [f32; 3],
    /// Factor of y.
    pub(crate) b: [f32; 3],
    /// Constant.
    pub(crate) c: [f32; 3],
    /// Error bound of an edge function.
    pub(crate) bound: f32,
    /// One over the depth at the origin.
    pub(crate) inverse_depth: f32,
    /// Its change per pixel to the right and downwards.
    pub(crate) gradient: [f32; 2],
    pub(crate) depth_error: f32,
    /// Upper bound of the inverse depth.
    pub(crate) nearest: f32,
}

impl General {
    /// The triangle relative to (`x`, `y`) in pixel space, for samples at most `reach` from there along each axis; `None`
    /// where its orientation isn't certain or f32 can't hold it.
    ///
    /// Each edge function is divided by its error, so that its error becomes one. Coefficients are rounded once, and
    /// evaluation adds a rounding of each product and two of sums: four on a path, taken as six.
    pub(crate) fn linear(&self, [x, y]: [f64; 2], reach: f64) -> Option<Linear> {
        let Depth::Inverse { plane, error } = self.depth else { return None };
        if !self.oriented {
            return None;
        }
        const ROUNDINGS: f64 = 6.0 * HALF_ULP as f64;
        let middle = glam::DVec3::new(x, y, 1.0);
        let (mut a, mut b, mut c) = ([0.0; 3], [0.0; 3], [0.0; 3]);
        for (edge, (&coefficients, &bound)) in self.edges.iter().zip(&self.bounds).enumerate() {
            let constant = coefficients.dot(middle);
            let largest = reach * (coefficients.x.abs() + coefficients.y.abs()) + constant.abs();
            let scale = (bound + ROUNDINGS * largest).recip();
            // Beyond this, sums in f32 could overflow; it also excludes NaN.
            if !(largest * scale < 1e30 && scale.is_normal()) {
                return None;
            }
            a[edge] = (coefficients.x * scale) as f32;
            b[edge] = (coefficients.y * scale) as f32;
            c[edge] = (constant * scale) as f32;
        }
        let inverse_depth = plane.dot(middle);
        let largest = inverse_depth.abs() + reach * (plane.x.abs() + plane.y.abs());
        let error = error + ROUNDINGS * largest;
        if !(largest < 1e24 && error > 1e-24) {
            return None;
        }
        Some(Linear {
            a,
            b,
            c,
            bound: 1.0,
            inverse_depth: inverse_depth as f32,
            gradient: [plane.x as f32, plane.y as f32],
            depth_error: (error as f32).next_up(),
            nearest: ((largest + error) as f32).next_up(),
        })
    }
}

impl Batch {
    /// The triangle in a lane.
    pub(crate) fn linear(&self, lane: usize) -> Linear {
        let lane = lane % LANES;
        Linear {
            a: self.a.map(|factors| factors[lane]),
            b: self.b.map(|factors| factors[lane]),
            c: self.c.map(|constants| constants[lane]),
            bound: self.bound[lane],
            inverse_depth: self.inverse_depth[lane],
            gradient: self.gradient.map(|slopes| slopes[lane]),
            depth_error: self.depth_error[lane],
            nearest: self.nearest[lane],
        }
    }

    /// Sets a lane to a triangle of the general path, which may be in any block.
    pub(crate) fn set(&mut self, lane: usize, linear: &Linear, id: u32) {
        let lane = lane % LANES;
        for edge in 0..3 {
            (self.a[edge][lane], self.b[edge][lane], self.c[edge][lane]) =
                (linear.a[edge], linear.b[edge], linear.c[edge]);
        }
        self.bound[lane] = linear.bound;
        self.inverse_depth[lane] = linear.inverse_depth;
        (self.gradient[0][lane], self.gradient[1][lane]) = (linear.gradient[0], linear.gradient[1]);
        self.depth_error[lane] = linear.depth_error;
        self.nearest[lane] = linear.nearest;
        self.ids[lane] = id;
        for (bounds, block) in self.blocks.iter_mut().zip([0, BLOCKS - 1, 0, BLOCKS - 1]) {
            bounds[lane] = block as i32;
        }
    }
}
