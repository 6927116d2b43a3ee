//! Closest points of meshes that move, beside Embree's point queries.

use std::path::PathBuf;
use std::sync::Arc;

use anyhow::{Context, Result};
use clap::Args;
use glam::Vec3;
use rayon::prelude::*;
use umbrage::rays::{Closest, ClosestPoints, Nearest, Triangles};
use umbrage::scene::Frame;
use umbrage_peers::{BuildMethod, Embree, Posed, Quality, Scene};
use umbrage_verify::Random;

use crate::grids::time;
use crate::measure::median;
use crate::shot::{moments, name};
use crate::table::{Form, Table, row};

#[derive(Debug, Args)]
pub(crate) struct NearestFlags {
    /// Files, sequences or demo:NAME
    #[arg(default_values = ["demo:cloth?triangles=80000", "demo:statue?triangles=1000000"])]
    scenes: Vec<String>,
    /// How many points
    #[arg(long, value_name = "N", default_value = "100000")]
    points: usize,
    /// How far points near the surface may be from a triangle on each axis, in sizes of the scene
    #[arg(long, value_name = "PART", default_value = "0.01")]
    near: f32,
    /// How many threads everyone has
    #[arg(long, value_name = "N,N", value_delimiter = ',', default_value = "1,2", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Vec<u16>,
    /// Frames of each scene's animation in which everyone builds and answers, in turn; two more come first and don't count
    #[arg(long, value_name = "N", default_value = "7", value_parser = clap::value_parser!(u32).range(1..))]
    rounds: u32,
    /// Embree's library [default: the system's]
    #[arg(long, value_name = "PATH", env = "UMBRAGE_EMBREE")]
    embree: Option<PathBuf>,
    /// How the results are written
    #[arg(long, value_enum, default_value = "table")]
    form: Form,
}

/// Our side, and Embree's with a build of low and of medium quality.
const SIDES: [&str; 3] = ["nearest", "embree low", "embree medium"];

/// Where the points are.
const WHERE: [&str; 2] = ["in space", "near"];

/// Milliseconds of each side in a frame.
#[derive(Clone, Copy, Default)]
struct Taken {
    build: [f64; 3],
    /// For points in space, and near the surface.
    ask: [[f64; 3]; 2],
    /// Points whose distance Embree has otherwise.
    differ: [[usize; 3]; 2],
}

pub(crate) fn run(flags: &NearestFlags) -> Result<()> {
    let conditions = format!("closest of {} points, medians of {} frames in milliseconds", flags.points, flags.rounds);
    let mut table = Table::start(flags.form, &conditions)?;
    for address in &flags.scenes {
        let scene = umbrage::open(address).with_context(|| format!("scene {address}"))?;
        for &threads in &flags.threads {
            let mut race = Race::new(flags, usize::from(threads))?;
            let (mut frame, mut all) = (Frame::default(), Vec::new());
            let uncounted = moments(&scene, 2).map(|(seconds, _)| (seconds, false)).collect::<Vec<_>>();
            let counted = moments(&scene, flags.rounds).filter(|(_, is_counted)| *is_counted);
            for (seconds, is_counted) in uncounted.into_iter().chain(counted) {
                scene.pose(seconds, &mut frame)?;
                let taken = race.measure(flags, &frame)?;
                if is_counted {
                    all.push(taken);
                }
            }
            for (at, is_at) in WHERE.iter().enumerate() {
                let of = |part: &dyn Fn(&Taken) -> f64| median(all.iter().map(part));
                let whole = |side: usize| of(&|taken| taken.build[side] + taken.ask[at][side]);
                let ask = |side: usize| of(&|taken| taken.ask[at][side]);
                for (side, is_side) in SIDES.iter().enumerate() {
                    table.push(row![
                        ("scene", name(address)),
                        ("triangles", frame.triangles().len()),
                        ("threads", usize::from(threads)),
                        ("points", *is_at),
                        ("side", *is_side),
                        ("build", of(&|taken| taken.build[side])),
                        ("ask", ask(side)),
                        ("whole", whole(side)),
                        ("rebuilt", whole(side) / whole(0)),
                        ("kept", ask(side) / ask(0)),
                        ("differ", all.iter().map(|taken| taken.differ[at][side]).sum::<usize>()),
                    ])?;
                }
            }
        }
    }
    Ok(table.finish(&[
        "build: for each frame anew; ask: all points, in random order, one by one in Embree; rebuilt and kept: how many times as",
        "long as ours it takes with building, and without; differ: points of all frames whose distance in Embree is wrong by more",
        "than a millionth of the scene's size.",
    ])?)
}

/// State of all sides, from frame to frame.
struct Race {
    pool: rayon::ThreadPool,
    nearest: Nearest,
    closest: ClosestPoints,
    embree: [Scene; 2],
    theirs: Vec<f32>,
}

impl Race {
    fn new(flags: &NearestFlags, threads: usize) -> Result<Self> {
        let embree = Embree::load(flags.embree.as_deref(), threads)?;
        Ok(Self {
            pool: rayon::ThreadPoolBuilder::new().num_threads(threads).build()?,
            nearest: Nearest::default(),
            closest: ClosestPoints::default(),
            embree: [Quality::Low, Quality::Medium]
                .map(|quality| Scene::new(&embree, BuildMethod { quality, kept: true })),
            theirs: vec![0.0; flags.points],
        })
    }

    fn measure(&mut self, flags: &NearestFlags, frame: &Frame) -> Result<Taken> {
        let Self { pool, nearest, closest, embree, theirs } = self;
        let (triangles, posed) = (frame.triangles(), Arc::new(Posed::new(frame, false)?));
        let size = triangles.bounds().size().max_element();
        let points = [in_space(triangles, flags.points), near(triangles, flags.points, flags.near * size)];
        let mut taken = Taken::default();
        pool.install(|| {
            time(&mut taken.build[0], || nearest.build(triangles));
            for (scene, build) in embree.iter_mut().zip(&mut taken.build[1..]) {
                time(build, || scene.build(&posed))?;
            }
            for (points, (ask, differ)) in points.iter().zip(taken.ask.iter_mut().zip(&mut taken.differ)) {
                time(&mut ask[0], || nearest.closest_points(&Closest::new(triangles, points), closest));
                for (side, scene) in embree.iter().enumerate() {
                    time(&mut ask[side + 1], || ask_embree(scene, points, theirs));
                    let is_wrong =
                        |(theirs, ours): &(&f32, &f64)| (f64::from(**theirs) - **ours).abs() > 1e-6 * f64::from(size);
                    differ[side + 1] = theirs.iter().zip(&closest.distance).filter(is_wrong).count();
                }
            }
            Ok(taken)
        })
    }
}

/// Points anywhere in the scene's bounds.
fn in_space(triangles: Triangles<'_>, count: usize) -> Vec<Vec3> {
    let (bounds, mut random) = (triangles.bounds(), Random::new(1));
    (0..count).map(|_| bounds.min + bounds.size() * random.point().midpoint(Vec3::ONE)).collect()
}

/// Points beside triangles, at most so far on each axis.
fn near(triangles: Triangles<'_>, count: usize, distance: f32) -> Vec<Vec3> {
    let mut random = Random::new(2);
    let point = |_| {
        let [a, b, c] = triangles.corners(random.below(triangles.len()) as u32);
        a.lerp(b, random.unit()).lerp(c, random.unit()) + random.point() * distance
    };
    (0..count).map(point).collect()
}

fn ask_embree(scene: &Scene, points: &[Vec3], distances: &mut [f32]) {
    distances.par_iter_mut().with_min_len(256).zip(points).for_each(|(distance, &point)| {
        *distance = scene.closest_point(point).map_or(f32::INFINITY, |(_, distance)| distance);
    });
}
