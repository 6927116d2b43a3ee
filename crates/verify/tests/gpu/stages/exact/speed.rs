//! Speed of the predicate; not a test, since it depends on the machine.

use glam::DVec3;
use umbrage_gpu::{Buffer, Gpu, Groups, Kernel, Recorder};
use umbrage_rays::Ray;

use super::cases::{Pair, Shadowing};
use super::predicate::{ANSWER_WORDS, kernel, pair_case, shadow_case};
use super::{LANES, Random, common};

/// Times are the processor's, of all threads together. Mesa keeps compiled shaders on disk; without, the first dispatch
/// compiles. Run with `MESA_SHADER_CACHE_DISABLE=true cargo test --release -p umbrage-verify --test gpu exact::speed -- --ignored --nocapture`.
#[test]
#[ignore = "a measurement"]
fn speed() {
    let Some(gpu) = common::gpu() else { return };
    println!("{}", gpu.adapter().name);
    let count = 1 << 16;
    let mut random = Random(6);
    let mut of_kind = |kinds: &[u64]| -> Vec<_> {
        (0..count).map(|index| Pair::of_kind(&mut random, kinds[index % kinds.len()])).collect()
    };
    let lists = [("decided in f64", of_kind(&[1, 2])), ("exact at a corner or an edge", of_kind(&[3, 4]))];
    let start = processor_seconds();
    let crossings = kernel(&gpu, "crossings");
    println!("crossings: {:.0} ms to make the pipeline", (processor_seconds() - start) * 1e3);
    for (name, pairs) in &lists {
        let cases: Vec<_> = pairs.iter().map(pair_case).collect();
        println!("crossings, {name}: {}", rate(&gpu, &crossings, &cases));
    }
    let start = processor_seconds();
    let shadows = kernel(&gpu, "shadows");
    println!("shadows: {:.0} ms to make the pipeline", (processor_seconds() - start) * 1e3);
    let mut random = Random(7);
    for (name, pairs) in &lists {
        let cases: Vec<_> = pairs.iter().map(|pair| shadow_case(&beyond(&mut random, pair))).collect();
        println!("shadows, {name}: {}", rate(&gpu, &shadows, &cases));
    }
}

/// A case with the pair's triangle between a light at the ray's origin and a point on the ray.
fn beyond(random: &mut Random, pair: &Pair) -> Shadowing {
    let ray = Ray::new(DVec3::ZERO, pair.ray.origin + pair.ray.direction * 2.0);
    let light = pair.ray.origin.as_vec3();
    Shadowing { ray, t: 1.0, is_directional: random.below(2) == 0, light, corners: pair.corners }
}

/// CPU seconds of all threads of this process, which don't depend on other work on the machine.
fn processor_seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").expect("Linux");
    let fields: Vec<f64> = stat.split(' ').filter_map(|field| field.parse().ok()).collect();
    (fields[11] + fields[12]) * 0.01
}

fn rate<T: bytemuck::Pod>(gpu: &Gpu, kernel: &Kernel, cases: &[T]) -> String {
    let (mut input, mut output) = (Buffer::storage(gpu, "inputs"), Buffer::storage(gpu, "outputs"));
    input.write(gpu, cases).expect("room");
    output.reserve(gpu, (cases.len() * ANSWER_WORDS * 4) as u64).expect("room");
    let seconds = (0..5).map(|_| {
        let mut recorder = Recorder::new(gpu);
        let groups = Groups::Flat((cases.len() as u32).div_ceil(LANES));
        recorder.stage("predicate", |pass| kernel.dispatch(gpu, pass, &[&input, &output], groups));
        let start = processor_seconds();
        recorder.submit_and_wait().expect("done");
        processor_seconds() - start
    });
    let seconds: Vec<_> = seconds.collect();
    let best = seconds.iter().copied().fold(f64::INFINITY, f64::min);
    format!(
        "{:.2} M pairs/s (first {:.0} ms, best {:.1} ms)",
        cases.len() as f64 * 1e-6 / best,
        seconds[0] * 1e3,
        best * 1e3
    )
}
