//! Rays of any kind through a kd-tree: Horn et al., *Interactive k-D Tree GPU Raytracing* (2007).
//!
//! The tree is built on the CPU and uploaded (`tree`, as `words`). The tracer of [`rays`](crate::rays) takes rays through
//! it by `stack`, `trail` (restart, push-down, short stack) or `packet`. So answers are those of
//! [`umbrage_rays::KdTree`], bit for bit.
//!
//! `sight` answers for a whole image: `rays` makes the camera's rays, `seen` keeps their hits, and for each light `ask`
//! makes shadow questions, whose answers are the bits of `lit`. `fit` decides whether there was room for all of it.
//!
//! **Culling a cell.** Of the terms of a plane's t, as those of a [box](crate::rays), the factors are below 2·|i|. So the
//! error is below (6.5u + blur)·|i|; the doubt on an axis is (12u + 2 blur)·|i|, which leaves room for its own roundings. A
//! child gets the interval of t in which the ray may be in its cell, grown by the doubt, and is culled only if that is
//! empty. A ray that is parallel to a plane is on one side, or less than 12u + 2 blur beside it and then on both.

mod options;
mod sight;
mod tree;
mod words;

pub use options::KdTracerOptions;
pub use sight::KdSight;
pub use tree::KdNodes;
