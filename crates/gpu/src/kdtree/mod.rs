//! Rays of any kind through a kd-tree: Horn et al., *Interactive k-D Tree GPU Raytracing* (2007).
//!
//! The tree is built on the CPU and uploaded (`tree`, as `words`); rays, or shadow questions, lie in buffers
//! (`records`). `line` prepares each for f32. `stack`, `trail` (restart, push-down, short stack) or `packet` takes it
//! through the tree and tests triangles with `tester`. `settle` decides the undecided hits by the predicate, and finds
//! the hits' t. `tracer` runs these stages. So answers are those of [`umbrage_rays::KdTree`], bit for bit.
//!
//! `sight` answers for a whole image: `rays` makes the camera's rays, `seen` keeps their hits, and for each light `ask`
//! makes shadow questions, whose answers are the bits of `lit`. `fit` decides whether there was room for all of it.
//!
//! **Units.** A power of two scales the largest coordinate of the tree's bounds to between one half and one, another
//! one the largest component of a ray's direction to between one and two. t is counted in lengths of that direction
//! from the point where the ray enters the bounds, or where its interval begins inside them. That point is found in the
//! emulated f64, so all numbers of a traversal are small: coordinates below one, t from 0 to 4. Below, u = 2⁻²⁴ is one
//! rounding of f32.
//!
//! **Error of a line.** A component of the point is rounded to f32, by u/2, after f64 roundings of coordinates that may be
//! far away: `blur` = 2⁻⁴⁹ (the largest coordinate of the origin + twice the largest t at the bounds) is more than those,
//! more than the f64 rounding of a hit's t, by which hits are compared, and more than any underflow loses. If blur is above
//! 2⁻⁵, or a number isn't finite, the line tests everything: it visits all leaves, and all triangles stay undecided.
//!
//! **Culling a cell.** A ray reaches a plane s at (s − o) · i. Written out, that is the sum of s·i and −o·i: in any form
//! that a compiler contracts or distributes it to, no term has more than three roundings, including the one of i = 1/d, and
//! their factors are below 2·|i|. With the error of o that is below (6.5u + blur)·|i|; the line's `doubt` on an axis is
//! (12u + 2 blur)·|i|, which leaves room for its own roundings. A child gets the interval of t in which the ray may be
//! in its cell, grown by the doubt, and is culled only if that is empty. If |d| is below 2⁻³⁰ the ray moves by less
//! than u/16 across that axis: it is on one side of a plane, or less than 12u + 2 blur beside it and then on both.
//!
//! **Culling a triangle.** In a space sheared so that the line is an axis, a corner has coordinates (p − o)ₓ − m·(p −
//! o)_z: four terms of magnitude one at most, each with no more than four roundings, and the errors of o. Their error
//! is less than e = 20u + 3 blur. With r the largest such coordinate, the error of an edge function a·b − c·d is at
//! most 4er + 2e² + 6ur², and less than `bound` = 5er + 3e² + 8ur². Signs beyond it are those of real numbers, as are
//! the predicate's. Division may be off by 2.5 units: it is only in t, whose error is that of the corners' t, plus 7
//! bounds over the least sum of the edge functions, plus 32u of the corners' range of t. A triangle is certainly hit if
//! all edge functions have a certain sign and t is inside the interval by more than that. It is certainly missed if two
//! have different certain signs, or t is certainly outside. Else it is undecided, and listed.
//!
//! **The nearest hit.** A ray holds one hit, in a register. A hit that is certainly behind a certain one is dropped,
//! one that is certainly nearer replaces it, and any hit that overlaps it is listed, to be compared by the predicate's
//! t. A cell that begins behind the far end of a certain hit's t is culled. At the end the held hit is listed too, for
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

mod light;
#[cfg(not(target_arch = "wasm32"))]
mod read_back;
mod records;
mod sight;
mod tracer;
mod tree;
mod words;

pub(crate) use light::KdLight;
pub use records::KdRecords;
#[doc(hidden)] // For frames in `umbrage-papers`.
pub use records::light_words;
pub use sight::KdSight;
pub use tracer::{KdTracer, KdTracerOptions, KdTracerWork};
pub use tree::KdNodes;
