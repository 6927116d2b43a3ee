//! Incoherent rays: diffuse bounces from a camera's hits.

use std::hint::black_box;
use std::sync::Arc;

use anyhow::{Context, Result};
use clap::{Args, ValueEnum};
use rayon::prelude::*;
use umbrage::rays::{Bvh, Hit, KdTree, Ray, SingleRays as _, Structure, UniformGrid, UniformOptions};
use umbrage::scene::Frame;
use umbrage_peers::{BuildMethod, Embree, Posed, Quality, SingleRay};

use crate::flags::{SceneFlags, size};
use crate::grids::time;
use crate::measure::{geometric_mean, median};
use crate::rays::{self, PACKET};
use crate::shot::{Lights, Shot, moments, name};
use crate::table::{Form, Row, Table, row};

#[derive(Debug, Args)]
pub(crate) struct BounceFlags {
    #[command(flatten)]
    scenes: SceneFlags,
    /// Width and height in pixels; each pixel that shows something gives one ray
    #[arg(long, value_name = "WxH", default_value = "512x512", value_parser = size)]
    size: [u32; 2],
    /// Frames of each scene's animation in which everyone builds and traces, in turn; one more comes first and doesn't count
    #[arg(long, value_name = "N", default_value = "5", value_parser = clap::value_parser!(u32).range(1..))]
    rounds: u32,
    /// Bounces, each from what the rays of the last one hit
    #[arg(long, value_name = "N", default_value = "1", value_parser = clap::value_parser!(u32).range(1..=16))]
    bounces: u32,
    /// Who takes part besides the hierarchy and Embree [default: all but packets of the uniform grid]
    #[arg(long, value_enum, value_name = "NAME", value_delimiter = ',')]
    with: Option<Vec<Other>>,
    /// Embree's library [default: the system's]
    #[arg(long, value_name = "PATH", env = "UMBRAGE_EMBREE")]
    embree: Option<std::path::PathBuf>,
    /// How the results are written
    #[arg(long, value_enum, default_value = "table")]
    form: Form,
}

/// Structures that may take part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Other {
    /// None of them
    None,
    /// The kd-tree, one ray at a time
    KdTree,
    /// The kd-tree, by packets of 16
    KdPackets,
    /// The uniform grid
    Grid,
    /// Uniform grids with grids in cells
    NestedGrids,
    /// The uniform grid, 256 rays together: it takes minutes
    GridPackets,
}

pub(crate) fn run(flags: &BounceFlags) -> Result<()> {
    let embree = Embree::load(flags.embree.as_deref(), rayon::current_num_threads())?;
    let [width, height] = flags.size;
    let conditions = format!(
        "diffuse bounces from {width}x{height} pixels, threads {}, medians of {} frames in milliseconds",
        rayon::current_num_threads(),
        flags.rounds
    );
    let mut table = Table::start(flags.form, &conditions)?;
    let mut wholes = Vec::new();
    for address in flags.scenes.addresses() {
        let scene = umbrage::open(&address).with_context(|| format!("scene {address}"))?;
        let mut race = Race::new(&embree, flags)?;
        let mut frame = Frame::default();
        for (seconds, is_counted) in moments(&scene, flags.rounds) {
            scene.pose(seconds, &mut frame)?;
            let shot = Shot::new(&frame, &address, flags.size, 1, Lights::First);
            race.run(&shot, is_counted)?;
        }
        for bounce in 0..flags.bounces as usize {
            for runner in &race.runners {
                table.push(race.row(runner, bounce, name(&address), frame.triangles().len()))?;
            }
            wholes.push(race.exact().whole(bounce) / race.fastest_embree(bounce));
        }
    }
    let mean = format!("Geometric mean of the hierarchy's whole_ratio: {:.2}.", geometric_mean(wholes));
    table.finish(&[
        "build: for each frame anew; rays_us: rays a microsecond; ratio: that over single rays of Embree with medium build",
        "quality; whole_us: the same with the build in the time; whole_ratio: that over the faster of Embree's two; differ:",
        "rays whose hit is another triangle than the predicate's, or none. All triangles opaque, single precision rays.",
        &mean,
    ])?;
    Ok(())
}

/// The side whose hits the others' are compared with; rays of the next bounce start at its hits.
const EXACT: &str = "bvh";

/// Ids of hit triangles, `u32::MAX` for none.
type Hits = Vec<u32>;

struct Race {
    bounces: usize,
    /// Embree's two come first.
    runners: Vec<Runner>,
}

struct Runner {
    name: &'static str,
    tracer: Tracer,
    hits: Hits,
    /// Times of each bounce in each frame.
    taken: Vec<Vec<Taken>>,
}

/// Times of a bounce, in milliseconds.
#[derive(Clone, Copy)]
struct Taken {
    rays: usize,
    build: f64,
    trace: f64,
    /// Rays whose hit differs from the predicate's.
    differ: usize,
}

/// A tracer of rays.
enum Tracer {
    Embree(umbrage_peers::Scene),
    /// One ray at a time.
    Single(Box<dyn Structure>),
    KdPackets(Box<KdTree>),
    GridPackets(Box<UniformGrid>),
}

impl Race {
    fn new(embree: &Arc<Embree>, flags: &BounceFlags) -> Result<Self> {
        let scene = |quality| Tracer::Embree(umbrage_peers::Scene::new(embree, BuildMethod { quality, kept: true }));
        let mut tracers = vec![
            ("embree medium", scene(Quality::Medium)),
            ("embree low", scene(Quality::Low)),
            (EXACT, Tracer::Single(Box::<Bvh>::default())),
        ];
        let usual = [Other::KdTree, Other::KdPackets, Other::Grid, Other::NestedGrids];
        for other in flags.with.as_deref().unwrap_or(&usual) {
            tracers.push(match other {
                Other::None => continue,
                Other::KdTree => ("kd-tree", Tracer::Single(Box::<KdTree>::default())),
                Other::KdPackets => ("kd-tree by 16", Tracer::KdPackets(Box::default())),
                Other::Grid => ("grid", Tracer::Single(Box::<UniformGrid>::default())),
                Other::NestedGrids => {
                    let mut nested = Box::<UniformGrid>::default();
                    nested.set_options(UniformOptions::NESTED)?;
                    ("nested grids", Tracer::Single(nested))
                }
                Other::GridPackets => ("grid packets", Tracer::GridPackets(Box::default())),
            });
        }
        let bounces = flags.bounces as usize;
        let taken = vec![Vec::new(); bounces];
        let runner = |(name, tracer)| Runner { name, tracer, hits: Hits::new(), taken: taken.clone() };
        Ok(Self { bounces, runners: tracers.into_iter().map(runner).collect() })
    }

    /// Builds and traces a frame.
    fn run(&mut self, shot: &Shot<'_>, is_counted: bool) -> Result<()> {
        let Self { bounces, runners } = self;
        let (frame, triangles) = (shot.frame, shot.frame.triangles());
        let posed = Arc::new(Posed::new(frame, false)?);
        let mut builds = vec![0.0; runners.len()];
        for (Runner { tracer, .. }, build) in runners.iter_mut().zip(&mut builds) {
            time(build, || tracer.build(frame, &posed))?;
        }
        let mut structure = Bvh::default();
        structure.build(triangles);
        let mut rays = rays::of_camera(shot);
        for bounce in 0..*bounces {
            rays = rays::scattered(triangles, &rays, &rays::hits_of(&structure, triangles, &rays));
            let mut traces = vec![0.0; runners.len()];
            for (Runner { tracer, hits, .. }, trace) in runners.iter_mut().zip(&mut traces) {
                time(trace, || tracer.trace(frame, &posed, &rays, hits));
                black_box(&hits);
            }
            let exact: Hits = rays.par_iter().map(|ray| id(structure.nearest(triangles, ray, &|_| true))).collect();
            for (Runner { hits, taken, .. }, (&build, trace)) in runners.iter_mut().zip(builds.iter().zip(traces)) {
                let differ = exact.iter().zip(&*hits).filter(|(exact, hit)| exact != hit).count();
                if is_counted {
                    taken[bounce].push(Taken { rays: rays.len(), build, trace, differ });
                }
            }
        }
        Ok(())
    }

    fn exact(&self) -> &Runner {
        &self.runners[2]
    }

    /// Rays a microsecond of the faster of Embree's two, including the build.
    fn fastest_embree(&self, bounce: usize) -> f64 {
        self.runners[0].whole(bounce).max(self.runners[1].whole(bounce))
    }

    fn row(&self, runner: &Runner, bounce: usize, scene: &str, triangles: usize) -> Row {
        let of = |get: fn(&Taken) -> f64| runner.median(bounce, get);
        row![
            ("scene", scene),
            ("triangles", triangles),
            ("bounce", bounce + 1),
            ("rays", of(|taken| taken.rays as f64) as usize),
            ("structure", runner.name),
            ("build", of(|taken| taken.build)),
            ("trace", of(|taken| taken.trace)),
            ("rays_us", runner.rate(bounce)),
            ("ratio", runner.rate(bounce) / self.runners[0].rate(bounce)),
            ("whole_us", runner.whole(bounce)),
            ("whole_ratio", runner.whole(bounce) / self.fastest_embree(bounce)),
            ("differ", runner.taken[bounce].iter().map(|taken| taken.differ).sum::<usize>()),
        ]
    }
}

impl Tracer {
    fn build(&mut self, frame: &Frame, posed: &Arc<Posed>) -> Result<()> {
        let triangles = frame.triangles();
        match self {
            Self::Embree(scene) => scene.build(posed)?,
            Self::Single(structure) => structure.build(triangles),
            Self::KdPackets(tree) => tree.build(triangles),
            Self::GridPackets(grid) => grid.build(triangles),
        }
        Ok(())
    }

    fn trace(&self, frame: &Frame, posed: &Posed, rays: &[Ray], hits: &mut Hits) {
        let triangles = frame.triangles();
        match self {
            Self::Embree(scene) => trace_by_embree(scene, posed, rays, hits),
            Self::Single(structure) => {
                let structure = structure.single_rays().expect("a structure for any rays");
                one_by_one(rays, hits, |ray| id(structure.nearest(triangles, ray, &|_| true)));
            }
            Self::KdPackets(tree) => by_packets(rays, hits, |rays, found| {
                tree.nearest_of_packet(triangles, rays, |_| true, found);
            }),
            Self::GridPackets(grid) => by_packets(rays, hits, |rays, found| {
                umbrage_papers::uniform::nearest_of_packet(grid, triangles, rays, |_| true, found);
            }),
        }
    }
}

/// Finds the triangles that rays hit, `u32::MAX` for none.
pub(crate) fn trace_by_embree(scene: &umbrage_peers::Scene, posed: &Posed, rays: &[Ray], hits: &mut Vec<u32>) {
    one_by_one(rays, hits, |ray| {
        let [origin, direction] = [ray.origin, ray.direction].map(|vector| vector.as_vec3().to_array());
        let mut ray = SingleRay::new(origin, direction);
        scene.nearest_of_one(&mut ray);
        ray.name().map_or(u32::MAX, |name| posed.triangle(name))
    });
}

fn id(hit: Option<Hit>) -> u32 {
    hit.map_or(u32::MAX, |hit| hit.triangle)
}

fn one_by_one(rays: &[Ray], hits: &mut Hits, nearest: impl Fn(&Ray) -> u32 + Sync + Send) {
    rays.par_iter().with_min_len(PACKET).map(nearest).collect_into_vec(hits);
}

fn by_packets(rays: &[Ray], hits: &mut Hits, nearest: impl Fn(&[Ray], &mut [Option<Hit>]) + Sync) {
    hits.resize(rays.len(), u32::MAX);
    rays.par_chunks(PACKET).zip(hits.par_chunks_mut(PACKET)).for_each(|(rays, hits)| {
        let mut found = [None; PACKET];
        nearest(rays, &mut found[..rays.len()]);
        hits.iter_mut().zip(found).for_each(|(hit, found)| *hit = id(found));
    });
}

impl Runner {
    fn median(&self, bounce: usize, get: impl Fn(&Taken) -> f64) -> f64 {
        median(self.taken[bounce].iter().map(get))
    }

    /// Rays a microsecond.
    fn rate(&self, bounce: usize) -> f64 {
        self.median(bounce, |taken| taken.rays as f64 / (1e3 * taken.trace))
    }

    /// Rays a microsecond, including the build.
    fn whole(&self, bounce: usize) -> f64 {
        self.median(bounce, |taken| taken.rays as f64 / (1e3 * (taken.build + taken.trace)))
    }
}
