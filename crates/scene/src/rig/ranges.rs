//! Which of many parts have which elements, where the elements of parts follow each other without gaps.

use std::ops::Range;

/// Elements below which a piece of work is not worth sharing between threads.
pub(crate) const GRAIN: usize = 4096;

/// Of parts in the order of their elements, which have no gaps, those of which any element is in `elements`.
pub(crate) fn overlapping<'a, T>(parts: &'a [T], elements: &Range<usize>, first: impl Fn(&T) -> u32) -> &'a [T] {
    let from = parts.partition_point(|part| first(part) as usize <= elements.start).saturating_sub(1);
    let to = parts.partition_point(|part| (first(part) as usize) < elements.end);
    &parts[from.min(to)..to]
}

/// What `range` of the frame's elements has in common with a part's `count` ones from `first` on: as indices into the
/// range, and as indices into the part.
pub(crate) fn overlap(range: &Range<usize>, first: usize, count: usize) -> (Range<usize>, Range<usize>) {
    let start = range.start.max(first);
    let end = range.end.min(first + count).max(start);
    (start - range.start..end - range.start, start - first..end - first)
}
