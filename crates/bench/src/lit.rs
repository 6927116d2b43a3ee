//! Which faces of a mesh each of many suns reaches, beside Embree.

use std::hint::black_box;
use std::sync::Arc;

use anyhow::{Context, Result};
use clap::Args;
use glam::Vec3;
use rayon::prelude::*;
use umbrage::rays::{LightSource, Lit, LitBits, Receivers, Scanner, Triangles};
use umbrage::scene::Frame;
use umbrage_peers::{BuildMethod, Embree, Posed, Quality, RayHitPacket, Valid};

use crate::flags::SceneFlags;
use crate::grids::time;
use crate::median::{geometric_mean, median};
use crate::shot::{moments, name};
use crate::table::{Form, Table, row};

/// Rays of a packet.
const WIDTH: usize = 16;

#[derive(Debug, Args)]
pub(crate) struct LitFlags {
    #[command(flatten)]
    scenes: SceneFlags,
    /// Suns, spread evenly over the upper half of the sky
    #[arg(long, value_name = "N", default_value = "100", value_parser = clap::value_parser!(u32).range(1..))]
    suns: u32,
    /// How far Embree's rays begin from their face, in sizes of the scene
    #[arg(long, value_name = "PART", default_value = "1e-5")]
    offset: f32,
    /// Frames of each scene's animation in which everyone builds and asks, in turn; two more come first and don't count
    #[arg(long, value_name = "N", default_value = "5", value_parser = clap::value_parser!(u32).range(1..))]
    rounds: u32,
    /// Embree's library [default: the system's]
    #[arg(long, value_name = "PATH", env = "UMBRAGE_EMBREE")]
    embree: Option<std::path::PathBuf>,
    /// How the results are written
    #[arg(long, value_enum, default_value = "table")]
    form: Form,
}

/// What a side took in each frame, in milliseconds.
struct Side {
    name: &'static str,
    build: Vec<f64>,
    ask: Vec<f64>,
    differ: usize,
}

impl Side {
    fn whole(&self) -> f64 {
        median(self.build.iter().zip(&self.ask).map(|(build, ask)| build + ask))
    }
}

pub(crate) fn run(flags: &LitFlags) -> Result<()> {
    let embree = Embree::load(flags.embree.as_deref(), rayon::current_num_threads())?;
    let conditions = format!(
        "all faces by {} suns, threads {}, medians of {} frames in milliseconds",
        flags.suns,
        rayon::current_num_threads(),
        flags.rounds
    );
    let mut table = Table::start(flags.form, &conditions)?;
    let suns = suns(flags.suns);
    let mut ratios = Vec::new();
    for address in flags.scenes.addresses() {
        let scene = umbrage::open(&address).with_context(|| format!("scene {address}"))?;
        let side = |name| Side { name, build: Vec::new(), ask: Vec::new(), differ: 0 };
        let mut sides = ["lit", "embree low", "embree medium"].map(side);
        let mut peers = [Quality::Low, Quality::Medium]
            .map(|quality| umbrage_peers::Scene::new(&embree, BuildMethod { quality, kept: true }));
        let (mut scanner, mut bits, mut theirs) = (Scanner::default(), LitBits::default(), Vec::new());
        let mut frame = Frame::default();
        let uncounted = moments(&scene, 2).map(|(seconds, _)| (seconds, false)).collect::<Vec<_>>();
        let counted = moments(&scene, flags.rounds).filter(|(_, is_counted)| *is_counted);
        for (seconds, is_counted) in uncounted.into_iter().chain(counted) {
            scene.pose(seconds, &mut frame)?;
            let triangles = frame.triangles();
            let posed = Arc::new(Posed::new(&frame, false)?);
            let mut times = [[0.0; 2]; 3];
            time(&mut times[0][0], || scanner.build(triangles));
            time(&mut times[0][1], || scanner.lit(&Lit::new(triangles, Receivers::Faces), &suns, &mut bits));
            let offset = flags.offset * triangles.bounds().size().max_element();
            let mut differ = [0; 3];
            for (side, peer) in peers.iter_mut().enumerate() {
                time(&mut times[side + 1][0], || peer.build(&posed))?;
                time(&mut times[side + 1][1], || by_packets(peer, triangles, &suns, offset, &mut theirs));
                black_box(&theirs);
                differ[side + 1] = differing(&theirs, &bits);
            }
            for (side, ([build, ask], differ)) in sides.iter_mut().zip(times.into_iter().zip(differ)) {
                if is_counted {
                    side.build.push(build);
                    side.ask.push(ask);
                    side.differ += differ;
                }
            }
        }
        let words = (0..suns.len()).flat_map(|sun| bits.of_light(sun));
        let lit: usize = words.map(|word| word.count_ones() as usize).sum();
        let whole = sides[0].whole();
        for side in &sides {
            table.push(row![
                ("scene", name(&address)),
                ("faces", frame.triangles().len()),
                ("lit", lit),
                ("side", side.name),
                ("build", median(side.build.iter().copied())),
                ("ask", median(side.ask.iter().copied())),
                ("whole", side.whole()),
                ("ratio", side.whole() / whole),
                ("differ", side.differ),
            ])?;
        }
        ratios.push(sides[1].whole().min(sides[2].whole()) / whole);
    }
    let mean = format!("Geometric mean of the faster of Embree's: {:.2}.", geometric_mean(ratios));
    table.finish(&[
        "build: for each frame anew; ask: a bit for each sun and face; ratio: how many times as long as lit; lit: bits of the last",
        "frame that are set; differ: bits of all frames that are others. Embree's packets have sixteen faces that follow each",
        "other and one sun; they begin beside their face, towards the sun, and are made within its time.",
        &mean,
    ])?;
    Ok(())
}

/// Directions of light from points of a spiral on the upper half of a ball.
fn suns(count: u32) -> Vec<LightSource> {
    const GOLDEN_ANGLE: f32 = 2.399_963_2;
    let sun = |number: u32| {
        let height = 1.0 - (number as f32 + 0.5) / count as f32;
        let (radius, angle) = ((1.0 - height * height).sqrt(), number as f32 * GOLDEN_ANGLE);
        let direction = -Vec3::new(radius * angle.cos(), height, radius * angle.sin());
        LightSource::Directional { direction }
    };
    (0..count).map(sun).collect()
}

/// Bits of the faces that suns reach, sixteen faces in each number, the first in the lowest bit; all of the first sun come first.
fn by_packets(
    scene: &umbrage_peers::Scene,
    triangles: Triangles<'_>,
    suns: &[LightSource],
    offset: f32,
    lit: &mut Vec<u16>,
) {
    const CHUNK: usize = 64;
    let packets = triangles.len().div_ceil(WIDTH);
    lit.resize(packets * suns.len(), 0);
    lit.par_chunks_mut(packets).zip(suns).for_each(|(lit, sun)| {
        let LightSource::Directional { direction } = *sun else { unreachable!("all are suns") };
        lit.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, lit)| {
            let mut packet = RayHitPacket::default();
            packet.ray.direction = (-direction).to_array().map(|value| [value; WIDTH]);
            for (index, lit) in lit.iter_mut().enumerate() {
                packet.forget_hits();
                let first = (chunk * CHUNK + index) * WIDTH;
                let mut valid = Valid::NONE;
                for (lane, face) in (first..triangles.len().min(first + WIDTH)).enumerate() {
                    valid.0[lane] = -1;
                    let [a, b, c] = triangles.corners(face as u32);
                    let origin = (a + b + c) / 3.0 - direction * offset;
                    for axis in [0, 1, 2] {
                        packet.ray.origin[axis][lane] = origin[axis];
                    }
                }
                scene.occluded(&valid, &mut packet);
                *lit = 0;
                for (lane, t_far) in packet.ray.t_far.iter().enumerate() {
                    *lit |= u16::from(*t_far >= 0.0) << lane;
                }
            }
        });
    });
}

/// How many bits of Embree's are others.
fn differing(theirs: &[u16], ours: &LitBits) -> usize {
    let packets = ours.points().div_ceil(WIDTH);
    let of_sun = |(sun, theirs): (usize, &[u16])| {
        (0..ours.points())
            .filter(|face| (theirs[face / WIDTH] >> (face % WIDTH) & 1 == 1) != ours.is_lit(sun, *face))
            .count()
    };
    theirs.chunks(packets).enumerate().map(of_sun).sum()
}
