//! Counts of kernels' operations.

use umbrage_gpu::{Buffer, Gpu, Groups, Kernel, KernelOperations, Recorder};

use crate::common;

/// Adds up numbers in a loop with as many turns as the invocation's index.
const SUMS: &str = "import package::dispatch::{Invocation, flat_index};
@group(0) @binding(0) var<storage, read_write> sums: array<u32>;
@compute @workgroup_size(64)
fn add_up(at: Invocation) {
    let index = flat_index(at, 64u);
    if index >= 100u {
        return;
    }
    var sum = 0u;
    for (var turn = 0u; turn < index; turn++) {
        sum += turn;
    }
    sums[index] = sum;
}
";

#[test]
fn what_is_in_a_loop_counts_once_a_turn() {
    if common::adapter().is_none() {
        return;
    }
    let gpu = Gpu::open_counting("").expect("the same adapter");
    let once = run(&gpu, SUMS);
    let twice = run(&gpu, &SUMS.replace("sum += turn", "sum += turn * 2u / 2u"));
    assert_eq!((once.dispatches, once.invocations), (1, 128));
    assert_eq!((once.accesses, once.bytes_written, once.bytes_read, once.floats), (100, 400, 0, 0));
    // A product is an operation, a division 20; the last invocation has 99 turns.
    let turns: u64 = (0..100).sum();
    assert_eq!(twice.integers - once.integers, 21 * turns);
    assert_eq!(twice.lockstep - once.lockstep, 21 * 32 * (31 + 63 + 95 + 99));
}

/// Runs a kernel, checks its sums, and returns its counts.
fn run(gpu: &Gpu, text: &str) -> KernelOperations {
    let kernel = Kernel::of_text(gpu, text, "add_up", &[]);
    let mut sums = Buffer::storage(gpu, "sums");
    sums.reserve(gpu, 400).expect("room");
    let mut recorder = Recorder::new(gpu);
    recorder.stage("add up", |pass| kernel.dispatch(gpu, pass, &[&sums], Groups::Flat(2)));
    recorder.submit_and_wait().expect("done");
    let expected: Vec<u32> = (0..100).map(|index| (0..index).sum()).collect();
    assert_eq!(sums.read::<u32>(gpu, 100).expect("read"), expected);
    let [operations] = &gpu.take_operations().expect("counted")[..] else { panic!("one kernel") };
    operations.clone()
}
