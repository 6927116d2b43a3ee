//! Integer arithmetic of the shaders against Rust's f64: equal bit for bit, without any tolerance.

mod cases;
mod double;
mod mask;
mod predicate;
mod speed;
mod wide;

use umbrage_gpu::{Buffer, Gpu, Groups, Kernel, Recorder};

use crate::common;

/// The workgroup size of the tests' kernels.
const LANES: u32 = 64;

/// A test's own kernel, after the common prefix.
fn kernel(gpu: &Gpu, text: &str, entry: &'static str) -> Kernel {
    Kernel::of_text(gpu, &format!("{}{text}", include_str!("cases.wgsl")), entry, &[])
}

/// Runs `kernel` on each of `inputs`; it writes `words` u32 for each.
fn map<T: bytemuck::Pod>(gpu: &Gpu, kernel: &Kernel, inputs: &[T], words: usize) -> Vec<u32> {
    let (mut input, mut output) = (Buffer::storage(gpu, "inputs"), Buffer::storage(gpu, "outputs"));
    input.write(gpu, inputs).expect("room");
    output.reserve(gpu, (inputs.len() * words * 4) as u64).expect("room");
    let groups = Groups::Flat((inputs.len() as u32).div_ceil(LANES));
    let mut recorder = Recorder::new(gpu);
    recorder.stage("map", |pass| kernel.dispatch(gpu, pass, &[&input, &output], groups));
    recorder.submit_and_wait().expect("done");
    output.read(gpu, inputs.len() * words).expect("read")
}

/// `SplitMix64` (Steele, Lea and Flood, 2014): any number of bits, the same in every run.
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    /// From 0 to `end` − 1.
    fn below(&mut self, end: u64) -> u64 {
        self.bits() % end
    }
}
