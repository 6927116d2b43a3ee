//! An allocator that counts, for tests that nothing is taken from the heap. Whatever program uses this crate allocates
//! with it.
#![allow(unsafe_code, reason = "an allocator that counts can't be written without")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

/// The system's allocator, counting how often each thread asks it for memory.
struct Counting;

#[global_allocator]
static COUNTING: Counting = Counting;

thread_local! {
    // Needs neither initialisation nor a destructor, so that counting allocates nothing.
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

/// How often this thread has asked for memory.
pub fn on_this_thread() -> usize {
    ALLOCATIONS.with(Cell::get)
}

fn count() {
    // A thread that is ending has no counter any more.
    let _ = ALLOCATIONS.try_with(|count| count.set(count.get() + 1));
}

// SAFETY: every call is handed to the system's allocator unchanged, and counting allocates nothing.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: the caller keeps the contract of `GlobalAlloc::alloc`, which is the same.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: `pointer` came from `System`, as all of this allocator's memory does.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, new_size: usize) -> *mut u8 {
        count();
        // SAFETY: as for `dealloc`; the caller keeps the contract of the new size.
        unsafe { System.realloc(pointer, layout, new_size) }
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn vectors_are_counted() {
        let before = super::on_this_thread();
        let mut vector = std::hint::black_box(vec![0_u8; 100]);
        assert_eq!(super::on_this_thread() - before, 1);
        vector.reserve_exact(1_000);
        assert_eq!(super::on_this_thread() - before, 2);
        drop(vector);
        assert_eq!(super::on_this_thread() - before, 2, "giving back takes nothing");
    }
}
