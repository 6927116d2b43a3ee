//! Lower bounds on a GPU's time for kernels: counted, not timed, so that no GPU is needed.

use anyhow::{Context, Result};
use clap::Args;
use umbrage::gpu::Gpu;
use umbrage::scene::Frame;
use umbrage::{Renderer, Settings};
use umbrage_gpu::KernelOperations;

use crate::flags;
use crate::shot;
use crate::table::{Cell, Form, Row, Table, row};

#[derive(Debug, Args)]
pub(crate) struct RooflineFlags {
    /// Files, sequences or demo:NAME [default: the gallery]
    scenes: Vec<String>,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "1024x1024", value_parser = flags::size)]
    size: [u32; 2],
    /// Samples a pixel
    #[arg(long, value_name = "N", default_value = "1", value_parser = clap::value_parser!(u32).range(1..))]
    samples: u32,
    /// All lights of a scene rather than its first
    #[arg(long)]
    all_lights: bool,
    /// What the kernels run on, by a part of its name [default: the first]
    #[arg(long, value_name = "NAME", default_value = "", hide_default_value = true)]
    device: String,
    /// How the results are written
    #[arg(long, value_enum, default_value = "table")]
    form: Form,
}

/// A GPU's limits, by its maker's figures.
struct Machine {
    /// The title of its column, in microseconds.
    name: &'static str,
    /// Multiprocessors times their clock, per second.
    clocks: f64,
    /// In each clock of a multiprocessor: f32 operations, integer operations, and both together.
    arithmetic: [f64; 3],
    /// In each clock of a multiprocessor: words of invocations loaded or stored.
    accesses: f64,
    /// Bytes of memory a second.
    bandwidth: f64,
}

/// NVIDIA's H200 (SXM): 132 multiprocessors at 1.98 GHz, 128 lanes for f32 and 64 for integers, 32 for loads and stores.
const H200: Machine = Machine {
    name: "h200_us",
    clocks: 132.0 * 1.98e9,
    arithmetic: [128.0, 64.0, 128.0],
    accesses: 32.0,
    bandwidth: 4.8e12,
};
/// A small one: AMD's RDNA 2 with eight compute units at 1.6 GHz and 88 GB/s, as a Steam Deck has it.
const SMALL: Machine = Machine {
    name: "rdna2_8_us",
    clocks: 8.0 * 1.6e9,
    arithmetic: [64.0, 64.0, 64.0],
    accesses: 16.0,
    bandwidth: 88e9,
};

/// Bounds on a kernel's time.
const BOUNDS: [&str; 3] = ["arithmetic", "accesses", "bytes"];

impl Machine {
    /// Minimum microseconds of a kernel, and the one of [`BOUNDS`] that decides.
    fn least(&self, of: &KernelOperations) -> (f64, &'static str) {
        // Invocations wait for the busiest in their group.
        let waiting = of.lockstep as f64 / (of.floats + of.integers).max(1) as f64;
        let [floats, integers, both] = self.arithmetic;
        let accesses = of.accesses + of.shared;
        let arithmetic = (of.floats as f64 / floats)
            .max(of.integers as f64 / integers)
            .max((of.floats + of.integers + accesses) as f64 / both);
        let seconds = [
            waiting * arithmetic / self.clocks,
            accesses as f64 / self.accesses / self.clocks,
            (of.bytes_read + of.bytes_written) as f64 / self.bandwidth,
        ];
        let all = seconds.map(|seconds| 1e6 * seconds).into_iter().zip(BOUNDS);
        all.max_by(|(first, _), (second, _)| first.total_cmp(second)).expect("three of them")
    }
}

/// Kernels with a smaller share of a frame are summed up in its last row only.
const SMALLEST_SHARE: f64 = 0.01;

const NOTES: [&str; 3] = [
    "f32 to written: of each invocation; loads, stores and bytes as often as they are asked for, from caches too.",
    "in_use: the part of 32 invocations' arithmetic that isn't spent waiting for the busiest of them.",
    "Least microseconds by the makers' figures for arithmetic, loads and stores, or bytes, whichever takes the longest.",
];

pub(crate) fn run(flags: &RooflineFlags) -> Result<()> {
    let [width, height] = flags.size;
    let lights = if flags.all_lights { "all lights" } else { "the first light" };
    let title =
        format!("{width}x{height}, samples {}, {lights}: what kernels do, counted while they run", flags.samples);
    let mut table = Table::start(flags.form, &title)?;
    for address in shot::or_gallery(&flags.scenes) {
        let kernels = flags.count(&address).with_context(|| format!("scene {address}"))?;
        let frame: f64 = kernels.iter().map(|kernel| H200.least(kernel).0).sum();
        let mut rows: Vec<_> = kernels.iter().map(|kernel| (H200.least(kernel).0, kernel)).collect();
        rows.retain(|(least, _)| *least >= SMALLEST_SHARE * frame);
        rows.sort_by(|(first, _), (second, _)| second.total_cmp(first));
        rows.into_iter().try_for_each(|(_, kernel)| table.push(of_kernel(&address, kernel)))?;
        table.push(of_frame(&address, &kernels))?;
    }
    Ok(table.finish(&NOTES)?)
}

fn of_kernel(address: &str, of: &KernelOperations) -> Row {
    let each = |count: u64| Cell::Number(count as f64 / of.invocations as f64, 1);
    let (least, bound) = H200.least(of);
    row![
        ("kernel", of.kernel.as_str()),
        ("scene", address),
        ("runs", of.dispatches),
        ("invocations", of.invocations),
        ("f32", each(of.floats)),
        ("integer", each(of.integers)),
        ("accesses", each(of.accesses)),
        ("shared", each(of.shared)),
        ("read", each(of.bytes_read)),
        ("written", each(of.bytes_written)),
        ("in_use", (of.floats + of.integers) as f64 / of.lockstep.max(1) as f64),
        (H200.name, Cell::Number(least, 1)),
        ("bound_by", bound),
        (SMALL.name, Cell::Number(SMALL.least(of).0, 0)),
    ]
}

/// The sums of all kernels.
fn of_frame(address: &str, kernels: &[KernelOperations]) -> Row {
    let sum = |machine: &Machine| kernels.iter().map(|kernel| machine.least(kernel).0).sum();
    let nothing = || Cell::Nothing;
    row![
        ("kernel", "whole frame"),
        ("scene", address),
        ("runs", kernels.iter().map(|kernel| kernel.dispatches).sum::<u64>()),
        ("invocations", kernels.iter().map(|kernel| kernel.invocations).sum::<u64>()),
        ("f32", nothing()),
        ("integer", nothing()),
        ("accesses", nothing()),
        ("shared", nothing()),
        ("read", nothing()),
        ("written", nothing()),
        ("in_use", nothing()),
        (H200.name, Cell::Number(sum(&H200), 1)),
        ("bound_by", nothing()),
        (SMALL.name, Cell::Number(sum(&SMALL), 0)),
    ]
}

impl RooflineFlags {
    /// Counts of each kernel in a frame in the middle of a scene's animation.
    fn count(&self, address: &str) -> Result<Vec<KernelOperations>> {
        let gpu = Gpu::open_counting(&self.device)?;
        let mut renderer = Renderer::with_gpu(gpu.clone())?;
        let scene = umbrage::open(address)?;
        let seconds = 0.4 * scene.duration_seconds();
        let [width, height] = self.size;
        let mut settings = Settings { width, height, samples: self.samples, ..Settings::default() };
        if !self.all_lights {
            let mut frame = Frame::default();
            scene.pose(0.0, &mut frame)?;
            frame.lights.truncate(1);
            settings.lights = Some(frame.lights);
        }
        // Lists are large enough from the second frame on.
        renderer.render(&scene, 0.0, &settings)?;
        renderer.render(&scene, seconds, &settings)?;
        gpu.take_operations()?;
        renderer.render(&scene, seconds, &settings)?;
        Ok(gpu.take_operations()?)
    }
}
