//! Times of a GPU for empty work: the floor under every frame.

use std::time::Instant;

use anyhow::Result;
use umbrage::gpu::Gpu;
use umbrage_gpu::{Buffer, Groups, Kernel, Recorder};

use crate::measure::median;
use crate::table::{Row, row};

const KERNEL: &str = "
@group(0) @binding(0) var<storage, read_write> words: array<u32>;

@compute @workgroup_size(64)
fn nothing() {
    words[0] = 1u;
}
";

/// Number of rounds.
const ROUNDS: usize = 30;
/// Number of dispatches, or of stages, beside a single one.
const MANY: usize = 101;
const COPIED_BYTES: usize = 64 << 20;

/// Medians by the CPU's clock: each operation, and its time.
pub(crate) fn measure(gpu: &Gpu) -> Result<Vec<Row>> {
    let kernel = Kernel::of_text(gpu, KERNEL, "nothing", &[]);
    let mut words = Buffer::storage(gpu, "words");
    words.reserve(gpu, COPIED_BYTES as u64)?;
    let frame = |stages: usize, dispatches: usize| {
        median_microseconds(|| {
            let mut recorder = Recorder::new(gpu);
            for _ in 0..stages {
                recorder.stage("nothing", |pass| {
                    for _ in 0..dispatches {
                        kernel.dispatch(gpu, pass, &[&words], Groups::Flat(1));
                    }
                });
            }
            recorder.submit_and_wait()?;
            Ok(())
        })
    };
    let (one, dispatches, stages) = (frame(1, 1)?, frame(1, MANY)?, frame(MANY, 1)?);
    let further = (MANY - 1) as f64;
    let contents = vec![1_u8; COPIED_BYTES];
    let upload = median_microseconds(|| {
        words.write(gpu, &contents)?;
        Ok(gpu.wait()?)
    })?;
    let fetch = median_microseconds(|| {
        words.read::<u8>(gpu, COPIED_BYTES)?;
        Ok(())
    })?;
    let of = |what: &str, microseconds: f64| row![("work", what), ("microseconds", microseconds)];
    Ok(vec![
        of("submit one dispatch and wait for it", one),
        of("a further dispatch", (dispatches - one) / further),
        of("a further stage", (stages - one) / further),
        of("upload 64 MiB", upload),
        of("fetch 64 MiB", fetch),
    ])
}

fn median_microseconds(mut work: impl FnMut() -> Result<()>) -> Result<f64> {
    let mut times = Vec::new();
    for _ in 0..ROUNDS {
        let start = Instant::now();
        work()?;
        times.push(1e6 * start.elapsed().as_secs_f64());
    }
    Ok(median(times))
}
