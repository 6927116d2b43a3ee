use anyhow::{Result, bail};
use clap::Args;
use glam::Vec3;
use umbrage::rays::{KdTraversal, KdTree, KdTreeOptions, LightSource};
use umbrage_gpu::{Adapter, DeviceLimits, Geometry, Gpu, Recorder, StageTime};
use umbrage_study::gpu_kdtree::{KdFrame, KdMaterial, KdNodes, KdPrimary, KdScenery, KdTracerOptions};

use super::measure::{KdFlags, frame};
use crate::grids::time;
use crate::median::median;
use crate::shot::{Lights, Shot, name};
use crate::table::{Cell, Row, row};

#[derive(Args, Debug)]
pub(crate) struct KdGpuFlags {
    /// Files, sequences or demo:NAME
    #[arg(default_values = ["demo:cloth", "demo:hall"])]
    scenes: Vec<String>,
    /// Bounces after the camera's rays
    #[arg(long, value_name = "N", default_value = "4", value_parser = clap::value_parser!(u32).range(0..=64))]
    bounces: u32,
    /// Part of an adapter's name [default: the first]
    #[arg(long, value_name = "NAME")]
    device: Option<String>,
    #[command(flatten)]
    common: KdFlags,
}

/// What finds primary hits by rasterisation.
const RASTER: [&str; 2] = ["raster", "surface"];

/// As the paper's Table 2 improves one after the other, and a whole stack.
const WAYS: [(KdTraversal, Option<u32>); 6] = [
    (KdTraversal::Restart, None),
    (KdTraversal::PushDown, None),
    (KdTraversal::ShortStack(4), None),
    (KdTraversal::Stack, None),
    (KdTraversal::ShortStack(4), Some(4)),
    (KdTraversal::ShortStack(4), Some(32)),
];

impl KdGpuFlags {
    pub(crate) fn run(&self) -> Result<()> {
        let gpu = Gpu::open(self.device.as_deref().unwrap_or_default(), DeviceLimits::Adapter)?;
        let Adapter { name: adapter, is_software, .. } = gpu.adapter();
        if !gpu.has_timestamps() {
            bail!("{adapter} has no timestamps, so its stages can't be timed");
        }
        let mut table = self.common.start_on(adapter)?;
        for address in &self.scenes {
            let trial = Trial::new(&gpu, address, self.common.size)?;
            for (traversal, packet) in WAYS {
                let options = KdTracerOptions { traversal, packet, counts: false };
                let mut rendered = KdFrame::new(&gpu, options);
                for primary in [KdPrimary::Traced, KdPrimary::Rasterised] {
                    for bounces in 0..=self.bounces {
                        let scenery = KdScenery { bounces, primary, ..trial.scenery };
                        let times = trial.render(&gpu, &mut rendered, &scenery, self.common.rounds)?;
                        let what = [name(address), if primary == KdPrimary::Traced { "traced" } else { "rasterised" }];
                        let pixels = f64::from(trial.view.width) * f64::from(trial.view.height);
                        table.push(row(what, &options, bounces, &times, pixels))?;
                    }
                }
            }
        }
        if *is_software {
            table.note("This adapter is a program on the CPU: it says nothing of GPUs, and its clock nothing after a rasterised frame.")?;
        }
        table.finish(&[
            "Every triangle mirrors a third of the light; one light with shadows. primary_ms: the camera's rays, or what is",
            "rasterised; nearest, blocked: through the tree, all bounces; settle: the predicate; rest: the other stages; all by",
            "the adapter's clock. frame: by the CPU's. primary_us: camera rays a microsecond through the tree, without bounces.",
            "Horn et al. 2007, Table 1: 12 to 28 frames a second with shadows; Table 2: 15 primary rays a microsecond.",
        ])?;
        Ok(())
    }
}

/// What one frame took.
struct Round {
    stages: Vec<StageTime>,
    /// From the CPU's submission until all is done, in milliseconds.
    wall: f64,
}

/// A scene on the device.
struct Trial {
    view: umbrage::rays::View,
    geometry: Geometry,
    nodes: KdNodes,
    scenery: KdScenery,
}

impl Trial {
    fn new(gpu: &Gpu, address: &str, size: [u32; 2]) -> Result<Self> {
        let frame = frame(address)?;
        let shot = Shot::new(&frame, address, size, 1, Lights::First);
        let mut tree = KdTree::default();
        tree.set_options(KdTreeOptions::FAST)?;
        tree.build(frame.triangles());
        let (mut geometry, mut nodes) = (Geometry::new(gpu), KdNodes::new(gpu));
        geometry.write(gpu, frame.triangles(), |_| 0)?;
        nodes.write(gpu, &tree)?;
        let light = shot.lights.first().copied().unwrap_or(LightSource::Directional { direction: Vec3::NEG_Y });
        let scenery = KdScenery {
            light,
            light_color: Vec3::ONE,
            ambient: Vec3::splat(0.1),
            sky: Vec3::splat(0.3),
            bounces: 0,
            primary: KdPrimary::Traced,
        };
        Ok(Self { view: shot.view, geometry, nodes, scenery })
    }

    /// The counted rounds.
    fn render(&self, gpu: &Gpu, rendered: &mut KdFrame, scenery: &KdScenery, rounds: u32) -> Result<Vec<Round>> {
        const MIRROR: KdMaterial = KdMaterial { color: [0.8; 3], mirror: 0.3 };
        let mut times = Vec::new();
        while times.len() <= rounds as usize {
            rendered.prepare(gpu, &self.nodes, &self.view, scenery, &[MIRROR])?;
            let mut recorder = Recorder::new(gpu);
            rendered.record(gpu, &mut recorder, &self.geometry, &self.nodes);
            let mut wall = 0.0;
            let stages = time(&mut wall, || recorder.submit()())?;
            // Else lists were too short, which are longer now.
            if rendered.finish(gpu)? {
                times.push(Round { stages, wall });
            }
        }
        // The first has taken memory.
        times.remove(0);
        Ok(times)
    }
}

fn row([scene, primary]: [&str; 2], options: &KdTracerOptions, bounces: u32, rounds: &[Round], pixels: f64) -> Row {
    let sum = |is_of: &dyn Fn(&str) -> bool| {
        let of_round = |round: &Round| -> f64 {
            round.stages.iter().filter(|stage| is_of(stage.name)).map(|stage| stage.milliseconds).sum()
        };
        median(rounds.iter().map(of_round))
    };
    let is_raster = |stage: &str| RASTER.contains(&stage);
    let traced = primary == "traced";
    let primaries = if traced { sum(&|stage| stage == "eye") } else { sum(&is_raster) };
    let [nearest, blocked, settle] = ["nearest", "blocked", "settle"].map(|name| sum(&|stage| stage == name));
    let all = sum(&|_| true);
    let wall = median(rounds.iter().map(|round| round.wall));
    let milliseconds = |time| Cell::Number(time, 3);
    row![
        ("scene", scene),
        ("primary", primary),
        ("traversal", options.traversal.to_string()),
        ("packet", options.packet),
        ("bounces", bounces),
        ("primary_ms", milliseconds(primaries)),
        ("nearest", milliseconds(nearest)),
        ("blocked", milliseconds(blocked)),
        ("settle", milliseconds(settle)),
        ("rest", milliseconds(all - primaries - nearest - blocked - settle)),
        ("frame", milliseconds(wall)),
        ("frames_s", Cell::Number(1e3 / wall, 1)),
        ("primary_us", (traced && bounces == 0).then(|| Cell::Number(pixels / (1e3 * nearest), 3))),
    ]
}
