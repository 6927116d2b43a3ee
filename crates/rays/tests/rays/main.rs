//! The crate's tests, as one program: linking one takes less time than linking sixteen.

mod any_rays;
mod exact;
mod far;
mod hierarchy;
mod masks;
mod nearest;
mod overlap;
mod pairs;
mod scales;
mod support;
mod winding;
