//! A spinning lidar: directions all around from one origin, beside Embree.

use std::f32::consts::TAU;
use std::hint::black_box;
use std::sync::Arc;

use anyhow::{Context, Result};
use clap::Args;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use umbrage::rays::{Scan, Scanned, Scanner, Sweep};
use umbrage::scene::Frame;
use umbrage_peers::{BuildMethod, Embree, Posed, Quality, RayHitPacket, Valid};

use crate::flags::{SceneFlags, size};
use crate::grids::time;
use crate::median::{geometric_mean, median};
use crate::shot::{moments, name};
use crate::table::{Form, Table, row};

/// Rays of a packet.
const WIDTH: usize = 16;

#[derive(Debug, Args)]
pub(crate) struct ScanFlags {
    #[command(flatten)]
    scenes: SceneFlags,
    /// Directions around the sensor, and beams one above the other
    #[arg(long, value_name = "WxH", default_value = "2048x128", value_parser = size)]
    beams: [u32; 2],
    /// Angle from the lowest to the highest beam, in degrees; the middle is horizontal
    #[arg(long, value_name = "DEGREES", default_value = "45")]
    field: f32,
    /// Where the sensor is: from the lowest (0) to the highest (1) corner of what there is, along each axis
    #[arg(long, value_name = "X,Y,Z", value_delimiter = ',', num_args = 3, default_value = "0.5,0.5,0.5")]
    at: Vec<f64>,
    /// Frames of each scene's animation in which everyone builds and scans, in turn; two more come first and don't count
    #[arg(long, value_name = "N", default_value = "7", value_parser = clap::value_parser!(u32).range(1..))]
    rounds: u32,
    /// Embree's library [default: the system's]
    #[arg(long, value_name = "PATH", env = "UMBRAGE_EMBREE")]
    embree: Option<std::path::PathBuf>,
    /// How the results are written
    #[arg(long, value_enum, default_value = "table")]
    form: Form,
}

/// What a side took in each frame, in milliseconds, and how many of its hits are others.
#[derive(Default)]
struct Side {
    name: &'static str,
    build: Vec<f64>,
    trace: Vec<f64>,
    differ: usize,
}

impl Side {
    fn whole(&self) -> f64 {
        median(self.build.iter().zip(&self.trace).map(|(build, trace)| build + trace))
    }
}

pub(crate) fn run(flags: &ScanFlags) -> Result<()> {
    let embree = Embree::load(flags.embree.as_deref(), rayon::current_num_threads())?;
    let [around, beams] = flags.beams;
    let conditions = format!(
        "a lidar of {around}x{beams} directions over {} degrees, threads {}, medians of {} frames in milliseconds",
        flags.field,
        rayon::current_num_threads(),
        flags.rounds
    );
    let mut table = Table::start(flags.form, &conditions)?;
    let directions = directions(flags);
    let mut ratios = Vec::new();
    for address in flags.scenes.addresses() {
        let scene = umbrage::open(&address).with_context(|| format!("scene {address}"))?;
        let mut sides = ["scan", "embree low", "embree medium"].map(|name| Side { name, ..Side::default() });
        let mut peers = [Quality::Low, Quality::Medium]
            .map(|quality| umbrage_peers::Scene::new(&embree, BuildMethod { quality, kept: true }));
        let (mut scanner, mut scanned, mut hits) = (Scanner::default(), Scanned::default(), Vec::new());
        let mut frame = Frame::default();
        let uncounted = moments(&scene, 2).map(|(seconds, _)| (seconds, false)).collect::<Vec<_>>();
        let counted = moments(&scene, flags.rounds).filter(|(_, is_counted)| *is_counted);
        for (seconds, is_counted) in uncounted.into_iter().chain(counted) {
            scene.pose(seconds, &mut frame)?;
            let triangles = frame.triangles();
            let bounds = triangles.bounds();
            let share = DVec3::new(flags.at[0], flags.at[1], flags.at[2]);
            let origin = (bounds.min.as_dvec3() + bounds.size().as_dvec3() * share).as_vec3().as_dvec3();
            let posed = Arc::new(Posed::new(&frame, false)?);
            let sweeps = [Sweep { origin, directions: &directions }];
            let mut times = [[0.0; 2]; 3];
            time(&mut times[0][0], || scanner.build(triangles));
            time(&mut times[0][1], || scanner.scan(&Scan::new(triangles, &sweeps), 1, &mut scanned));
            let mut differ = [0; 3];
            for (side, peer) in peers.iter_mut().enumerate() {
                time(&mut times[side + 1][0], || peer.build(&posed))?;
                time(&mut times[side + 1][1], || by_packets(peer, origin.as_vec3(), &directions, &mut hits));
                black_box(&hits);
                let of_posed = |&name: &u32| if name == u32::MAX { name } else { posed.triangle(name) };
                let others = hits.iter().map(of_posed).zip(&scanned.triangle);
                differ[side + 1] = others.filter(|(theirs, ours)| theirs != *ours).count();
            }
            for (side, ([build, trace], differ)) in sides.iter_mut().zip(times.into_iter().zip(differ)) {
                if is_counted {
                    side.build.push(build);
                    side.trace.push(trace);
                    side.differ += differ;
                }
            }
        }
        let hit = scanned.triangle.iter().filter(|&&id| id != Scanned::NONE).count();
        let whole = sides[0].whole();
        for side in &sides {
            table.push(row![
                ("scene", name(&address)),
                ("triangles", frame.triangles().len()),
                ("hits", hit),
                ("side", side.name),
                ("build", median(side.build.iter().copied())),
                ("trace", median(side.trace.iter().copied())),
                ("whole", side.whole()),
                ("ratio", side.whole() / whole),
                ("differ", side.differ),
            ])?;
        }
        ratios.push(sides[1].whole().min(sides[2].whole()) / whole);
    }
    let mean = format!("Geometric mean of the faster of Embree's: {:.2}.", geometric_mean(ratios));
    table.finish(&[
        "build: for each frame anew; trace: with sorting directions; ratio: how many times as long as the scan; hits: of the",
        "last frame; differ: directions whose hit is another triangle than the scan's, or none, in all frames. Embree's",
        "packets have 4x4 neighbouring directions, and are made within its time.",
        &mean,
    ])?;
    Ok(())
}

/// Beam by beam in blocks of 4×4, so that Embree's packets are coherent.
fn directions(flags: &ScanFlags) -> Vec<Vec3> {
    let [around, beams] = flags.beams;
    let direction = |column: u32, row: u32| {
        let (azimuth, share) = (column as f32 / around as f32 * TAU, (row as f32 + 0.5) / beams as f32 - 0.5);
        let elevation = (share * flags.field).to_radians();
        Vec3::new(azimuth.cos() * elevation.cos(), elevation.sin(), azimuth.sin() * elevation.cos())
    };
    let blocks = (0..beams.div_ceil(4)).flat_map(|row| (0..around.div_ceil(4)).map(move |column| (column, row)));
    let all = blocks.flat_map(|(column, row)| (0..16).map(move |of| (column * 4 + of % 4, row * 4 + of / 4)));
    all.filter(|&(column, row)| column < around && row < beams).map(|(column, row)| direction(column, row)).collect()
}

/// Finds the names of what directions hit, all ones for a miss.
fn by_packets(scene: &umbrage_peers::Scene, origin: Vec3, directions: &[Vec3], hits: &mut Vec<u32>) {
    hits.resize(directions.len(), u32::MAX);
    directions.par_chunks(WIDTH * 64).zip(hits.par_chunks_mut(WIDTH * 64)).for_each(|(directions, hits)| {
        let mut packet = RayHitPacket::default();
        packet.ray.origin = origin.to_array().map(|value| [value; WIDTH]);
        for (directions, hits) in directions.chunks(WIDTH).zip(hits.chunks_mut(WIDTH)) {
            packet.forget_hits();
            let mut valid = Valid::NONE;
            for (lane, direction) in directions.iter().enumerate() {
                valid.0[lane] = -1;
                for axis in [0, 1, 2] {
                    packet.ray.direction[axis][lane] = direction[axis];
                }
            }
            scene.nearest(&valid, &mut packet);
            let names = Posed::names(&packet.hit.primitive, &packet.hit.geometry);
            hits.copy_from_slice(&names[..hits.len()]);
        }
    });
}
