//! A question about each frame of animations, answered by scans and by Embree, with everything built anew.

use std::path::PathBuf;
use std::sync::Arc;

use anyhow::{Context, Result};
use clap::Args;
use umbrage::rays::{Scanner, Triangles};
use umbrage::scene::Frame;
use umbrage_peers::{BuildMethod, Embree, Posed, Quality};

use crate::flags::SceneFlags;
use crate::grids::time;
use crate::measure::{geometric_mean, median};
use crate::shot::{moments, name};
use crate::table::{Form, Table, row};

/// Rays of Embree's packets.
pub(crate) const WIDTH: usize = 16;

#[derive(Debug, Args)]
pub(crate) struct BesideFlags {
    #[command(flatten)]
    scenes: SceneFlags,
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

/// A question, and its last answers.
pub(crate) trait Question {
    /// Name of our side, and title of the column of query times.
    const SIDE: &'static str;
    const ASKING: &'static str;
    /// Title of the column of findings.
    const FOUND: &'static str;

    /// Prepares for a frame; isn't timed.
    fn prepare(&mut self, triangles: Triangles<'_>);
    fn ask_scanner(&mut self, scanner: &mut Scanner, triangles: Triangles<'_>);
    fn ask_embree(&mut self, scene: &umbrage_peers::Scene, triangles: Triangles<'_>);
    /// Number of Embree's answers that differ from ours.
    fn differing(&self, posed: &Posed) -> usize;
    /// Number of our own findings.
    fn found(&self) -> usize;
}

/// A side's times in each frame, in milliseconds, and its number of differing answers.
#[derive(Default)]
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

impl BesideFlags {
    /// Asks `question` about all scenes; `about` describes it, `notes` explain its columns.
    pub(crate) fn run<Q: Question>(&self, mut question: Q, about: &str, notes: &[&str]) -> Result<()> {
        let threads = rayon::current_num_threads();
        let embree = Embree::load(self.embree.as_deref(), threads)?;
        let conditions = format!("{about}, threads {threads}, medians of {} frames in milliseconds", self.rounds);
        let mut table = Table::start(self.form, &conditions)?;
        let mut ratios = Vec::new();
        for address in self.scenes.addresses() {
            let (sides, triangles) = self.measure(&address, &embree, &mut question)?;
            let whole = sides[0].whole();
            for side in &sides {
                table.push(row![
                    ("scene", name(&address)),
                    ("triangles", triangles),
                    (Q::FOUND, question.found()),
                    ("side", side.name),
                    ("build", median(side.build.iter().copied())),
                    (Q::ASKING, median(side.ask.iter().copied())),
                    ("whole", side.whole()),
                    ("ratio", side.whole() / whole),
                    ("differ", side.differ),
                ])?;
            }
            ratios.push(sides[1].whole().min(sides[2].whole()) / whole);
        }
        let mean = format!("Geometric mean of the faster of Embree's: {:.2}.", geometric_mean(ratios));
        Ok(table.finish(&[notes, &[&mean]].concat())?)
    }

    /// Times of each side for a scene, and its number of triangles.
    fn measure<Q: Question>(
        &self,
        address: &str,
        embree: &Arc<Embree>,
        question: &mut Q,
    ) -> Result<([Side; 3], usize)> {
        let scene = umbrage::open(address).with_context(|| format!("scene {address}"))?;
        let names = [Q::SIDE, "embree low", "embree medium"];
        let mut sides = names.map(|name| Side { name, ..Side::default() });
        let mut peers = [Quality::Low, Quality::Medium]
            .map(|quality| umbrage_peers::Scene::new(embree, BuildMethod { quality, kept: true }));
        let (mut scanner, mut frame) = (Scanner::default(), Frame::default());
        let uncounted = moments(&scene, 2).map(|(seconds, _)| (seconds, false)).collect::<Vec<_>>();
        let counted = moments(&scene, self.rounds).filter(|(_, is_counted)| *is_counted);
        for (seconds, is_counted) in uncounted.into_iter().chain(counted) {
            scene.pose(seconds, &mut frame)?;
            let triangles = frame.triangles();
            let posed = Arc::new(Posed::new(&frame, false)?);
            question.prepare(triangles);
            let (mut times, mut differ) = ([[0.0; 2]; 3], [0; 3]);
            time(&mut times[0][0], || scanner.build(triangles));
            time(&mut times[0][1], || question.ask_scanner(&mut scanner, triangles));
            for (side, peer) in peers.iter_mut().enumerate() {
                time(&mut times[side + 1][0], || peer.build(&posed))?;
                time(&mut times[side + 1][1], || question.ask_embree(peer, triangles));
                differ[side + 1] = question.differing(&posed);
            }
            for (side, ([build, ask], differ)) in sides.iter_mut().zip(times.into_iter().zip(differ)) {
                if is_counted {
                    side.build.push(build);
                    side.ask.push(ask);
                    side.differ += differ;
                }
            }
        }
        Ok((sides, frame.triangles().len()))
    }
}
