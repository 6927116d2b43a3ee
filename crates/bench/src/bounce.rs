//! Rays that share nothing: one diffuse bounce from what a camera sees.

use std::hint::black_box;
use std::sync::Arc;

use anyhow::{Context, Result};
use clap::Args;
use rayon::prelude::*;
use umbrage::rays::{Bvh, Hit, KdTree, KdTreeOptions, Ray, Structure, UniformGrid, UniformOptions};
use umbrage::scene::Frame;
use umbrage_peers::{BuildMethod, Embree, Posed, Quality, SingleRay};

use crate::flags::{SceneFlags, size};
use crate::grids::time;
use crate::median::median;
use crate::rays::{self, PACKET};
use crate::shot::{Lights, Shot, name};
use crate::table::{Form, Row, Table, row};

#[derive(Debug, Args)]
pub(crate) struct BounceFlags {
    #[command(flatten)]
    scenes: SceneFlags,
    /// Width and height in pixels; each pixel that shows something gives one ray
    #[arg(long, value_name = "WxH", default_value = "512x512", value_parser = size)]
    size: [u32; 2],
    /// How often everyone traces the rays, in turn
    #[arg(long, value_name = "N", default_value = "5", value_parser = clap::value_parser!(u32).range(1..))]
    rounds: u32,
    /// Trace the rays in packets of the uniform grid as well, 256 together: it takes minutes
    #[arg(long)]
    packets: bool,
    /// Embree's library [default: the system's]
    #[arg(long, value_name = "PATH", env = "UMBRAGE_EMBREE")]
    embree: Option<std::path::PathBuf>,
    /// How the results are written
    #[arg(long, value_enum, default_value = "table")]
    form: Form,
}

pub(crate) fn run(flags: &BounceFlags) -> Result<()> {
    let embree = Embree::load(flags.embree.as_deref(), rayon::current_num_threads())?;
    let [width, height] = flags.size;
    let conditions = format!(
        "one diffuse bounce from {width}x{height} pixels, threads {}, medians of {} rounds in milliseconds",
        rayon::current_num_threads(),
        flags.rounds
    );
    let mut table = Table::start(flags.form, &conditions)?;
    for address in flags.scenes.addresses() {
        let scene = umbrage::open(&address).with_context(|| format!("scene {address}"))?;
        let mut frame = Frame::default();
        scene.pose(0.4 * scene.duration_seconds(), &mut frame)?;
        let shot = Shot::new(&frame, &address, flags.size, 1, Lights::First);
        let camera = rays::of_camera(&shot);
        let mut tree = KdTree::default();
        tree.set_options(KdTreeOptions::FAST)?;
        tree.build(frame.triangles());
        let rays = rays::scattered(frame.triangles(), &camera, &rays::hits_of(&tree, frame.triangles(), &camera));
        let mut race = Race::new(&frame, &rays, &embree, flags.packets)?;
        (0..=flags.rounds).try_for_each(|round| race.run(round > 0))?;
        for runner in &race.runners {
            table.push(runner.row(name(&address), &race))?;
        }
    }
    table.finish(&[
        "rays_us: rays a microsecond; ratio: that over single rays of Embree with medium build quality; differ:",
        "rays whose hit is another triangle than the predicate's, or none. All triangles opaque, single precision rays.",
    ])?;
    Ok(())
}

/// Whose hits the others' are compared with.
const EXACT: &str = "bvh";

/// What the rays hit: an id, or `u32::MAX`.
type Hits = Vec<u32>;

struct Race<'a> {
    frame: &'a Frame,
    posed: Arc<Posed>,
    rays: &'a [Ray],
    runners: Vec<Runner>,
}

struct Runner {
    name: &'static str,
    tracer: Tracer,
    hits: Hits,
    /// Milliseconds to build, and to trace.
    times: Vec<[f64; 2]>,
}

/// What traces rays.
enum Tracer {
    Embree(umbrage_peers::Scene),
    /// One ray at a time.
    Single(Box<dyn Structure>),
    KdPackets(Box<KdTree>),
    GridPackets(Box<UniformGrid>),
}

impl<'a> Race<'a> {
    fn new(frame: &'a Frame, rays: &'a [Ray], embree: &Arc<Embree>, packets: bool) -> Result<Self> {
        let mut nested = Box::<UniformGrid>::default();
        nested.set_options(UniformOptions::NESTED)?;
        let scene = |quality| umbrage_peers::Scene::new(embree, BuildMethod { quality, kept: true });
        let tracers = [
            ("embree medium", Tracer::Embree(scene(Quality::Medium))),
            ("embree low", Tracer::Embree(scene(Quality::Low))),
            (EXACT, Tracer::Single(Box::<Bvh>::default())),
            ("kd-tree", Tracer::Single(Box::<KdTree>::default())),
            ("kd-tree by 16", Tracer::KdPackets(Box::default())),
            ("grid", Tracer::Single(Box::<UniformGrid>::default())),
            ("nested grids", Tracer::Single(nested)),
        ];
        let tracers = tracers.into_iter().chain(packets.then(|| ("grid packets", Tracer::GridPackets(Box::default()))));
        let runner = |(name, tracer)| Runner { name, tracer, hits: Hits::new(), times: Vec::new() };
        let runners = tracers.map(runner).collect();
        Ok(Self { frame, posed: Arc::new(Posed::new(frame, false)?), rays, runners })
    }

    fn run(&mut self, is_counted: bool) -> Result<()> {
        let Self { frame, posed, rays, runners } = self;
        for Runner { tracer, hits, times, .. } in runners {
            let mut spent = [0.0; 2];
            time(&mut spent[0], || tracer.build(frame, posed))?;
            time(&mut spent[1], || tracer.trace(frame, posed, rays, hits));
            black_box(&hits);
            if is_counted {
                times.push(spent);
            }
        }
        Ok(())
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
            Self::Embree(scene) => one_by_one(rays, hits, |ray| {
                let [origin, direction] = [ray.origin, ray.direction].map(|vector| vector.as_vec3().to_array());
                let mut ray = SingleRay::new(origin, direction);
                scene.nearest_of_one(&mut ray);
                ray.name().map_or(u32::MAX, |name| posed.triangle(name))
            }),
            Self::Single(structure) => {
                let structure = structure.single_rays().expect("a structure for any rays");
                one_by_one(rays, hits, |ray| id(structure.nearest(triangles, ray, &|_| true)));
            }
            Self::KdPackets(tree) => by_packets(rays, hits, |rays, found| {
                tree.nearest_of_packet(triangles, rays, |_| true, found);
            }),
            Self::GridPackets(grid) => by_packets(rays, hits, |rays, found| {
                umbrage_study::uniform::nearest_of_packet(grid, triangles, rays, |_| true, found);
            }),
        }
    }
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
    fn row(&self, scene: &str, race: &Race<'_>) -> Row {
        let of = |stage: usize| median(self.times.iter().map(|times| times[stage]));
        let rate = |runner: &Self| race.rays.len() as f64 / (1e3 * median(runner.times.iter().map(|times| times[1])));
        let exact = race.runners.iter().find(|runner| runner.name == EXACT);
        let differ = exact.map(|exact| exact.hits.iter().zip(&self.hits).filter(|(exact, hit)| exact != hit).count());
        row![
            ("scene", scene),
            ("triangles", race.frame.triangles().len()),
            ("rays", race.rays.len()),
            ("structure", self.name),
            ("build", of(0)),
            ("trace", of(1)),
            ("rays_us", rate(self)),
            ("ratio", rate(self) / rate(&race.runners[0])),
            ("differ", differ),
        ]
    }
}
