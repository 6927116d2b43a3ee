//! Faces of a mesh that each of many suns reaches, beside Embree.

use anyhow::Result;
use clap::Args;
use glam::Vec3;
use rayon::prelude::*;
use umbrage::rays::{LightSource, Lit, LitBits, Receivers, Scanner, Triangles};
use umbrage_peers::{Posed, RayHitPacket, Valid};

use crate::beside::{BesideFlags, Question, WIDTH};

#[derive(Debug, Args)]
pub(crate) struct LitFlags {
    #[command(flatten)]
    beside: BesideFlags,
    /// Suns, spread evenly over the upper half of the sky
    #[arg(long, value_name = "N", default_value = "100", value_parser = clap::value_parser!(u32).range(1..))]
    suns: u32,
    /// How far Embree's rays begin from their face, in sizes of the scene
    #[arg(long, value_name = "PART", default_value = "1e-5")]
    offset: f32,
}

pub(crate) fn run(flags: &LitFlags) -> Result<()> {
    let (suns, part) = (suns(flags.suns), flags.offset);
    let faces = Faces { suns, part, offset: 0.0, bits: LitBits::default(), theirs: Vec::new() };
    let notes = [
        "build: for each frame anew; ask: a bit for each sun and face; ratio: how many times as long as lit; lit: bits of the last",
        "frame that are set; differ: bits of all frames that are others. Embree's packets have sixteen faces that follow each",
        "other and one sun; they begin beside their face, towards the sun, and are made within its time.",
    ];
    flags.beside.run(faces, &format!("all faces by {} suns", flags.suns), &notes)
}

/// The faces that suns reach.
struct Faces {
    suns: Vec<LightSource>,
    /// Offset of Embree's rays from their face, in sizes of the scene and in world units.
    part: f32,
    offset: f32,
    bits: LitBits,
    /// Sixteen faces in each, the first in the lowest bit; all of the first sun come first.
    theirs: Vec<u16>,
}

impl Question for Faces {
    const SIDE: &'static str = "lit";
    const ASKING: &'static str = "ask";
    const FOUND: &'static str = "lit";

    fn prepare(&mut self, triangles: Triangles<'_>) {
        self.offset = self.part * triangles.bounds().size().max_element();
    }

    fn ask_scanner(&mut self, scanner: &mut Scanner, triangles: Triangles<'_>) {
        scanner.lit(&Lit::new(triangles, Receivers::Faces), &self.suns, &mut self.bits);
    }

    fn ask_embree(&mut self, scene: &umbrage_peers::Scene, triangles: Triangles<'_>) {
        by_packets(scene, triangles, &self.suns, self.offset, &mut self.theirs);
    }

    fn differing(&self, _: &Posed) -> usize {
        let (faces, packets) = (self.bits.points(), self.bits.points().div_ceil(WIDTH));
        let is_lit = |sun: usize, face: usize| self.theirs[sun * packets + face / WIDTH] >> (face % WIDTH) & 1 == 1;
        let of_sun = |sun| (0..faces).filter(|&face| is_lit(sun, face) != self.bits.is_lit(sun, face)).count();
        (0..self.suns.len()).map(of_sun).sum()
    }

    fn found(&self) -> usize {
        let words = (0..self.suns.len()).flat_map(|sun| self.bits.of_light(sun));
        words.map(|word| word.count_ones() as usize).sum()
    }
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

/// Finds the bits of the faces that suns reach.
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
