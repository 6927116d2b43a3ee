//! Rays that share nothing: one diffuse bounce from what a camera sees.

use std::hint::black_box;
use std::sync::Arc;

use anyhow::{Context, Result};
use clap::Args;
use rayon::prelude::*;
use umbrage::rays::{Bvh, Hit, KdTree, KdTreeOptions, Ray, SingleRays as _, UniformGrid, UniformOptions};
use umbrage::scene::Frame;
use umbrage_peers::{BuildMethod, Embree, Posed, Quality, SingleRay};

use crate::flags::size;
use crate::grids::time;
use crate::median::median;
use crate::rays::{self, PACKET};
use crate::shot::{self, Lights, Shot, name};
use crate::table::{Cell, Form, Table};

#[derive(Debug, Args)]
pub(crate) struct BounceFlags {
    /// Files, sequences or demo:NAME [default: the gallery, and the real scenes of --files]
    scenes: Vec<String>,
    /// Folder of the real scenes
    #[arg(long, value_name = "DIR")]
    files: Option<std::path::PathBuf>,
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

const COLUMNS: &[(&str, usize)] = &[
    ("scene", 26),
    ("triangles", 9),
    ("rays", 8),
    ("structure", 13),
    ("build", 8),
    ("trace", 9),
    ("rays_us", 8),
    ("ratio", 6),
    ("differ", 6),
];

pub(crate) fn run(flags: &BounceFlags) -> Result<()> {
    let embree = Embree::load(flags.embree.as_deref(), rayon::current_num_threads())?;
    let [width, height] = flags.size;
    let conditions = format!(
        "one diffuse bounce from {width}x{height} pixels, threads {}, medians of {} rounds in milliseconds",
        rayon::current_num_threads(),
        flags.rounds
    );
    let mut table = Table::start(flags.form, &conditions, COLUMNS)?;
    for address in shot::addresses(&flags.scenes, flags.files.as_ref()) {
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
            table.push(&runner.row(name(&address), &race))?;
        }
    }
    table.notes(&[
            "rays_us: rays a microsecond; ratio: that over single rays of Embree with medium build quality; differ:",
            "rays whose hit is another triangle than the predicate's, or none. All triangles opaque, single precision rays.",
        ])?;
    Ok(table.finish()?)
}

/// What the rays hit: an id, or `u32::MAX`.
type Hits = Vec<u32>;

struct Race<'a> {
    frame: &'a Frame,
    posed: Arc<Posed>,
    rays: &'a [Ray],
    runners: Vec<Runner>,
}

struct Runner {
    structure: Structure,
    hits: Hits,
    /// Milliseconds to build, and to trace.
    times: Vec<[f64; 2]>,
}

enum Structure {
    Embree(umbrage_peers::Scene, &'static str),
    Bvh(Box<Bvh>),
    Kd(Box<KdTree>),
    KdPackets(Box<KdTree>, &'static str),
    Grid(Box<UniformGrid>, &'static str),
    GridPackets(Box<UniformGrid>),
}

impl<'a> Race<'a> {
    fn new(frame: &'a Frame, rays: &'a [Ray], embree: &Arc<Embree>, packets: bool) -> Result<Self> {
        let mut nested = Box::<UniformGrid>::default();
        nested.set_options(UniformOptions::NESTED)?;
        let scene = |quality| umbrage_peers::Scene::new(embree, BuildMethod { quality, kept: true });
        let structures = [
            Structure::Embree(scene(Quality::Medium), "embree medium"),
            Structure::Embree(scene(Quality::Low), "embree low"),
            Structure::Bvh(Box::default()),
            Structure::Kd(Box::default()),
            Structure::KdPackets(Box::default(), "kd-tree by 16"),
            Structure::Grid(Box::default(), "grid"),
            Structure::Grid(nested, "nested grids"),
        ];
        let structures = structures.into_iter().chain(packets.then(|| Structure::GridPackets(Box::default())));
        let runners = structures.map(|structure| Runner { structure, hits: Hits::new(), times: Vec::new() }).collect();
        Ok(Self { frame, posed: Arc::new(Posed::new(frame, false)?), rays, runners })
    }

    fn run(&mut self, is_counted: bool) -> Result<()> {
        let Self { frame, posed, rays, runners } = self;
        for Runner { structure, hits, times } in runners {
            let mut spent = [0.0; 2];
            time(&mut spent[0], || structure.build(frame, posed))?;
            time(&mut spent[1], || structure.trace(frame, posed, rays, hits));
            black_box(&hits);
            if is_counted {
                times.push(spent);
            }
        }
        Ok(())
    }
}

impl Structure {
    fn name(&self) -> &'static str {
        match self {
            Self::Bvh(_) => "bvh",
            Self::Kd(_) => "kd-tree",
            Self::Embree(_, name) | Self::KdPackets(_, name) | Self::Grid(_, name) => name,
            Self::GridPackets(_) => "grid packets",
        }
    }

    fn build(&mut self, frame: &Frame, posed: &Arc<Posed>) -> Result<()> {
        let triangles = frame.triangles();
        match self {
            Self::Embree(scene, _) => scene.build(posed)?,
            Self::Bvh(bvh) => bvh.build(triangles),
            Self::Kd(tree) | Self::KdPackets(tree, _) => tree.build(triangles),
            Self::Grid(grid, _) | Self::GridPackets(grid) => grid.build(triangles),
        }
        Ok(())
    }

    fn trace(&self, frame: &Frame, posed: &Posed, rays: &[Ray], hits: &mut Hits) {
        let triangles = frame.triangles();
        let id = |hit: Option<Hit>| hit.map_or(u32::MAX, |hit| hit.triangle);
        match self {
            Self::Embree(scene, _) => {
                let trace = |ray: &Ray| {
                    let [origin, direction] = [ray.origin, ray.direction].map(|vector| vector.as_vec3().to_array());
                    let mut ray = SingleRay::new(origin, direction);
                    scene.nearest_of_one(&mut ray);
                    ray.name().map_or(u32::MAX, |name| posed.triangle(name))
                };
                rays.par_iter().with_min_len(PACKET).map(trace).collect_into_vec(hits);
            }
            Self::Bvh(bvh) => {
                let trace = |ray| id(bvh.nearest(triangles, ray, &|_| true));
                rays.par_iter().with_min_len(PACKET).map(trace).collect_into_vec(hits);
            }
            Self::Kd(tree) => {
                let trace = |ray| id(tree.nearest(triangles, ray, &|_| true));
                rays.par_iter().with_min_len(PACKET).map(trace).collect_into_vec(hits);
            }
            Self::KdPackets(tree, _) => {
                hits.resize(rays.len(), u32::MAX);
                rays.par_chunks(PACKET).zip(hits.par_chunks_mut(PACKET)).for_each(|(rays, hits)| {
                    let mut found = [None; PACKET];
                    tree.nearest_of_packet(triangles, rays, |_| true, &mut found[..rays.len()]);
                    hits.iter_mut().zip(found).for_each(|(hit, found)| *hit = id(found));
                });
            }
            Self::Grid(grid, _) => {
                let trace = |ray| id(grid.nearest(triangles, ray, &|_| true));
                rays.par_iter().with_min_len(PACKET).map(trace).collect_into_vec(hits);
            }
            Self::GridPackets(grid) => {
                hits.resize(rays.len(), u32::MAX);
                rays.par_chunks(PACKET).zip(hits.par_chunks_mut(PACKET)).for_each(|(rays, hits)| {
                    let mut found = [None; PACKET];
                    umbrage_study::uniform::nearest_of_packet(
                        grid,
                        triangles,
                        rays,
                        |_| true,
                        &mut found[..rays.len()],
                    );
                    hits.iter_mut().zip(found).for_each(|(hit, found)| *hit = id(found));
                });
            }
        }
    }
}

impl Runner {
    fn row(&self, scene: &str, race: &Race<'_>) -> Vec<Cell> {
        let of = |stage: usize| median(self.times.iter().map(|times| times[stage]));
        let rate = |runner: &Self| race.rays.len() as f64 / (1e3 * median(runner.times.iter().map(|times| times[1])));
        let exact = race.runners.iter().find(|runner| matches!(runner.structure, Structure::Bvh(_)));
        let differ = exact.map(|exact| exact.hits.iter().zip(&self.hits).filter(|(exact, hit)| exact != hit).count());
        vec![
            scene.into(),
            race.frame.triangles().len().into(),
            race.rays.len().into(),
            self.structure.name().into(),
            Cell::Number(of(0), 2),
            Cell::Number(of(1), 2),
            Cell::Number(rate(self), 2),
            Cell::Number(rate(self) / rate(&race.runners[0]), 2),
            differ.map_or(Cell::Nothing, Cell::from),
        ]
    }
}
