//! An allocator that counts, for tests that nothing is taken from the heap, or not too much. Whatever program uses this
//! crate allocates with it.
#![allow(unsafe_code, reason = "an allocator that counts can't be written without")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::atomic::{AtomicUsize, Ordering};

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

/// Bytes that the program holds, and the most that it may.
static HELD: AtomicUsize = AtomicUsize::new(0);
static MOST: AtomicUsize = AtomicUsize::new(usize::MAX);

/// From now on the program is refused memory beyond so many bytes in all, as if the machine had no more.
pub fn refuse_beyond(bytes: usize) {
    MOST.store(bytes, Ordering::Relaxed);
}

/// Counts the change from `old` to `new` bytes, if there may be as many.
fn count(old: usize, new: usize) -> bool {
    // A thread that is ending has no counter any more.
    let _ = ALLOCATIONS.try_with(|count| count.set(count.get() + 1));
    let held = HELD.fetch_add(new.wrapping_sub(old), Ordering::Relaxed).wrapping_add(new).wrapping_sub(old);
    let may = new <= old || held <= MOST.load(Ordering::Relaxed);
    if !may {
        HELD.fetch_sub(new - old, Ordering::Relaxed);
    }
    may
}

// SAFETY: every call is handed to the system's allocator unchanged, or refused as it may; counting allocates nothing.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        if !count(0, layout.size()) {
            return std::ptr::null_mut();
        }
        // SAFETY: the caller keeps the contract of `GlobalAlloc::alloc`, which is the same.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        HELD.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: `pointer` came from `System`, as all of this allocator's memory does.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, new_size: usize) -> *mut u8 {
        if !count(layout.size(), new_size) {
            return std::ptr::null_mut();
        }
        // SAFETY: as for `dealloc`; the caller keeps the contract of the new size.
        unsafe { System.realloc(pointer, layout, new_size) }
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn what_is_too_much_is_refused() {
        super::refuse_beyond(1 << 26);
        assert!(Vec::<u8>::new().try_reserve_exact(1 << 27).is_err());
        assert!(Vec::<u8>::new().try_reserve_exact(1 << 20).is_ok());
        super::refuse_beyond(usize::MAX);
    }

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
