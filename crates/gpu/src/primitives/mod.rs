//! Building blocks of the stages, with contracts of their own: the prefix sum.

mod scan;

pub use scan::Scan;
