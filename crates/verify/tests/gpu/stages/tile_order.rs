//! Slots in tiles on the GPU are those of `umbrage_rays`.

use umbrage_gpu::{Buffer, Groups, Kernel, Recorder};
use umbrage_rays::TileOrder;

use crate::common;

const TEXT: &str = "\
import package::dispatch::{Invocation, flat_index};
import package::tile_order::{pixel_of_slot, slot_of_pixel};
@group(0) @binding(0) var<uniform> size: vec4<u32>;
@group(0) @binding(1) var<storage, read_write> found: array<vec3<u32>>;
@compute @workgroup_size(64)
fn find(at: Invocation) {
    let slot = flat_index(at, 64u);
    if slot < size.y {
        let pixel = pixel_of_slot(slot, size.x);
        found[slot] = vec3<u32>(pixel, slot_of_pixel(pixel, size.x));
    }
}
";

#[test]
fn slots_and_pixels_are_those_of_tile_order() {
    let Some(gpu) = common::gpu() else { return };
    let kernel = Kernel::of_text(&gpu, TEXT, "find", &[]);
    let (mut size, mut found) = (Buffer::uniform(&gpu, "size"), Buffer::storage(&gpu, "found"));
    for (width, height) in [(1, 1), (64, 64), (65, 3), (200, 130), (1000, 70)] {
        let order = TileOrder::new(width, height);
        let slots = order.slots();
        size.write(&gpu, &[width, slots as u32, 0, 0]).expect("room");
        found.reserve(&gpu, slots as u64 * 16).expect("room");
        let mut recorder = Recorder::new(&gpu);
        recorder.stage("find", |pass| {
            kernel.dispatch(&gpu, pass, &[&size, &found], Groups::Flat(slots as u32 / 64));
        });
        recorder.submit_and_wait().expect("done");
        let found: Vec<[u32; 4]> = found.read(&gpu, slots).expect("read");
        for (slot, [x, y, again, _]) in found.into_iter().enumerate() {
            assert_eq!((x, y), order.column_and_row(slot), "{width}x{height}");
            assert_eq!(again as usize, slot, "{width}x{height}");
        }
    }
}
