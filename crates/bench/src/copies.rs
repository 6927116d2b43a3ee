//! Copies of a mesh that stay copies beside all of their triangles, and rays with a moment each beside rays of one moment.

use std::f64::consts::TAU;

use anyhow::{Context, Result};
use clap::Args;
use glam::{DAffine3, DQuat, DVec3, Vec3};
use umbrage::rays::{
    InstanceTree, InstancedTriangles, Key, MotionTree, MovingTriangles, Placement, Ray, RayMasks, Scanned, Trace,
    Tracer, Triangles,
};
use umbrage::scene::Frame;

use crate::grids::time;
use crate::measure::median;
use crate::rays::on_sphere;
use crate::shot::{moments, name};
use crate::table::{Form, Table, row};

#[derive(Debug, Args)]
pub(crate) struct CopiesFlags {
    /// Files, sequences or demo:NAME, whose triangles are the mesh
    #[arg(default_values = ["demo:shatter?triangles=4000"])]
    scenes: Vec<String>,
    /// How many copies
    #[arg(long, value_name = "N,N", value_delimiter = ',', default_value = "1,100,2000")]
    copies: Vec<usize>,
    /// How many rays
    #[arg(long, value_name = "N", default_value = "262144")]
    rays: usize,
    /// Frames in which everyone builds and traces, in turn; one more comes first and doesn't count
    #[arg(long, value_name = "N", default_value = "5", value_parser = clap::value_parser!(u32).range(1..))]
    rounds: u32,
    /// How the results are written
    #[arg(long, value_enum, default_value = "table")]
    form: Form,
}

/// Times in milliseconds; each pair is of rays from one origin and of rays from origins of their own.
#[derive(Clone, Copy, Default)]
struct Taken {
    build: f64,
    ask: [f64; 2],
    /// To pose all triangles, and to build and ask the tracer.
    pose: f64,
    flattened: [f64; 2],
    /// Of rays with a moment each: to build between two keys, and to ask.
    motion_build: f64,
    motion: [f64; 2],
}

pub(crate) fn run(flags: &CopiesFlags) -> Result<()> {
    let threads = rayon::current_num_threads();
    let conditions = format!(
        "copies of a mesh, {} rays, threads {threads}, medians of {} frames in milliseconds",
        flags.rays, flags.rounds
    );
    let mut table = Table::start(flags.form, &conditions)?;
    for address in &flags.scenes {
        let scene = umbrage::open(address).with_context(|| format!("scene {address}"))?;
        for &copies in &flags.copies {
            let (mut race, mut frame, mut all) = (Race::default(), Frame::default(), Vec::new());
            for (number, (seconds, is_counted)) in moments(&scene, flags.rounds).enumerate() {
                scene.pose(seconds, &mut frame)?;
                let taken = race.measure(frame.triangles(), copies, flags.rays, number);
                if is_counted {
                    all.push(taken);
                }
            }
            let of = |part: &dyn Fn(&Taken) -> f64| median(all.iter().map(part));
            let [of_mesh, of_copies] = race.tree.bytes();
            for (kind, rays) in ["one origin", "origins of their own"].into_iter().enumerate() {
                table.push(row![
                    ("scene", name(address)),
                    ("triangles", frame.triangles().len()),
                    ("copies", copies),
                    ("rays", rays),
                    ("build", of(&|taken| taken.build)),
                    ("ask", of(&|taken| taken.ask[kind])),
                    ("pose", of(&|taken| taken.pose)),
                    ("flattened", of(&|taken| taken.flattened[kind])),
                    ("ratio", of(&|taken| (taken.pose + taken.flattened[kind]) / (taken.build + taken.ask[kind]))),
                    ("motion_build", of(&|taken| taken.motion_build)),
                    ("motion", of(&|taken| taken.motion[kind])),
                    ("mesh_bytes", of_mesh),
                    ("bytes_a_copy", of_copies / copies.max(1)),
                ])?;
            }
        }
    }
    Ok(table.finish(&[
        "build: the hierarchies of the mesh, which has moved, and of its placements; pose: all triangles, in f64, on one thread;",
        "flattened: what the tracer takes to build and ask among them. Hits of both are compared. ratio: how many times as long it",
        "takes to pose, build and ask there. motion: rays with a moment each between two keys, among the mesh alone.",
    ])?)
}

/// State of all sides, from frame to frame.
#[derive(Default)]
struct Race {
    tree: InstanceTree,
    motion: MotionTree,
    tracer: Tracer,
    positions: Vec<Vec3>,
    indices: Vec<[u32; 3]>,
    found: Scanned,
    flattened: Scanned,
}

impl Race {
    fn measure(&mut self, mesh: Triangles<'_>, copies: usize, count: usize, frame: usize) -> Taken {
        let Self { tree, motion, tracer, positions, indices, found, flattened } = self;
        let mut taken = Taken::default();
        let bounds = mesh.bounds();
        let (middle, size) = (bounds.center().as_dvec3(), f64::from(bounds.size().max_element()));
        // So that a ray meets some dozens of boxes.
        let reach = 0.8 * size * (copies as f64).cbrt();
        let placed = |number: usize| {
            let (axis, at) = (on_sphere(number as u64), on_sphere((number + copies) as u64));
            let turn = DQuat::from_axis_angle(axis, number as f64 + 0.01 * frame as f64);
            let from_middle = DAffine3::from_rotation_translation(turn, at * (reach * fraction(number)));
            Placement::new(0, from_middle * DAffine3::from_translation(-middle))
        };
        let placements: Vec<Placement> = (0..copies).map(placed).collect();
        let meshes = [mesh];
        let scene = InstancedTriangles { meshes: &meshes, placements: &placements };
        // A lidar's turn, and rays from anywhere to anywhere.
        let turn = |number: usize| {
            let (row, column) = (number % 128, number / 128);
            let (sin, cos) = (TAU * (128 * column) as f64 / count as f64).sin_cos();
            let direction = DVec3::new(cos, row as f64 / 128.0 - 0.5, sin).as_vec3();
            Ray::new(DVec3::ZERO, direction.as_dvec3())
        };
        let own = |number: usize| {
            let origin = on_sphere((2 * number) as u64) * (reach * fraction(number));
            Ray::new(origin, on_sphere((2 * number + 1) as u64))
        };
        let rays: [Vec<Ray>; 2] = [(0..count).map(turn).collect(), (0..count).map(own).collect()];
        tree.forget(0);
        time(&mut taken.build, || tree.build(&scene));
        if indices.len() != copies * mesh.len() {
            let vertices = mesh.positions.len();
            let of_copy = |copy: usize| {
                mesh.indices.iter().map(move |corners| corners.map(|vertex| vertex + (copy * vertices) as u32))
            };
            indices.clear();
            indices.extend((0..copies).flat_map(of_copy));
        }
        time(&mut taken.pose, || {
            positions.clear();
            let posed = |placement: &Placement| {
                mesh.positions.iter().map(|&position| placement.pose(position)).collect::<Vec<_>>()
            };
            positions.extend(placements.iter().flat_map(posed));
        });
        let all = Triangles { positions, indices };
        for (kind, rays) in rays.iter().enumerate() {
            time(&mut taken.ask[kind], || tree.trace(&scene, rays, RayMasks::default(), found));
            tracer.forget();
            time(&mut taken.flattened[kind], || _ = tracer.trace(&Trace::new(all, rays), flattened));
            assert!(
                found.t == flattened.t && found.triangle == flattened.triangle,
                "hits of copies and of all triangles"
            );
        }
        let later: Vec<Vec3> = mesh.positions.iter().map(|position| *position + bounds.size() * 0.02).collect();
        let keys = [(0.0, mesh.positions), (1.0, &later)].map(|(seconds, positions)| Key { seconds, positions });
        let moving = MovingTriangles { keys: &keys, indices: mesh.indices };
        time(&mut taken.motion_build, || motion.build(&moving));
        let seconds: Vec<f64> = (0..count).map(|number| number as f64 / count as f64).collect();
        for (kind, rays) in rays.iter().enumerate() {
            let here: Vec<Ray> =
                rays.iter().map(|ray| Ray { origin: ray.origin / (copies as f64).cbrt() + middle, ..*ray }).collect();
            time(&mut taken.motion[kind], || motion.trace(&moving, &here, &seconds, found));
        }
        taken
    }
}

/// Evenly spread numbers below one.
fn fraction(number: usize) -> f64 {
    (number as f64 * std::f64::consts::PI).fract().cbrt()
}
