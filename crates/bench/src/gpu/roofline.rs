//! How long a GPU takes at least for what kernels do: counted, not timed, so that no GPU is needed.

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

/// What a GPU can do at most, by its maker's figures.
struct Machine {
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

/// NVIDIA's figures for H200 (SXM): 132 multiprocessors at 1.98 GHz, 128 lanes for f32 and 64 for integers, 32 for loads.
const H200: Machine = Machine {
    name: "H200",
    clocks: 132.0 * 1.98e9,
    arithmetic: [128.0, 64.0, 128.0],
    accesses: 32.0,
    bandwidth: 4.8e12,
};
/// A small one: AMD's RDNA 2 with 8 compute units at 1.6 GHz, as in a Steam Deck, with 88 GB/s.
const SMALL: Machine =
    Machine { name: "8 CUs", clocks: 8.0 * 1.6e9, arithmetic: [64.0, 64.0, 64.0], accesses: 16.0, bandwidth: 88e9 };

impl Machine {
    /// The least milliseconds that a kernel takes: of its arithmetic, its loads and stores, and its bytes.
    fn bounds(&self, of: &KernelOperations) -> [f64; 3] {
        // Invocations wait for the busiest of those that go together.
        let waiting = of.lockstep as f64 / (of.floats + of.integers).max(1) as f64;
        let [floats, integers, both] = self.arithmetic;
        let accesses = of.accesses + of.shared;
        let arithmetic = (of.floats as f64 / floats)
            .max(of.integers as f64 / integers)
            .max((of.floats + of.integers + accesses) as f64 / both);
        [
            1e3 * waiting * arithmetic / self.clocks,
            1e3 * accesses as f64 / self.accesses / self.clocks,
            1e3 * (of.bytes_read + of.bytes_written) as f64 / self.bandwidth,
        ]
    }
}

pub(crate) fn run(flags: &RooflineFlags) -> Result<()> {
    let [width, height] = flags.size;
    let lights = if flags.all_lights { "all lights" } else { "the first light" };
    let title =
        format!("{width}x{height}, samples {}, {lights}: what kernels do, and the least that it takes", flags.samples);
    let mut table = Table::start(flags.form, &title)?;
    for address in shot::or_gallery(&flags.scenes) {
        let kernels = flags.count(&address).with_context(|| format!("scene {address}"))?;
        let mut sums = [0.0; 2];
        for kernel in &kernels {
            for (sum, machine) in sums.iter_mut().zip([H200, SMALL]) {
                *sum += machine.bounds(kernel).into_iter().fold(0.0, f64::max);
            }
            table.push(row_of(&address, kernel))?;
        }
        table.note(&format!("{address}: {:.3} ms on {}, {:.1} ms on {}", sums[0], H200.name, sums[1], SMALL.name))?;
    }
    Ok(table.finish(&[])?)
}

impl RooflineFlags {
    /// What each kernel does in a frame in the middle of a scene's animation.
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
        // Lists have room for what is in them from the second frame on.
        renderer.render(&scene, 0.0, &settings)?;
        renderer.render(&scene, seconds, &settings)?;
        gpu.take_operations()?;
        renderer.render(&scene, seconds, &settings)?;
        Ok(gpu.take_operations()?)
    }
}

fn row_of(address: &str, of: &KernelOperations) -> Row {
    let each = |count: u64| Cell::Number(count as f64 / of.invocations as f64, 1);
    let [arithmetic, accesses, bytes] = H200.bounds(of);
    let small = SMALL.bounds(of).into_iter().fold(0.0, f64::max);
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
        ("in_use", Cell::Number((of.floats + of.integers) as f64 / of.lockstep.max(1) as f64, 2)),
        ("us_arithmetic", Cell::Number(1e3 * arithmetic, 1)),
        ("us_accesses", Cell::Number(1e3 * accesses, 1)),
        ("us_bytes", Cell::Number(1e3 * bytes, 1)),
        ("us_small", Cell::Number(1e3 * small, 0)),
    ]
}
