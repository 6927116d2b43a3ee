//! Building blocks of the stages, with contracts of their own: prefix sum, counting sort, compaction.

mod scan;

pub use scan::Scan;
