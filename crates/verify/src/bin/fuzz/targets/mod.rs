//! The fuzzer's targets, and the checks of accepted mutants.

mod api;
mod files;
mod words;

use anyhow::{Context as _, Result, bail, ensure};
use umbrage::Film;
use umbrage::scene::Frame;
use umbrage_verify::Random;

use crate::worker::Workplace;

/// Outcome of a mutant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Answer {
    Accepted,
    Refused,
}

/// Code that is fuzzed.
pub(crate) trait Target {
    /// Makes the mutant that follows from `random` and tries it. An error is a finding, and so is a panic.
    fn run(&mut self, random: &mut Random, place: &mut Workplace<'_>) -> Result<Answer>;
}

/// Readies a target of some name in a worker's folder.
type Open = fn(&str, &Workplace<'_>) -> Result<Box<dyn Target>>;

const TARGETS: [(&str, Open); 14] = [
    ("gltf", |name, place| Ok(Box::new(files::Reader::open(name, place)?))),
    ("glb", |name, place| Ok(Box::new(files::Reader::open(name, place)?))),
    ("obj", |name, place| Ok(Box::new(files::Reader::open(name, place)?))),
    ("ply", |name, place| Ok(Box::new(files::Reader::open(name, place)?))),
    ("stl", |name, place| Ok(Box::new(files::Reader::open(name, place)?))),
    ("pc2", |name, place| Ok(Box::new(files::Reader::open(name, place)?))),
    ("mdd", |name, place| Ok(Box::new(files::Reader::open(name, place)?))),
    ("sequence", |_, place| Ok(Box::new(files::Sequence::open(place)?))),
    ("images", |_, _| Ok(Box::new(files::Images::open()?))),
    ("pose", |_, _| Ok(Box::new(files::Poses::open()?))),
    ("api", |_, _| Ok(Box::new(api::Api::open()?))),
    ("options", |_, _| Ok(Box::new(words::Options))),
    ("command", |_, place| Ok(Box::new(words::Command::open(place)?))),
    (BROKEN, |_, _| Ok(Box::new(Broken))),
];

/// A target that always fails, for the test of the fuzzer itself.
pub(crate) const BROKEN: &str = "broken";

struct Broken;

impl Target for Broken {
    fn run(&mut self, random: &mut Random, _: &mut Workplace<'_>) -> Result<Answer> {
        match random.below(4) {
            0 => panic!("this panics"),
            1 => bail!("this is wrong"),
            // More bytes than any machine has.
            2 => Ok(if vec![0_u8; 1 << 50].is_empty() { Answer::Accepted } else { Answer::Refused }),
            _ => Ok(Answer::Accepted),
        }
    }
}

/// The names of all targets.
pub(crate) fn names() -> [&'static str; TARGETS.len()] {
    TARGETS.map(|(name, _)| name)
}

/// The target of a name.
pub(crate) fn open(name: &str, place: &Workplace<'_>) -> Result<Box<dyn Target>> {
    let (name, open) = TARGETS.iter().find(|(known, _)| *known == name).context("no such target")?;
    open(name, place)
}

/// Checks that a film has no NaN or infinity, and only triangles of the frame.
fn check_film(film: &Film, frame: &Frame) -> Result<()> {
    if let Some(color) = film.color.iter().find(|color| !color.is_finite()) {
        bail!("a colour is {color}");
    }
    if let Some(normal) = film.normal.iter().find(|normal| !normal.is_finite()) {
        bail!("a normal is {normal}");
    }
    let triangles = frame.triangles().len();
    for (&triangle, &depth) in film.triangle.iter().zip(&film.depth) {
        let is_miss = triangle == Film::NO_TRIANGLE;
        ensure!(is_miss || (triangle as usize) < triangles, "triangle {triangle} of {triangles} is seen");
        ensure!(is_miss != depth.is_finite(), "triangle {triangle} is at depth {depth}");
    }
    Ok(())
}
