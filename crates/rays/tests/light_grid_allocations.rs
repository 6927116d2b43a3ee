//! A light grid that has seen a frame of the same size takes nothing from the heap.
#![allow(unsafe_code, reason = "an allocator that counts can't be written without")]

#[allow(dead_code, reason = "shared by tests of which each uses a part")]
mod meshes;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use glam::{DVec2, Vec3};
use meshes::{Mesh, Random};
use umbrage_rays::{Bvh, Camera, LightGrid, LightSource, SeenImage, View};

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
static COUNTING: Counting = Counting;

#[test]
fn a_steady_frame_allocates_nothing() {
    let mut mesh = Mesh::default();
    mesh.ball(Vec3::ZERO, 1.0, 12, 0.1);
    mesh.quad([(-3.0, -3.0), (3.0, -3.0), (3.0, 3.0), (-3.0, 3.0)].map(|(x, z)| Vec3::new(x, -1.2, z)));
    let mesh = mesh.placed(1.5, Vec3::Y);
    let mut bvh = Bvh::default();
    bvh.build(mesh.triangles());
    let camera = Camera::look_at(Vec3::new(1.0, 3.0, 6.0), Vec3::ZERO, Vec3::Y, 0.8);
    let view = View { camera, width: 150, height: 111 };
    let offset_pixels = DVec2::splat(0.5);
    let see = |pixel: u32| {
        let ray = view.ray(f64::from(pixel % 150) + 0.5, f64::from(pixel / 150) + 0.5);
        bvh.nearest(mesh.triangles(), &ray, |_| true).map_or(SeenImage::NOTHING, |hit| hit.triangle)
    };
    let seen: Vec<u32> = (0..150 * 111).map(see).collect();
    let image = SeenImage { triangles: mesh.triangles(), view, offset_pixels, triangle_of_pixel: &seen };
    let place = Random(4).point() * 0.3 + Vec3::new(0.5, 4.0, 1.0);
    let lights = [
        LightSource::Point { position: place },
        LightSource::Point { position: Vec3::new(1.8, -0.5, 1.0) },
        LightSource::Directional { direction: Vec3::new(0.2, -1.0, 0.1) },
    ];
    let mut lit = vec![0; seen.len().div_ceil(64)];
    // One thread, on which rayon takes no memory either.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
    pool.install(|| {
        let mut grid = LightGrid::default();
        let mut frame = || {
            let before = ALLOCATIONS.with(Cell::get);
            grid.locate(&image);
            lights.iter().for_each(|light| grid.shadow(&image, light, |_| true, |_, _| true, &mut lit));
            ALLOCATIONS.with(Cell::get) - before
        };
        assert!(frame() > 0);
        assert_eq!([frame(), frame()], [0, 0]);
    });
}
