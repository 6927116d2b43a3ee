use anyhow::{Result, bail};
use clap::Args;
use glam::Vec3;
use umbrage::rays::{KdTraversal, KdTree, KdTreeOptions, LightSource};
use umbrage_gpu::{Adapter, DeviceLimits, Geometry, Gpu, Recorder, StageTime};
use umbrage_papers::gpu_kdtree::{KdFrame, KdMaterial, KdNodes, KdPrimary, KdScenery, KdTracerOptions, KdTracerWork};

use super::measure::{KdFlags, frame};
use crate::grids::time;
use crate::measure::median;
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

/// Stages that find primary hits by rasterisation.
const RASTER: [&str; 2] = ["raster", "surface"];

/// A short stack of three entries, as the paper's.
const SHORT: KdTraversal = KdTraversal::ShortStack(3);

/// Table 2: each line adds an optimisation to those above it; then without packets, with a whole stack, and in wide packets.
const TABLE_2: [(KdTraversal, Option<u32>); 7] = [
    (KdTraversal::Restart, None),
    (KdTraversal::Restart, Some(4)),
    (KdTraversal::PushDown, Some(4)),
    (SHORT, Some(4)),
    (SHORT, None),
    (KdTraversal::Stack, None),
    (SHORT, Some(32)),
];

/// Table 1 and Figure 2: single rays, and packets of four.
const BOTH: [(KdTraversal, Option<u32>); 2] = [(SHORT, None), (SHORT, Some(4))];

impl KdGpuFlags {
    pub(crate) fn run(&self) -> Result<()> {
        let gpu = Gpu::open(self.device.as_deref().unwrap_or_default(), DeviceLimits::Adapter)?;
        let Adapter { name: adapter, is_software, .. } = gpu.adapter();
        if !gpu.has_timestamps() {
            bail!("{adapter} has no timestamps, so its stages can't be timed");
        }
        let mut table = self.common.start_on(adapter)?;
        let experiments = [
            ("Table 2", KdPrimary::Traced, &TABLE_2[..], 0..=0),
            ("Figure 2", KdPrimary::Traced, &BOTH[..], 1..=self.bounces),
            ("Table 1", KdPrimary::Rasterised, &BOTH[..], 0..=1),
        ];
        for address in &self.scenes {
            let trial = Trial::new(&gpu, address, self.common.size)?;
            let mut rendered = KdFrame::new(&gpu, KdTracerOptions::DEFAULT);
            for (of_paper, primary, ways, bounces) in experiments.clone() {
                for &(traversal, packet) in ways {
                    let sceneries = bounces.clone().map(|bounces| KdScenery { bounces, primary, ..trial.scenery });
                    let options = KdTracerOptions { traversal, packet, counts: false, from_triangles: false };
                    rendered.set_options(&gpu, options);
                    let timed = sceneries.clone().map(|scenery| {
                        let times = trial.render(&gpu, &mut rendered, &scenery, self.common.rounds)?;
                        Ok((times, Rays::of(&rendered, &trial.view, primary)))
                    });
                    let timed = timed.collect::<Result<Vec<_>>>()?;
                    // Counting takes time of its own.
                    rendered.set_options(&gpu, KdTracerOptions { counts: true, ..options });
                    for (scenery, (times, rays)) in sceneries.zip(timed) {
                        trial.render(&gpu, &mut rendered, &scenery, 0)?;
                        let shares = shares_in_use(&rendered);
                        table.push(row([of_paper, name(address)], &options, scenery.bounces, &times, &rays, shares))?;
                    }
                }
            }
        }
        if *is_software {
            table.note("This adapter is a program on the CPU: it says nothing of GPUs, and its clock nothing after a rasterised frame.")?;
        }
        table.finish(&[
            "Table 1 of Horn et al. 2007 is frames_s without and with a bounce, on rasterised primary hits: 10 to 18.7 with",
            "shadows, by packets of four 12.1 to 28.1; with a specular bounce 5.2 to 19.6 and 6.1 to 27.5. Here frames with a",
            "bounce have shadows as well, and every triangle mirrors a third of the light. Table 2 is primary_us and shadow_us, rays",
            "a microsecond through the tree: 7.7 to 9.1 and 9.5 to 17.1 by restart, 15.2 to 17.9 and 16.2 to 27.3 in the end,",
            "Cornell box apart. Figure 2 is how `nearest` grows with bounces.",
            "in use: the share of invocations' steps, nodes and tests, that are a ray's own; the others wait for the slowest of 32, or",
            "for their packet (section 5.2.1: the tracer of single rays has 66 to 75 % of its board's instruction rate, that of",
            "packets 35 to 42 %, and divergent branches are what keeps it from more).",
            "primary_ms: the camera's rays, or what is rasterised; nearest, blocked: through the tree, all bounces; settle: the",
            "predicate; rest: the other stages; all by the adapter's clock. frame: by the CPU's.",
        ])?;
        Ok(())
    }
}

/// Numbers of a frame's rays.
struct Rays {
    /// Traced primary rays; `None` if primary hits are rasterised.
    primary: Option<u64>,
    /// Shadow rays of all bounces.
    shadow: u64,
}

impl Rays {
    fn of(rendered: &KdFrame, view: &umbrage::rays::View, primary: KdPrimary) -> Self {
        let work = rendered.tracer().work().iter();
        Self {
            primary: (primary == KdPrimary::Traced).then_some(u64::from(view.width) * u64::from(view.height)),
            shadow: work.filter(|work| work.is_shadow).map(|work| work.visits.rays).sum(),
        }
    }
}

/// Shares of invocations' steps in use, for rays that look for hits and for shadow rays.
fn shares_in_use(rendered: &KdFrame) -> [Option<f64>; 2] {
    [false, true].map(|is_shadow| {
        let of_kind = rendered.tracer().work().iter().filter(|work| work.is_shadow == is_shadow);
        let all = of_kind.fold(KdTracerWork::default(), |mut all, work| {
            all.visits += work.visits;
            all.steps += work.steps;
            all
        });
        all.share_in_use()
    })
}

/// Times of one frame.
struct Round {
    stages: Vec<StageTime>,
    /// Milliseconds from the CPU's submission until the GPU is done.
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

    /// Renders the rounds; returns those that count.
    fn render(&self, gpu: &Gpu, rendered: &mut KdFrame, scenery: &KdScenery, rounds: u32) -> Result<Vec<Round>> {
        const MIRROR: KdMaterial = KdMaterial { color: [0.8; 3], mirror: 0.3 };
        let mut times = Vec::new();
        while times.len() <= rounds as usize {
            rendered.prepare(gpu, &self.nodes, &self.view, scenery, &[MIRROR])?;
            let mut recorder = Recorder::new(gpu);
            rendered.record(gpu, &mut recorder, &self.geometry, &self.nodes);
            let mut wall = 0.0;
            let done = time(&mut wall, || recorder.submit_and_wait())?;
            // Otherwise lists were too short, and are longer now.
            if rendered.finish(gpu, &done)? {
                times.push(Round { stages: done.times, wall });
            }
        }
        // The first round has allocated memory.
        times.remove(0);
        Ok(times)
    }
}

fn row(
    [of_paper, scene]: [&str; 2],
    options: &KdTracerOptions,
    bounces: u32,
    rounds: &[Round],
    rays: &Rays,
    shares: [Option<f64>; 2],
) -> Row {
    let sum = |is_of: &dyn Fn(&str) -> bool| {
        let of_round = |round: &Round| -> f64 {
            round.stages.iter().filter(|stage| is_of(stage.name)).map(|stage| stage.milliseconds).sum()
        };
        median(rounds.iter().map(of_round))
    };
    let is_raster = |stage: &str| RASTER.contains(&stage);
    let is_traced = rays.primary.is_some();
    let primaries = if is_traced { sum(&|stage| stage == "eye") } else { sum(&is_raster) };
    let [nearest, blocked, settle] = ["nearest", "blocked", "settle"].map(|name| sum(&|stage| stage == name));
    let all = sum(&|_| true);
    let wall = median(rounds.iter().map(|round| round.wall));
    let milliseconds = |time| Cell::Number(time, 3);
    let share = |share| Cell::Number(share, 2);
    let rate = |rays: u64, time: f64| Cell::Number(rays as f64 / (1e3 * time), 3);
    row![
        ("paper", of_paper),
        ("scene", scene),
        ("primary", if is_traced { "traced" } else { "rasterised" }),
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
        ("primary_us", rays.primary.filter(|_| bounces == 0).map(|primary| rate(primary, nearest))),
        ("shadow_us", rate(rays.shadow, blocked)),
        ("nearest_in_use", shares[0].map(share)),
        ("blocked_in_use", shares[1].map(share)),
    ]
}
