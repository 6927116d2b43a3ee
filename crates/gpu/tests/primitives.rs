//! The building blocks against `std`, on random and adversarial input of every size.

mod common;

use umbrage_gpu::primitives::Scan;
use umbrage_gpu::{Buffer, Recorder};

#[test]
fn prefix_sums_are_those_of_std() {
    let Some(gpu) = common::gpu() else { return };
    let mut scan = Scan::new(&gpu);
    let mut values = Buffer::storage(&gpu, "values");
    for count in common::sizes() {
        for seed in 0..2 {
            let input = common::numbers(count, seed);
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
            recorder.submit()().expect("done");
            assert!(values.read::<u32>(&gpu, count).expect("read") == expected, "{count} values, seed {seed}");
            let totals: Vec<u32> = scan.totals().read(&gpu, scan.total_word() as usize + 1).expect("read");
            assert_eq!(totals.last(), Some(&sum));
        }
    }
}
