//! The crate's tests, as one program: linking one takes less time than linking sixteen.

mod any_rays;
mod exact;
mod far;
mod hierarchy;
mod nearest;
mod pairs;
mod scales;
mod support;
