//! Rays of any kind through a kd-tree: Horn et al., *Interactive k-D Tree GPU Raytracing* (2007).
//!
//! The tree is built on the CPU and uploaded (`tree`, as `words`); rays, or questions about shadows, lie in buffers (`records`). `line`
//! prepares each for f32; `stack`, `trail` (restart, push-down, short stack) or `packet` leads it through the tree and tests
//! triangles with `tester`; `settle` decides by the predicate what that has left undecided, and finds where hits are. `tracer`
//! runs these stages. So answers are those of [`umbrage_rays::KdTree`], bit for bit.
//!
//! `sight` asks for a whole image: `rays` makes the camera's, `seen` keeps what they hit, and for each light `ask` makes the
//! questions about shadows, whose answers are the bits of `lit`. `fit` says whether there was room for all of it.
//!
//! **In which units.** A power of two brings the largest coordinate of the tree's bounds to between one half and one, another
//! one the largest component of a ray's direction to between one and two. t is counted in lengths of that direction from the
//! point where the ray enters the bounds, or where its interval begins inside them. That point is found in the emulated f64, so
//! all numbers of a traversal are small: coordinates below one, t from 0 to 4. Below, u = 2⁻²⁴ is one rounding of f32.
//!
//! **What is wrong with a line.** A component of the point is rounded to f32, by u/2, after f64 roundings of what may be far
//! away: `blur` = 2⁻⁴⁹ (the largest coordinate of the origin + twice the largest t at the bounds) is more than those, more than
//! the rounding of a hit's t in f64, by which hits are compared, and more than what is lost where numbers underflow. Where blur
//! is above 2⁻⁵, or something isn't finite, the line takes everything: it visits all leaves, and all triangles are left undecided.
//!
//! **How a cell is left out.** A ray reaches a plane s at (s − o) · i. Written out, that is the sum of s·i and −o·i: however a
//! compiler contracts or distributes it, no term meets more than three roundings, the one of i = 1/d among them, and what they
//! multiply is below 2·|i|. With the error of o that is below (6.5u + blur)·|i|; the line's `doubt` on an axis is
//! (12u + 2 blur)·|i|, which leaves room for its own roundings. A child gets the interval of t in which the ray may be in its
//! cell, grown by the doubt, and is left out only where that is empty. Where |d| is below 2⁻³⁰ the ray moves by less than u/16
//! across that axis: it is on one side of a plane, or by less than 12u + 2 blur beside it and then on both.
//!
//! **How a triangle is left out.** In a space sheared so that the line is an axis, a corner has coordinates
//! (p − o)ₓ − m·(p − o)_z: four terms of magnitude one at most, each with no more than four roundings, and the errors of o. That
//! is less than e = 20u + 3 blur. With r the largest such coordinate, an edge function a·b − c·d is wrong by at most
//! 4er + 2e² + 6ur², and less than `bound` = 5er + 3e² + 8ur². Signs beyond it are those of real numbers, as are the
//! predicate's. Division may be off by 2.5 units: it is only in t, whose error is that of the corners' t, plus 7 bounds over the
//! least the edge functions' sum can be, plus 32u of the corners' range of t. A triangle is a hit for certain if all edge
//! functions have a certain sign and t is inside the interval by more than that; a miss if two have different certain signs, or t
//! is certainly outside; else it is undecided, and listed.
//!
//! **Which hit is the nearest.** A ray holds one hit, in a register. A hit that is certainly behind a certain one is dropped,
//! one that is certainly nearer replaces it, and whatever overlaps is listed, to be compared by the predicate's t. A cell that
//! begins behind the far end of a certain hit's t is left out. At the end the hit that is held is listed too, for most rays as
//! the only one: `settle` then finds where it is, an invocation for each listed hit.
//!
//! **Shadows.** The predicate asks that the point be off the triangle's plane by more than the point's error, so a shadow is
//! certain only where the line's slope against the plane times the rest of the way to the point is more than 64 times that
//! error and blur: the predicate's own bound has 24 of them.
//!
//! **Rays from triangles.** A ray that starts at a point of a triangle, with an error, meets no triangle whose plane the point's
//! box touches. So a hit is certain only where it is as far off the plane as a shadow's.
//!
//! **Sides and masks.** Rays go through triangles on the side that they don't have: which one it is follows from the signs of
//! the edge functions where these are certain. Where a triangle isn't there at every point, a hit is never certain.

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
#[doc(hidden)] // For frames in `umbrage-study`.
pub use records::light_words;
pub use sight::KdSight;
pub use tracer::{KdTracer, KdTracerOptions, KdTracerWork};
pub use tree::KdNodes;
