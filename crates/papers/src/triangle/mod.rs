//! Fast ray–triangle tests from the literature, in f32, for one ray and for sixteen at once.
//!
//! None of them is exact: near a triangle's edges, for slivers and for grazing rays they may differ from the
//! [predicate](umbrage_rays::predicate), and neighbours may leave gaps. A structure may use one to reject most
//! triangles and to rank the rest, and must take the predicate's answer within the bounds below. No structure does so
//! far, and none is planned.
//!
//! | test | bytes a triangle | prepared |
//! |---|---|---|
//! | [`MollerTrumbore`] | 36 | nothing: the corners |
//! | [`KenslerShirley`] | 36 | nothing: the corners |
//! | [`Badouel`] | 40 | plane and two linear functions in a projection |
//! | [`Wachter`] | 40 | as [`Badouel`] |
//! | [`Shevtsov`] | 40 | plane, two edges and a corner in a projection |
//! | [`HavelHerout`] | 48 | three planes |
//! | [`Plucker`] | 88 | three lines and the plane |
//! | [`MollerTrumboreBundle`], [`BadouelBundle`] | 40 | the same in relation to a shared origin |
//! | [`PluckerBundle`] | 52 | the same in relation to a shared origin |
//! | [`Fans`] | 23 in fans of six, 26 in fans of four | edges from the fans' centres |
//!
//! # Errors of the tests
//!
//! All tests miss if a coordinate is NaN, if a ray is in the triangle's plane (as far as f32 can tell) and if t isn't
//! inside the open interval, up to rounding. A hit whose weights (of all corners) and t are farther from their limits
//! than these bounds is a hit of the predicate, and the other way round. With ε = 2⁻²⁴, E the triangle's longest edge,
//! N twice its area, D the direction's length, n · D the determinant, M the largest distance of ray origin, corners and
//! point of the hit from the world's origin, and R that of corners and hit from the ray's origin:
//!
//! | tests | weights | t |
//! |---|---|---|
//! | Möller–Trumbore and its bundle form, Kensler–Shirley, fans | 16 ε E D (R + E) / \|n · D\| | 16 ε E² R / \|n · D\| |
//! | Plücker's | 16 ε M² D / \|n · D\| | 16 ε E² M / \|n · D\| |
//! | its bundle form | 16 ε R² D / \|n · D\| | 16 ε E² R / \|n · D\| |
//! | Badouel, Wächter, Shevtsov, Havel–Herout | 16 ε (M / E) (E² / N)² (1 + N D / \|n · D\|) | 16 ε E² M / \|n · D\| |
//! | Badouel's bundle form | the same with R for M | 16 ε E² R / \|n · D\| |
//!
//! The factor is an estimate, not a proof: up to 14 roundings lie between input and result, and random triangles,
//! including slivers, show errors of up to a fifth of the bounds. Overflow and underflow aren't accounted for. A bound
//! above one says nothing. Tests with M lose digits far from the world's origin; the others don't.

mod badouel;
mod fan;
mod havel_herout;
mod kensler_shirley;
mod lanes;
mod moller_trumbore;
mod plucker;
mod rays;
mod shevtsov;

use glam::Vec3;

pub use badouel::{Badouel, BadouelBundle, Wachter};
pub use fan::{Fans, TriangleFan};
pub use havel_herout::HavelHerout;
pub use kensler_shirley::KenslerShirley;
pub use lanes::{LaneMask, Lanes};
pub use moller_trumbore::{MollerTrumbore, MollerTrumboreBundle};
pub use plucker::{Plucker, PluckerBundle};
pub use rays::{Bundle, Hits, Rays};
pub use shevtsov::Shevtsov;

/// A triangle prepared for rays from anywhere.
pub trait TriangleTest: Copy {
    /// Name of the test.
    const NAME: &'static str;

    /// Prepares a triangle, given its corners in world units.
    fn new(corners: [Vec3; 3]) -> Self;

    /// Hits of rays on the triangle, on either side; `None` if there are none.
    fn hit<L: Lanes>(&self, rays: &Rays<L>) -> Option<Hits<L>>;
}

/// A triangle prepared for rays from one origin.
pub trait BundleTest: Copy {
    /// Name of the test.
    const NAME: &'static str;

    /// Prepares a triangle, given its corners and the rays' origin in world units.
    fn new(corners: [Vec3; 3], origin: Vec3) -> Self;

    /// Hits of rays from the origin on the triangle, on either side; `None` if there are none.
    fn hit<L: Lanes>(&self, rays: &Bundle<L>) -> Option<Hits<L>>;
}
