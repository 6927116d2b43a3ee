//! A frame like the one before takes nothing from the heap.
#![allow(unsafe_code, reason = "an allocator that counts can't be written without")]

mod support;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use glam::{DVec2, Vec3};
use support::{Mesh, Random, view};
use umbrage_rays::{PerspectiveGrid, SeenPixels};

/// The system's allocator, counting how often each thread asks it for memory.
struct Counting;

thread_local! {
    // Needs neither initialisation nor a destructor, so that counting allocates nothing.
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
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

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn the_second_frame_allocates_nothing() {
    let mut mesh = Mesh::soup(&mut Random(1), 2000, 0.01);
    mesh.append(&Mesh::bumpy_ball(Vec3::ZERO, 1.0, 40));
    mesh.append(&Mesh::floor(1, 100.0));
    mesh.positions[17].x = f32::NAN;
    let view = view(200, 150);
    // One thread does all the work, and is the one whose allocations are counted.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    let allocations = pool.install(|| {
        let mut grid = PerspectiveGrid::default();
        let mut seen = SeenPixels::default();
        [0; 3].map(|_| {
            let before = ALLOCATIONS.with(Cell::get);
            grid.build(mesh.triangles(), &view, DVec2::splat(0.5), |_| false).expect("a small image");
            grid.trace(mesh.triangles(), |_| true, &mut seen);
            ALLOCATIONS.with(Cell::get) - before
        })
    });
    assert!(allocations[0] > 100, "the first frame is counted: {allocations:?}");
    assert_eq!(allocations[1..], [0, 0]);
}
