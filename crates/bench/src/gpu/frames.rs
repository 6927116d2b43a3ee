//! Frames on a GPU, stage by stage, by its own clock.

use std::time::Instant;

use anyhow::Result;
use umbrage::gpu::{DeviceLimits, Gpu};
use umbrage::scene::Frame;
use umbrage::{Renderer, Settings};

use crate::measure::median;
use crate::shot::moments;
use crate::table::{Cell, Row, row};

/// Columns of the table, and the stages that each sums up.
const GROUPS: [(&str, &[&str]); 9] = [
    ("project", &["project"]),
    ("list", &["count", "scan", "scatter", "balance"]),
    ("trace", &["trace"]),
    ("settle", &["settle"]),
    ("points", &["survey", "choose", "map", "spread", "sort"]),
    ("lights", &["light project", "light count", "light scan", "light scatter", "light balance"]),
    ("shadow", &["light trace"]),
    ("settle", &["light settle"]),
    ("shade", &["shade"]),
];

/// Stages that aren't part of finding triangles and shadows, or happen on the CPU.
const BESIDE: [&str; 6] = ["animate", "build", "pose", "omit", "shade", "fetch"];

/// Conditions of a measurement.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Course<'a> {
    /// The GPU, by a part of its name.
    pub(crate) device: &'a str,
    pub(crate) size: [u32; 2],
    pub(crate) samples: u32,
    /// Counted frames; one more comes first.
    pub(crate) frames: u32,
    /// Whether the scene's first light is the only one.
    pub(crate) has_one_light: bool,
}

/// Times of a scene's frames: medians, in milliseconds.
#[derive(Debug)]
pub(crate) struct Measured {
    /// Columns of the scene.
    head: Row,
    /// Each stage by the GPU's clock.
    stages: Vec<(&'static str, f64)>,
    /// Sum of the stages, the whole frame by the CPU's clock, and memory.
    tail: Row,
}

impl Measured {
    /// For people: a row of groups of stages.
    pub(crate) fn grouped(&self) -> Row {
        let groups = GROUPS.iter().map(|(group, names)| {
            let time = self.stages.iter().filter(|(name, _)| names.contains(name)).map(|(_, time)| time).sum();
            ((*group).to_owned(), Cell::Number(time, 3))
        });
        self.row(groups.collect())
    }

    /// For programs: a row for each stage.
    pub(crate) fn each_stage(&self) -> Vec<Row> {
        let of_stage =
            |(name, time): &(&str, f64)| self.row(row![("stage", *name), ("milliseconds", Cell::Number(*time, 4))]);
        self.stages.iter().map(of_stage).collect()
    }

    fn row(&self, middle: Row) -> Row {
        self.head.iter().cloned().chain(middle).chain(self.tail.iter().cloned()).collect()
    }
}

/// Note below a table of grouped stages.
pub(crate) const NOTE: &str =
    "traced: all that finds what pixels see and what lights reach; wall: the whole frame by the CPU's clock.";

impl Course<'_> {
    /// Opens the GPU.
    pub(crate) fn open(&self) -> Result<Gpu> {
        Ok(Gpu::open(self.device, DeviceLimits::Adapter)?)
    }

    /// Renders frames of the scene at `address`.
    pub(crate) fn measure(&self, address: &str) -> Result<Measured> {
        // Each scene has a device of its own: buffers stay as large as the largest scene needed them.
        let mut renderer = Renderer::with_gpu(self.open()?)?;
        let scene = umbrage::open(address)?;
        let [width, height] = self.size;
        let mut settings = Settings { width, height, samples: self.samples, ..Settings::default() };
        if self.has_one_light {
            let mut frame = Frame::default();
            scene.pose(0.0, &mut frame)?;
            frame.lights.truncate(1);
            settings.lights = Some(frame.lights);
        }
        let mut frames = Vec::new();
        let mut walls = Vec::new();
        // The first frame compiles kernels as well.
        for (seconds, is_counted) in moments(&scene, self.frames) {
            let start = Instant::now();
            renderer.render(&scene, seconds, &settings)?;
            if is_counted {
                walls.push(1e3 * start.elapsed().as_secs_f64());
                frames.push(renderer.stats().stages.clone());
            }
        }
        let stats = renderer.stats();
        let of_frames = |is_meant: &dyn Fn(&str) -> bool| {
            median(frames.iter().map(|stages| {
                stages.iter().filter(|stage| is_meant(stage.name)).map(|stage| stage.milliseconds).sum::<f64>()
            }))
        };
        let pixels = f64::from(width) * f64::from(height);
        let bytes = |bytes: usize, each: f64| Cell::Number(bytes as f64 / each, 1);
        Ok(Measured {
            head: row![("scene", address), ("triangles", stats.triangles), ("lights", stats.lights)],
            stages: stats.stages.iter().map(|stage| (stage.name, of_frames(&|name| name == stage.name))).collect(),
            tail: row![
                ("traced", Cell::Number(of_frames(&|name| !BESIDE.contains(&name)), 3)),
                ("wall", median(walls.iter().copied())),
                ("bytes_triangle", bytes(stats.structure_bytes, stats.triangles.max(1) as f64)),
                ("light_bytes_pixel", bytes(stats.point_bytes, pixels)),
                ("bytes_pixel", bytes(stats.pixel_bytes, pixels)),
            ],
        })
    }
}
