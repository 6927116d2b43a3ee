//! A spinning lidar: directions all around from one origin, beside Embree.

use std::f32::consts::TAU;

use anyhow::Result;
use clap::Args;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use umbrage::rays::{Scan, Scanned, Scanner, Sweep, Triangles, Wanted};
use umbrage_peers::{Posed, RayHitPacket, Valid};

use crate::beside::{BesideFlags, Question, WIDTH};
use crate::flags::size;

#[derive(Debug, Args)]
pub(crate) struct ScanFlags {
    #[command(flatten)]
    beside: BesideFlags,
    /// Directions around the sensor, and beams one above the other
    #[arg(long, value_name = "WxH", default_value = "2048x128", value_parser = size)]
    beams: [u32; 2],
    /// Angle from the lowest to the highest beam, in degrees; the middle is horizontal
    #[arg(long, value_name = "DEGREES", default_value = "45")]
    field: f32,
    /// Where the sensor is: from the lowest (0) to the highest (1) corner of what there is, along each axis
    #[arg(long, value_name = "X,Y,Z", value_delimiter = ',', num_args = 3, default_value = "0.5,0.5,0.5")]
    at: Vec<f64>,
    /// Ask for the triangles' ids alone
    #[arg(long)]
    ids: bool,
}

pub(crate) fn run(flags: &ScanFlags) -> Result<()> {
    let [around, beams] = flags.beams;
    let about = format!("a lidar of {around}x{beams} directions over {} degrees", flags.field);
    let lidar = Lidar {
        at: DVec3::new(flags.at[0], flags.at[1], flags.at[2]),
        directions: directions(flags),
        origin: DVec3::ZERO,
        wanted: if flags.ids { Wanted::IDS } else { Wanted::ALL },
        scanned: Scanned::default(),
        theirs: Vec::new(),
    };
    let notes = [
        "build: for each frame anew; trace: with sorting directions; ratio: how many times as long as the scan; hits: of the",
        "last frame; differ: directions whose hit is another triangle than the scan's, or none, in all frames. Embree's",
        "packets have 4x4 neighbouring directions, and are made within its time.",
    ];
    flags.beside.run(lidar, &about, &notes)
}

/// First hits of a lidar's directions.
struct Lidar {
    /// Position in the scene's bounds, 0 to 1 along each axis.
    at: DVec3,
    directions: Vec<Vec3>,
    origin: DVec3,
    wanted: Wanted,
    scanned: Scanned,
    /// Names of Embree's hits, all ones for a miss.
    theirs: Vec<u32>,
}

impl Question for Lidar {
    const SIDE: &'static str = "scan";
    const ASKING: &'static str = "trace";
    const FOUND: &'static str = "hits";

    fn prepare(&mut self, triangles: Triangles<'_>) {
        let bounds = triangles.bounds();
        self.origin = (bounds.min.as_dvec3() + bounds.size().as_dvec3() * self.at).as_vec3().as_dvec3();
    }

    fn ask_scanner(&mut self, scanner: &mut Scanner, triangles: Triangles<'_>) {
        let sweeps = [Sweep { origin: self.origin, directions: &self.directions }];
        let scan = Scan { wanted: self.wanted, ..Scan::new(triangles, &sweeps) };
        scanner.scan(&scan, 1, &mut self.scanned);
    }

    fn ask_embree(&mut self, scene: &umbrage_peers::Scene, _: Triangles<'_>) {
        by_packets(scene, self.origin.as_vec3(), &self.directions, &mut self.theirs);
    }

    fn differing(&self, posed: &Posed) -> usize {
        let of_posed = |&name: &u32| if name == u32::MAX { name } else { posed.triangle(name) };
        let others = self.theirs.iter().map(of_posed).zip(&self.scanned.triangle);
        others.filter(|(theirs, ours)| theirs != *ours).count()
    }

    fn found(&self) -> usize {
        self.scanned.triangle.iter().filter(|&&id| id != Scanned::NONE).count()
    }
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

/// Finds the names of the directions' hits, all ones for a miss.
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
