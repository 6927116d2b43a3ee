//! The prefix sum against `std`, on input of every size, and workgroups in rows.

use umbrage_gpu::primitives::Scan;
use umbrage_gpu::{Buffer, Gpu, Groups, Kernel, Recorder};

use super::numbers;
use crate::common;

/// Sizes from zero to 2²⁰ + 1, around all powers of two.
fn sizes() -> Vec<usize> {
    let around = (0..=20).map(|power| 1_usize << power).flat_map(|size| [size - 1, size, size + 1]);
    let mut sizes: Vec<_> = around.collect();
    sizes.dedup();
    sizes
}

fn buffer(gpu: &Gpu, contents: &[u32]) -> Buffer {
    let mut buffer = Buffer::storage(gpu, "test");
    buffer.write(gpu, contents).expect("room");
    buffer
}

#[test]
fn prefix_sums_are_those_of_std() {
    let Some(gpu) = common::gpu() else { return };
    let mut scan = Scan::new(&gpu);
    let mut values = Buffer::storage(&gpu, "values");
    for count in sizes() {
        for seed in 0..2 {
            let input = numbers(count, seed);
            let mut sum = 0_u32;
            let mut expected = Vec::with_capacity(count);
            for value in &input {
                expected.push(sum);
                sum = sum.wrapping_add(*value);
            }
            values.write(&gpu, &input).expect("room");
            scan.prepare(&gpu, count as u32).expect("room");
            let mut recorder = Recorder::new(&gpu);
            recorder.stage("scan", |pass| scan.record(&gpu, pass, &values));
            recorder.submit_and_wait().expect("done");
            assert!(values.read::<u32>(&gpu, count).expect("read") == expected, "{count} values, seed {seed}");
            let totals: Vec<u32> = scan.totals().read(&gpu, scan.total_word() as usize + 1).expect("read");
            assert_eq!(totals.last(), Some(&sum));
        }
    }
}

#[test]
fn rows_of_workgroups_take_everything() {
    let Some(gpu) = common::gpu() else { return };
    // The number of workgroups, and the last one's index plus one.
    let text = "import package::dispatch::{Invocation, flat_group};\n\
        @group(0) @binding(0) var<storage, read_write> taken: array<atomic<u32>>;\n\
        @compute @workgroup_size(1) fn take(at: Invocation) {\n\
            atomicAdd(&taken[0], 1u);\n\
            atomicMax(&taken[1], flat_group(at.group) + 1u);\n\
        }\n";
    let take = Kernel::of_text(&gpu, text, "take", &[]);
    for count in [0, 1, 65_535, 65_536, 131_071, 1 << 18] {
        let taken = buffer(&gpu, &[0, 0]);
        let mut recorder = Recorder::new(&gpu);
        recorder.stage("take", |pass| take.dispatch(&gpu, pass, &[&taken], Groups::Flat(count)));
        recorder.submit_and_wait().expect("done");
        let [groups, last] = taken.read::<[u32; 2]>(&gpu, 1).expect("read")[0];
        // The last row may have more workgroups than requested.
        assert!((count..count.max(1) + 1024).contains(&groups) && last == groups, "{groups} groups for {count}");
    }
}
