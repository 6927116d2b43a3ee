//! Posing into a frame that has been posed before takes nothing from the heap.
#![allow(clippy::unwrap_used, reason = "a test may fail")]
#![allow(unsafe_code, reason = "an allocator that counts can't be written without")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use serde_json::json;
use umbrage_scene::Frame;

#[path = "gltf_reader/builder.rs"]
#[allow(dead_code, reason = "shared with the reader's tests, which use more of it")]
mod builder;

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

/// How often this thread has asked for memory.
fn allocations() -> usize {
    ALLOCATIONS.with(Cell::get)
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

/// A strip of 20,000 vertices, skinned and morphed, with a moving light and camera: enough for many pieces of work.
fn moving_scene() -> builder::Builder {
    let mut file = builder::Builder::new();
    let count = 20_000_u16;
    let positions: Vec<_> = (0..count).map(|vertex| [f32::from(vertex / 2), f32::from(vertex % 2), 0.0]).collect();
    let positions = file.floats(&positions);
    let normals = file.floats(&vec![[0.0, 0.0, 1.0]; usize::from(count)]);
    let tangents = file.floats(&vec![[1.0, 0.0, 0.0, 1.0]; usize::from(count)]);
    let weights = file.floats(&vec![[0.5, 0.5, 0.0, 0.0]; usize::from(count)]);
    let joints = file.accessor(builder::U8, "VEC4", usize::from(count), &[0, 1, 0, 0].repeat(usize::from(count)));
    let attributes = json!({
        "POSITION": positions, "NORMAL": normals, "TANGENT": tangents, "JOINTS_0": joints, "WEIGHTS_0": weights,
    });
    let targets = json!([{ "POSITION": normals, "NORMAL": normals, "TANGENT": normals }]);
    let mesh = file.mesh(attributes, json!({ "mode": 5, "targets": targets }));
    let light = json!({ "KHR_lights_punctual": { "light": 0 } });
    file.json["nodes"] = json!([
        { "mesh": mesh, "skin": 0 },
        { "children": [2] },
        { "camera": 0, "extensions": light },
    ]);
    file.json["skins"] = json!([{ "joints": [1, 2] }]);
    file.json["cameras"] = json!([{ "type": "perspective", "perspective": { "yfov": 1, "znear": 1 } }]);
    file.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [{ "type": "point", "name": "lamp" }] } });
    file.animate(1, "rotation", "LINEAR", &[0.0, 1.0], &[[0.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 0.0]]);
    file.animate(2, "translation", "CUBICSPLINE", &[0.0, 1.0], &[[1.0; 3]; 6]);
    file.animate(0, "weights", "LINEAR", &[0.0, 1.0], &[[0.0], [1.0]]);
    file
}

#[test]
fn later_poses_allocate_nothing() {
    let scene = moving_scene().open().unwrap();
    // On one thread, as the queues between several are allocated by the thread pool now and then.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    pool.install(|| {
        let mut frame = Frame::default();
        scene.pose(0.0, &mut frame).unwrap();
        let before = allocations();
        for step in 1..20 {
            scene.pose(f64::from(step) / 10.0, &mut frame).unwrap();
        }
        let after = allocations();
        assert_eq!(after - before, 0, "allocations in 19 poses");
        assert_eq!((frame.cameras.len(), frame.lights.len()), (1, 1));
    });
}

#[test]
fn the_counter_counts() {
    let before = allocations();
    std::hint::black_box(vec![0_u8; 100]);
    assert!(allocations() > before);
}
