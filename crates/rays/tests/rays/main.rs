//! The crate's tests, as one program: linking one takes less time than linking sixteen.

mod far;
mod hierarchy;
mod pairs;
mod scales;
mod support;
