//! Instruction sets, and vectors of as many lanes as they have.

pub(crate) mod lanes;
mod level;
pub(crate) mod vectors;

pub use level::SimdLevel;
