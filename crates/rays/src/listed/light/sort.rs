use crate::counting_sort::{count, next_index};

/// Something in a cell: a point's pixel, or a triangle.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Entry {
    pub(super) column: u16,
    pub(super) row: u16,
    pub(super) item: u32,
}

/// What one range of points or triangles has in cells.
#[derive(Debug, Default)]
pub(super) struct Bins {
    /// In the order in which they were found.
    pub(super) unsorted: Vec<Entry>,
    /// Sorted by row.
    sorted: Vec<Entry>,
    starts: Vec<u32>,
}

impl Bins {
    pub(super) fn bytes(&self) -> usize {
        (self.unsorted.capacity() + self.sorted.capacity()) * size_of::<Entry>()
            + self.starts.capacity() * size_of::<u32>()
    }

    /// Sorts by row.
    pub(super) fn sort(&mut self, rows: usize) {
        let Self { unsorted, sorted, starts } = self;
        sorted.resize(count(starts, rows, unsorted.iter().map(|entry| entry.row as usize)), Entry::default());
        for entry in unsorted {
            sorted[next_index(starts, entry.row as usize)] = *entry;
        }
    }

    /// What is in a row.
    pub(super) fn row(&self, row: usize) -> &[Entry] {
        &self.sorted[self.starts[row] as usize..self.starts[row + 1] as usize]
    }
}

/// What is in the cells of a row, sorted by column.
#[derive(Debug, Default)]
pub(super) struct SortedRow {
    starts: Vec<u32>,
    items: Vec<u32>,
}

impl SortedRow {
    pub(super) fn bytes(&self) -> usize {
        (self.starts.capacity() + self.items.capacity()) * size_of::<u32>()
    }

    /// Takes over a row's entries, in the order of what they stand for.
    pub(super) fn sort(&mut self, columns: usize, entries: impl Iterator<Item = Entry> + Clone) {
        let total = count(&mut self.starts, columns, entries.clone().map(|entry| entry.column as usize));
        self.items.resize(total, 0);
        for entry in entries {
            self.items[next_index(&mut self.starts, entry.column as usize)] = entry.item;
        }
    }

    /// Where a cell's items are among the row's.
    pub(super) fn range(&self, column: usize) -> std::ops::Range<usize> {
        self.starts[column] as usize..self.starts[column + 1] as usize
    }

    /// All items of the row.
    pub(super) fn items(&self) -> &[u32] {
        &self.items
    }
}
