//! Any rays, in runs from the same origin: what a scanner and the hierarchy take for them, and which of them a tracer chooses.

use std::f64::consts::PI;

use anyhow::{Context, Result};
use clap::Args;
use glam::Vec3;
use umbrage::rays::{Ray, Scan, Scanned, Scanner, Sweep, Trace, Tracer, Triangles};
use umbrage::scene::Frame;

use crate::grids::time;
use crate::median::median;
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
    /// How the results are written
    #[arg(long, value_enum, default_value = "table")]
    form: Form,
}

/// A scan of so many origins takes too long to be worth a wait.
const MOST_RUNS: usize = 20_000;

/// What everyone takes, in milliseconds: the scanner and the hierarchy to build and to ask, and the tracer for all of it.
#[derive(Clone, Copy, Default)]
struct Taken {
    scanner: [f64; 2],
    hierarchy: [f64; 2],
    tracer: f64,
}

/// Who takes part, from frame to frame.
#[derive(Default)]
struct Race {
    scanner: Scanner,
    alone: Tracer,
    tracer: Tracer,
    scanned: Scanned,
    traced: Scanned,
}

pub(crate) fn run(flags: &TraceFlags) -> Result<()> {
    let threads = rayon::current_num_threads();
    let conditions = format!("any rays, threads {threads}, medians of {} frames in milliseconds", flags.rounds);
    let mut table = Table::start(flags.form, &conditions)?;
    for address in &flags.scenes {
        let scene = umbrage::open(address).with_context(|| format!("scene {address}"))?;
        let mut frame = Frame::default();
        let mut race = Race::default();
        for &count in &flags.rays {
            let runs = flags.runs.iter().filter(|&&run| run < count);
            for run in runs.map(|&run| if run == 0 { count } else { run }) {
                let mut all = Vec::new();
                let mut chosen = String::new();
                for (seconds, is_counted) in moments(&scene, flags.rounds) {
                    scene.pose(seconds, &mut frame)?;
                    let (taken, by) = race.measure(frame.triangles(), count, run);
                    if is_counted {
                        all.push(taken);
                        chosen = by;
                    }
                }
                let of = |part: fn(&Taken) -> f64| median(all.iter().map(part));
                let is_asked = count.div_ceil(run) <= MOST_RUNS;
                table.push(row![
                    ("scene", name(address)),
                    ("triangles", frame.triangles().len()),
                    ("rays", count),
                    ("of_each_origin", run),
                    ("scan_build", of(|taken| taken.scanner[0])),
                    ("scan_ask", is_asked.then(|| of(|taken| taken.scanner[1]))),
                    ("hierarchy_build", of(|taken| taken.hierarchy[0])),
                    ("hierarchy_ask", of(|taken| taken.hierarchy[1])),
                    ("tracer", of(|taken| taken.tracer)),
                    ("chosen", chosen),
                ])?;
            }
        }
    }
    Ok(table.finish(&[
        "build: for each frame anew; of_each_origin: rays that follow each other from one origin; tracer: what it takes to choose,",
        "build and ask. Hits of all three are compared.",
    ])?)
}

impl Race {
    fn measure(&mut self, triangles: Triangles<'_>, count: usize, run: usize) -> (Taken, String) {
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
        let Self { scanner, alone, tracer, scanned, traced } = self;
        time(&mut taken.scanner[0], || scanner.build(triangles));
        if sweeps.len() <= MOST_RUNS {
            time(&mut taken.scanner[1], || scanner.scan(&Scan::new(triangles, &sweeps), 1, scanned));
        }
        alone.forget();
        time(&mut taken.hierarchy[0], || _ = alone.hierarchy(triangles));
        let hits = time(&mut taken.hierarchy[1], || crate::rays::hits_of(alone.hierarchy(triangles), triangles, &rays));
        tracer.forget();
        let chosen = time(&mut taken.tracer, || tracer.trace(&Trace::new(triangles, &rays), traced));
        for (number, hit) in hits.iter().enumerate() {
            assert_eq!(traced.hits(number).next(), *hit, "ray {number} through the {chosen}");
            if sweeps.len() <= MOST_RUNS {
                assert_eq!(scanned.hits(number).next(), *hit, "ray {number} through the scan");
            }
        }
        (taken, chosen.to_string())
    }
}
