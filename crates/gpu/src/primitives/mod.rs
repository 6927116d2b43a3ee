//! Building blocks of the stages, with contracts of their own: prefix sum, counting sort, compaction.

mod compact;
mod scan;
mod sort;

pub use compact::Compaction;
pub use scan::Scan;
pub use sort::CountingSort;
