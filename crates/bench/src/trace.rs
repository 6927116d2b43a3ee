//! Any rays, in runs from the same origin: times of a scanner, of the hierarchy and of Embree, and the tracer's choice.

use std::f64::consts::PI;
use std::path::PathBuf;
use std::sync::Arc;

use anyhow::{Context, Result};
use clap::Args;
use glam::Vec3;
use umbrage::rays::{Ray, Scan, Scanned, Scanner, Sweep, Trace, Tracer, Wanted};
use umbrage::scene::Frame;
use umbrage_peers::{BuildMethod, Embree, Posed, Quality};

use crate::bounce::trace_by_embree;
use crate::grids::time;
use crate::measure::median;
use crate::rays::on_sphere;
use crate::shot::{moments, name};
use crate::table::{Form, Table, row};

#[derive(Debug, Args)]
pub(crate) struct TraceFlags {
    /// Files, sequences or demo:NAME
    #[arg(default_values = ["demo:cloth?triangles=10000", "demo:cloth?triangles=1000000"])]
    scenes: Vec<String>,
    /// How many rays
    #[arg(long, value_name = "N,N", value_delimiter = ',', default_value = "100,1000,10000,100000,1000000")]
    rays: Vec<usize>,
    /// How many rays follow each other from the same origin; 0 for all of them
    #[arg(long, value_name = "N,N", value_delimiter = ',', default_value = "1,16,256,4096,0")]
    runs: Vec<usize>,
    /// Frames of each scene's animation in which everyone builds and traces, in turn; one more comes first and doesn't count
    #[arg(long, value_name = "N", default_value = "3", value_parser = clap::value_parser!(u32).range(1..))]
    rounds: u32,
    /// Ask the tracer for the triangles' ids alone
    #[arg(long)]
    ids: bool,
    /// Embree's library [default: the system's]
    #[arg(long, value_name = "PATH", env = "UMBRAGE_EMBREE")]
    embree: Option<PathBuf>,
    /// How the results are written
    #[arg(long, value_enum, default_value = "table")]
    form: Form,
}

impl TraceFlags {
    fn wanted(&self) -> Wanted {
        if self.ids { Wanted::IDS } else { Wanted::ALL }
    }
}

/// Whether a scan would take too long: each of many origins visits nearly all triangles, unless there are few rays.
fn takes_too_long(origins: usize, rays: usize, triangles: usize) -> bool {
    origins * triangles > 100_000_000 && rays > 1000
}

/// Times of all sides, in milliseconds: to build and to trace; for the tracer, the sum.
#[derive(Clone, Copy, Default)]
struct Taken {
    scanner: [f64; 2],
    hierarchy: [f64; 2],
    tracer: f64,
    /// With a build of low and of medium quality.
    embree: [[f64; 2]; 2],
    /// Rays whose hit differs in either.
    differ: usize,
}

/// State of all sides, from frame to frame.
struct Race {
    scanner: Scanner,
    alone: Tracer,
    tracer: Tracer,
    embree: [umbrage_peers::Scene; 2],
    scanned: Scanned,
    traced: Scanned,
}

pub(crate) fn run(flags: &TraceFlags) -> Result<()> {
    let threads = rayon::current_num_threads();
    let conditions = format!("any rays, threads {threads}, medians of {} frames in milliseconds", flags.rounds);
    let embree = Embree::load(flags.embree.as_deref(), threads)?;
    let mut table = Table::start(flags.form, &conditions)?;
    for address in &flags.scenes {
        let scene = umbrage::open(address).with_context(|| format!("scene {address}"))?;
        let mut frame = Frame::default();
        let mut race = Race::new(&embree);
        for &count in &flags.rays {
            let runs = flags.runs.iter().filter(|&&run| run < count);
            for run in runs.map(|&run| if run == 0 { count } else { run }) {
                let mut all = Vec::new();
                let mut chosen = String::new();
                for (seconds, is_counted) in moments(&scene, flags.rounds) {
                    scene.pose(seconds, &mut frame)?;
                    let (taken, by) = race.measure(&frame, flags.wanted(), count, run)?;
                    if is_counted {
                        all.push(taken);
                        chosen = by;
                    }
                }
                let of = |part: &dyn Fn(&Taken) -> f64| median(all.iter().map(part));
                let embree = [0, 1].map(|side| of(&|taken| taken.embree[side].iter().sum()));
                let best = usize::from(embree[1] < embree[0]);
                let tracer = of(&|taken| taken.tracer);
                let is_asked = !takes_too_long(count.div_ceil(run), count, frame.triangles().len());
                table.push(row![
                    ("scene", name(address)),
                    ("triangles", frame.triangles().len()),
                    ("rays", count),
                    ("of_each_origin", run),
                    ("scan_build", of(&|taken| taken.scanner[0])),
                    ("scan_ask", is_asked.then(|| of(&|taken| taken.scanner[1]))),
                    ("hierarchy_build", of(&|taken| taken.hierarchy[0])),
                    ("hierarchy_ask", of(&|taken| taken.hierarchy[1])),
                    ("tracer", tracer),
                    ("chosen", chosen),
                    ("embree_build", of(&|taken| taken.embree[best][0])),
                    ("embree_ask", of(&|taken| taken.embree[best][1])),
                    ("ratio", embree[best] / tracer),
                    ("differ", all.iter().map(|taken| taken.differ).sum::<usize>()),
                ])?;
            }
        }
    }
    Ok(table.finish(&[
        "build: for each frame anew; of_each_origin: rays that follow each other from one origin; tracer: what it takes to choose,",
        "build and ask. Hits of all three are compared. embree: one ray at a time, by the faster of a low and a medium build;",
        "ratio: how many times as long as the tracer it takes in all; differ: hits of all frames in which either build's are others.",
    ])?)
}

impl Race {
    fn new(embree: &Arc<Embree>) -> Self {
        let scene = |quality| umbrage_peers::Scene::new(embree, BuildMethod { quality, kept: true });
        Self {
            scanner: Scanner::default(),
            alone: Tracer::default(),
            tracer: Tracer::default(),
            embree: [Quality::Low, Quality::Medium].map(scene),
            scanned: Scanned::default(),
            traced: Scanned::default(),
        }
    }

    fn measure(&mut self, frame: &Frame, wanted: Wanted, count: usize, run: usize) -> Result<(Taken, String)> {
        let triangles = frame.triangles();
        let bounds = triangles.bounds();
        let mut taken = Taken::default();
        let direction = |number: usize| on_sphere(number as u64).as_vec3();
        let directions: Vec<Vec3> = (0..count).map(direction).collect();
        // In the scene's bounds.
        let origin = |number: usize| {
            let within = (direction(number) * (number as f64 * PI).fract() as f32).midpoint(Vec3::ONE);
            (bounds.min + bounds.size() * within).as_dvec3()
        };
        let rays: Vec<Ray> = directions
            .iter()
            .enumerate()
            .map(|(number, direction)| Ray::new(origin(number / run), direction.as_dvec3()))
            .collect();
        let sweeps: Vec<Sweep<'_>> = directions
            .chunks(run)
            .enumerate()
            .map(|(number, directions)| Sweep { origin: origin(number), directions })
            .collect();
        let is_asked = !takes_too_long(sweeps.len(), count, triangles.len());
        let Self { scanner, alone, tracer, embree, scanned, traced } = self;
        time(&mut taken.scanner[0], || scanner.build(triangles));
        if is_asked {
            time(&mut taken.scanner[1], || scanner.scan(&Scan::new(triangles, &sweeps), 1, scanned));
        }
        alone.forget();
        time(&mut taken.hierarchy[0], || _ = alone.hierarchy(triangles));
        let hits = time(&mut taken.hierarchy[1], || crate::rays::hits_of(alone.hierarchy(triangles), triangles, &rays));
        tracer.forget();
        let trace = Trace { wanted, ..Trace::new(triangles, &rays) };
        let chosen = time(&mut taken.tracer, || tracer.trace(&trace, traced));
        for (number, hit) in hits.iter().enumerate() {
            let id = hit.map_or(Scanned::NONE, |hit| hit.triangle);
            assert_eq!(traced.triangle[number], id, "ray {number} through the {chosen}");
            if wanted == Wanted::ALL {
                assert_eq!(traced.hits(number).next(), *hit, "ray {number} through the {chosen}");
            }
            if is_asked {
                assert_eq!(scanned.hits(number).next(), *hit, "ray {number} through the scan");
            }
        }
        let posed = Arc::new(Posed::new(frame, false)?);
        let (mut theirs, ours) = (Vec::new(), &traced.triangle);
        for (scene, [build, ask]) in embree.iter_mut().zip(&mut taken.embree) {
            time(build, || scene.build(&posed))?;
            time(ask, || trace_by_embree(scene, &posed, &rays, &mut theirs));
            taken.differ += theirs.iter().zip(ours).filter(|(theirs, ours)| theirs != ours).count();
        }
        Ok((taken, chosen.to_string()))
    }
}
