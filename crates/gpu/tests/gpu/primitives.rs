//! The building blocks against `std`, on random and adversarial input of every size.

use umbrage_gpu::primitives::{Compaction, CountingSort, Scan};
use umbrage_gpu::{Buffer, Gpu, Kernel, Recorder};

use crate::common;

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

/// Keys below `bins` in orders that are easy to get wrong, each with a name.
fn key_lists(count: usize, bins: u32) -> Vec<(&'static str, Vec<u32>)> {
    let last = bins - 1;
    let rising = |place: usize| (place as u64 * u64::from(bins) / count as u64) as u32;
    let random: Vec<u32> = common::numbers(count, 1).into_iter().map(|number| number % bins).collect();
    vec![
        ("random", random),
        ("reversed", (0..count).rev().map(rising).collect()),
        ("alternating", (0..count).map(|place| if place % 2 == 0 { last } else { 0 }).collect()),
        ("all the same", vec![last / 2; count]),
        ("all the last", vec![last; count]),
        ("sorted", (0..count).map(rising).collect()),
        ("one that isn't in its place", (0..count).map(|place| if place + 1 == count { 0 } else { last }).collect()),
    ]
}

#[test]
fn counting_sorts_are_the_stable_sort_of_std() {
    let Some(gpu) = common::gpu() else { return };
    let mut sort = CountingSort::new(&gpu);
    for (place, count) in common::sizes().into_iter().enumerate() {
        // One, two, three and eight passes, or none; numbers of bins that are powers of two, and others.
        let all_bins = [1, 2, 16, 17, 256, 1000, 4096, u32::MAX];
        // Two of them and all lists for each small size; one and three lists for the large ones, which take long.
        let (steps, lists) = if count < 1 << 13 { (0..2, 7) } else { (0..1, 3) };
        for step in steps {
            let bins = all_bins[(place + 3 * step) % all_bins.len()];
            sort.prepare(&gpu, count as u32, bins).expect("room");
            for (name, input) in key_lists(count, bins).into_iter().take(lists) {
                // Values tell whether the order is kept.
                let mut expected: Vec<(u32, u32)> = input.iter().copied().zip(0..).collect();
                expected.sort_by_key(|&(key, _)| key);
                let (expected_keys, expected_values): (Vec<u32>, Vec<u32>) = expected.into_iter().unzip();
                let values: Vec<u32> = (0..count as u32).collect();
                let (keys, values, lone_keys) = (buffer(&gpu, &input), buffer(&gpu, &values), buffer(&gpu, &input));
                let mut recorder = Recorder::new(&gpu);
                sort.record(&gpu, &mut recorder, &keys, Some(&values));
                sort.record(&gpu, &mut recorder, &lone_keys, None);
                recorder.submit()().expect("done");
                let name = format!("{count} keys below {bins}, {name}");
                assert!(keys.read::<u32>(&gpu, count).expect("read") == expected_keys, "{name}: keys");
                assert!(values.read::<u32>(&gpu, count).expect("read") == expected_values, "{name}: values");
                assert!(lone_keys.read::<u32>(&gpu, count).expect("read") == expected_keys, "{name}: keys alone");
            }
        }
    }
}

#[test]
fn compactions_are_those_of_std() {
    let Some(gpu) = common::gpu() else { return };
    let mut compaction = Compaction::new(&gpu);
    // Counts what the dispatch that is made ready takes.
    let text = "import package::dispatch::{flat_group};
        @group(0) @binding(0) var<storage, read_write> taken: array<atomic<u32>>;
        @compute @workgroup_size(1)
        fn take(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
            atomicAdd(&taken[0], 1u);
            atomicMax(&taken[1], flat_group(group, groups) + 1u);
        }"
    .replace("\n        ", "\n");
    let take = Kernel::of_text(&gpu, &text, "take", &[]);
    for count in common::sizes() {
        let elements = common::numbers(count, 3);
        let input = buffer(&gpu, &elements);
        for (name, flags) in [
            ("random", common::numbers(count, 5).into_iter().map(|number| number & 0x8000_0000).collect()),
            ("few", common::numbers(count, 7).into_iter().map(|number| u32::from(number % 97 == 0)).collect()),
            ("none", vec![0; count]),
            ("all", vec![7; count]),
            ("alternating", (0..count as u32).map(|place| place % 2).collect::<Vec<u32>>()),
            ("the last", (1..=count).map(|place| u32::from(place == count)).collect()),
        ] {
            let expected: Vec<u32> =
                elements.iter().zip(&flags).filter(|(_, flag)| **flag != 0).map(|(element, _)| *element).collect();
            // In small groups of a few, so that there are several.
            compaction.prepare(&gpu, count as u32, 5).expect("room");
            let (flags, kept, taken) = (buffer(&gpu, &flags), buffer(&gpu, &vec![0; count]), buffer(&gpu, &[0, 0]));
            let mut recorder = Recorder::new(&gpu);
            compaction.record(&gpu, &mut recorder, &flags, &input, &kept);
            recorder.stage("take", |pass| take.dispatch(&gpu, pass, &[&taken], compaction.groups()));
            recorder.submit()().expect("done");
            let name = format!("{count} elements, {name}");
            let [found] = compaction.kept_count().read::<[u32; 1]>(&gpu, 1).expect("read")[0];
            assert_eq!(found as usize, expected.len(), "{name}");
            assert!(kept.read::<u32>(&gpu, expected.len()).expect("read") == expected, "{name}");
            let [taken, last] = taken.read::<[u32; 2]>(&gpu, 1).expect("read")[0];
            // Rows of workgroups are as long as each other: a few may be more than asked for.
            let groups = expected.len().div_ceil(5) as u32;
            assert!(
                (groups..=groups + groups / 65_535 + 1).contains(&taken) && last == taken,
                "{name}: {taken} groups"
            );
            assert!(groups > 0 || taken == 0, "{name}: {taken} groups for none");
        }
    }
}
