//! Rays of any kind through a structure that the CPU builds.
//!
//! Rays, or shadow questions, lie in buffers (`records`). `line` prepares each for f32. A walk takes it through the
//! structure and tests triangles with `tester`: `hierarchy` through that of [`umbrage_rays::Bvh`], others through
//! structures of other crates ([`Walk`]). `settle` decides the undecided hits by the predicate, and finds the hits' t.
//! `tracer` runs these stages. So answers are those of the CPU, bit for bit.
//!
//! **Units.** A power of two scales the largest coordinate of the structure's bounds to between one half and one, another
//! one the largest component of a ray's direction to between one and two. t is counted in lengths of that direction
//! from the point where the ray enters the bounds, or where its interval begins inside them. That point is found in the
//! emulated f64, so all numbers of a walk are small: coordinates below one, t from 0 to 4. Below, u = 2⁻²⁴ is one
//! rounding of f32.
//!
//! **Error of a line.** A component of the point o is rounded to f32, by u|o|, after f64 roundings of coordinates that may
//! be far away: `blur` = 2⁻⁴⁹ (the largest coordinate of the origin + twice the t at the point) is more than those, more
//! than the f64 rounding of the hits' t up to the point, and more than any underflow loses. If blur is above 2⁻⁵, or a
//! number isn't finite, the line tests everything: it visits all leaves, and all triangles stay undecided. If a component
//! of the direction is below 2⁻⁹⁰, it counts as zero: the ray moves across that axis by less than the least blur.
//!
//! **Culling a box.** A ray reaches a plane s at (s − o) · i. Written out, that is the sum of s·i and −o·i: in any form
//! that a compiler contracts or distributes it to, no term has more than three roundings, and i = 1/d has one. As |s| is
//! at most |s − o| + |o|, the error is below 4u|t| + (7u|o| + blur)·|i|. Intervals grow by 12u|t| + (12u|o| + 2 blur)·|i|,
//! which leaves room for its own roundings. A box is culled only if the intervals of its three axes have no t in common.
//! For i = 1/0 stands a number so large that a box beside the ray is left at once, and one around it never.
//!
//! **Culling a triangle.** In a space sheared so that the line is an axis, a corner has coordinates (p − o)ₓ − m·(p −
//! o)_z: four terms with no more than four roundings each, and the errors of o. With M the largest |p − o| of a corner
//! on an axis and w the largest |o|, the terms are at most M + w, w, M + w and w, and their error is less than e =
//! 20u(M + w) + 3 blur. So triangles near the ray's start are as certain with a vertex far away as without. With r the
//! largest sheared coordinate, the error of an edge function a·b − c·d is at most 4er + 2e² + 6ur², and less than
//! `bound` = 5er + 3e² + 8ur² + all that underflow loses. Signs beyond it are those of real numbers, as are the
//! predicate's. Division may be off by 2.5 units: it is only in t, whose error is that of the corners' t, 10u(M + w) +
//! 2 blur, plus 7 bounds over the least sum of the edge functions, plus 32u of the corners' range of t. A triangle is
//! certainly hit if all edge functions have a certain sign and t is inside the interval by more than that. It is
//! certainly missed if two have different certain signs, or t is certainly outside. Else it is undecided, and listed.
//!
//! **The nearest hit.** A ray holds one hit, in a register. A hit that is certainly behind a certain one is dropped,
//! one that is certainly nearer replaces it, and any hit that overlaps it is listed, to be compared by the predicate's
//! t. A box that begins behind the far end of a certain hit's t is culled. At the end the held hit is listed too, for
//! most rays as the only one: `settle` then finds its t, with an invocation for each listed hit.
//!
//! **Shadows.** The predicate requires that the point be off the triangle's plane by more than the point's error. So a
//! shadow is certain only if the line's slope against the plane times the rest of the way to the point is more than 64
//! times that error and blur: the predicate's own bound has 24 of them.
//!
//! **Rays from triangles.** A ray that starts at a point of a triangle, with an error, meets no triangle whose plane
//! the point's box touches. So a hit is certain only if it is as far off the plane as a shadow's.
//!
//! **Sides and masks.** Rays pass through a one-sided triangle from its missing side: the signs of the edge functions
//! tell the side if they are certain. A masked triangle is never certainly hit.
//!
//! **Parts.** Triangles with huge coordinates, beside others without, are a hierarchy of their own, with a space of its
//! own. Rays walk through both, and `settle` compares what both have listed.

mod hierarchy;
mod light;
#[cfg(not(target_arch = "wasm32"))]
mod read_back;
mod records;
mod space;
mod tracer;

pub use hierarchy::Hierarchy;
#[doc(hidden)] // For the kd-tree in `umbrage-papers`.
pub use light::ShadowLight;
pub use records::RayRecords;
#[doc(hidden)] // For frames in `umbrage-papers`.
pub use records::light_words;
pub use space::Part;
#[doc(hidden)] // For the kd-tree in `umbrage-papers`.
pub use space::RaySpace;
pub use tracer::{RayTracer, RayTracerOptions, RayTracerWork, Walk};
