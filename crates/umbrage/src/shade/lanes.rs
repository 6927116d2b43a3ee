//! Vectors of sixteen pixels at once: of a block of [`TileOrder`].
//!
//! This module and its callers are compiled once for each set of instructions, inside of `dispatch!`. So all of it is
//! inlined, and no closure takes vectors: code that isn't inlined is compiled without the instructions. Nothing is
//! contracted or estimated, so every set gives the same numbers.

use std::array;
use std::ops::{Add, AddAssign, Mul, Neg, Sub};

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, f64x8, mask32x16};
use glam::{DVec3, Vec3, Vec4};
use umbrage_rays::TileOrder;

/// Pixels at once.
pub(crate) const LANES: usize = TileOrder::BLOCK_PIXELS;

/// The largest radiance and irradiance: thousands of samples still add up to a finite number.
pub(crate) const BRIGHTEST: f32 = 1e30;

/// One value for each lane.
pub(crate) type Each<T> = [T; LANES];

/// Three numbers that are vectors themselves.
#[derive(Clone, Copy)]
pub(crate) struct Vector<F> {
    pub(crate) x: F,
    pub(crate) y: F,
    pub(crate) z: F,
}

/// Sixteen vectors in f32.
pub(crate) type Vectors<S> = Vector<f32x16<S>>;

/// Eight vectors in f64.
pub(crate) type Wide<S> = Vector<f64x8<S>>;

impl<F: Copy + Add<Output = F> + Sub<Output = F> + Mul<Output = F>> Vector<F> {
    #[inline(always)]
    pub(crate) fn dot(self, other: Self) -> F {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    #[inline(always)]
    pub(crate) fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - other.y * self.z,
            y: self.z * other.x - other.z * self.x,
            z: self.x * other.y - other.x * self.y,
        }
    }

    /// All three times the same number.
    #[inline(always)]
    pub(crate) fn scaled(self, by: F) -> Self {
        Self { x: self.x * by, y: self.y * by, z: self.z * by }
    }

    /// Each plus the same number.
    #[inline(always)]
    pub(crate) fn raised(self, by: F) -> Self {
        Self { x: self.x + by, y: self.y + by, z: self.z + by }
    }

    /// From `self` at 0 to `other` at 1.
    #[inline(always)]
    pub(crate) fn lerp(self, other: Self, part: F) -> Self {
        self + (other - self).scaled(part)
    }
}

/// Component by component, also products, as colours are multiplied.
macro_rules! by_component {
    ($($operator:ident $method:ident),*) => {$(
        impl<F: $operator<Output = F>> $operator for Vector<F> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self { x: self.x.$method(other.x), y: self.y.$method(other.y), z: self.z.$method(other.z) }
            }
        }
    )*};
}

by_component! { Add add, Sub sub, Mul mul }

impl<F: Copy + Add<Output = F>> AddAssign for Vector<F> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<F: Neg<Output = F>> Neg for Vector<F> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { x: -self.x, y: -self.y, z: -self.z }
    }
}

impl<S: Simd> Vectors<S> {
    /// The same vector in all lanes.
    #[inline(always)]
    pub(crate) fn splat(simd: S, value: Vec3) -> Self {
        Self { x: f32x16::splat(simd, value.x), y: f32x16::splat(simd, value.y), z: f32x16::splat(simd, value.z) }
    }

    /// From the lanes' x, y and z.
    #[inline(always)]
    pub(crate) fn load(simd: S, [x, y, z]: &[Each<f32>; 3]) -> Self {
        Self { x: f32x16::from_slice(simd, x), y: f32x16::from_slice(simd, y), z: f32x16::from_slice(simd, z) }
    }

    /// From vectors of x, of y and of z.
    #[inline(always)]
    pub(crate) fn of_axes([x, y, z]: [f32x16<S>; 3]) -> Self {
        Self { x, y, z }
    }

    /// The x, y and z of sixteen vectors of four components.
    #[inline(always)]
    pub(crate) fn of_first_three(simd: S, vectors: &[Vec4; LANES]) -> Self {
        let [x0, y0, z0, _] = simd.load_four_interleaved_f32x4(&four(vectors, 0));
        let [x1, y1, z1, _] = simd.load_four_interleaved_f32x4(&four(vectors, 4));
        let [x2, y2, z2, _] = simd.load_four_interleaved_f32x4(&four(vectors, 8));
        let [x3, y3, z3, _] = simd.load_four_interleaved_f32x4(&four(vectors, 12));
        Self {
            x: x0.combine(x1).combine(x2.combine(x3)),
            y: y0.combine(y1).combine(y2.combine(y3)),
            z: z0.combine(z1).combine(z2.combine(z3)),
        }
    }

    /// The lanes' x, y and z.
    #[inline(always)]
    pub(crate) fn store(self) -> [Each<f32>; 3] {
        [self.x.into(), self.y.into(), self.z.into()]
    }

    /// `one` where `mask` is set, else `other`.
    #[inline(always)]
    pub(crate) fn select(mask: mask32x16<S>, one: Self, other: Self) -> Self {
        Self { x: mask.select(one.x, other.x), y: mask.select(one.y, other.y), z: mask.select(one.z, other.z) }
    }

    #[inline(always)]
    pub(crate) fn length(self) -> f32x16<S> {
        self.dot(self).sqrt()
    }

    /// The vectors with a length of 1, and `fallback` where they have no direction: where they are zero, infinite, NaN or
    /// so short that f32 doesn't know their length.
    #[inline(always)]
    pub(crate) fn normalized_or(self, fallback: Self) -> Self {
        let (unit, has_direction) = self.try_normalized();
        Self::select(has_direction, unit, fallback)
    }

    /// The vectors with a length of 1, and a mask of those that have a direction.
    #[inline(always)]
    pub(crate) fn try_normalized(self) -> (Self, mask32x16<S>) {
        let inverse = 1.0 / self.length();
        (self.scaled(inverse), inverse.simd_gt(0.0) & inverse.simd_le(f32::MAX))
    }

    /// The largest of x, y and z.
    #[inline(always)]
    pub(crate) fn largest(self) -> f32x16<S> {
        self.x.max(self.y).max(self.z)
    }

    /// The mean of x, y and z.
    #[inline(always)]
    pub(crate) fn mean(self) -> f32x16<S> {
        (self.x + self.y + self.z) / 3.0
    }

    /// The lanes in which not all of x, y and z are zero.
    #[inline(always)]
    pub(crate) fn is_something(self) -> mask32x16<S> {
        !(self.x.simd_eq(0.0) & self.y.simd_eq(0.0) & self.z.simd_eq(0.0))
    }

    /// Clamps components to ±[`BRIGHTEST`]; NaN from an overflow becomes [`BRIGHTEST`].
    #[inline(always)]
    pub(crate) fn at_most_brightest(self) -> Self {
        let bounded = |brightness: f32x16<S>| brightness.min_precise(BRIGHTEST).max_precise(-BRIGHTEST);
        Self { x: bounded(self.x), y: bounded(self.y), z: bounded(self.z) }
    }

    /// Clamps components to at most one.
    #[inline(always)]
    pub(crate) fn at_most_one(self) -> Self {
        Self { x: self.x.min(1.0), y: self.y.min(1.0), z: self.z.min(1.0) }
    }

    /// Clamps components to at least zero.
    #[inline(always)]
    pub(crate) fn at_least_zero(self) -> Self {
        Self { x: self.x.max(0.0), y: self.y.max(0.0), z: self.z.max(0.0) }
    }

    /// The lanes in f64: the first eight, then the others.
    #[inline(always)]
    pub(crate) fn widen(self) -> [Wide<S>; 2] {
        let ((x0, x1), (y0, y1), (z0, z1)) = (self.x.widen(), self.y.widen(), self.z.widen());
        [Vector { x: x0, y: y0, z: z0 }, Vector { x: x1, y: y1, z: z1 }]
    }

    /// The nearest f32 of two times eight lanes.
    #[inline(always)]
    pub(crate) fn narrow([low, high]: [Wide<S>; 2]) -> Self {
        Self { x: low.x.narrow(high.x), y: low.y.narrow(high.y), z: low.z.narrow(high.z) }
    }
}

impl<S: Simd> Wide<S> {
    /// The same vector in all lanes.
    #[inline(always)]
    pub(crate) fn splat(simd: S, value: DVec3) -> Self {
        Self { x: f64x8::splat(simd, value.x), y: f64x8::splat(simd, value.y), z: f64x8::splat(simd, value.z) }
    }

    /// From the lanes' x, y and z.
    #[inline(always)]
    pub(crate) fn load(simd: S, [x, y, z]: &[[f64; LANES / 2]; 3]) -> Self {
        Self { x: f64x8::from_slice(simd, x), y: f64x8::from_slice(simd, y), z: f64x8::from_slice(simd, z) }
    }

    /// The largest magnitude of x, y and z.
    #[inline(always)]
    pub(crate) fn reach(self) -> f64x8<S> {
        self.x.abs().max(self.y.abs()).max(self.z.abs())
    }
}

/// The components of four vectors from `first` on, in order.
#[inline(always)]
fn four(vectors: &[Vec4; LANES], first: usize) -> [f32; 16] {
    array::from_fn(|component| vectors[first + component / 4].to_array()[component % 4])
}

/// Clamps radiance to ±[`BRIGHTEST`]; NaN from an overflow becomes [`BRIGHTEST`].
pub(crate) fn at_most_brightest(radiance: f32) -> f32 {
    if radiance.is_nan() { BRIGHTEST } else { radiance.clamp(-BRIGHTEST, BRIGHTEST) }
}

/// The lanes whose bit is set, the first in the lowest bit.
pub(crate) fn lanes_of(bits: u16) -> impl Iterator<Item = usize> {
    (0..LANES).filter(move |lane| bits >> lane & 1 == 1)
}

/// The vector in one lane.
pub(crate) fn vector_of(lane: usize, [x, y, z]: &[Each<f32>; 3]) -> Vec3 {
    Vec3::new(x[lane], y[lane], z[lane])
}

/// Stores a vector in one lane.
#[inline(always)]
pub(crate) fn put(lane: usize, value: impl Into<[f32; 3]>, to: &mut [Each<f32>; 3]) {
    let [x, y, z] = value.into();
    (to[0][lane], to[1][lane], to[2][lane]) = (x, y, z);
}

/// The same in all lanes.
pub(crate) fn each<T: Copy>(value: T) -> Each<T> {
    array::from_fn(|_| value)
}
