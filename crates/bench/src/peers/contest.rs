use std::sync::Arc;

use anyhow::Result;
use umbrage::Scene;
use umbrage::rays::Bvh;
use umbrage::scene::Frame;
use umbrage_peers::{BuildMethod, Embree, Image, Posed, Quality};

use super::PeersFlags;
use super::compare::Differences;
use super::contestants::{EmbreeSide, make_rays};
use crate::grids::{Ours, Times};
use crate::median::median;
use crate::shot::{Shot, name};
use crate::table::{Row, row};

/// A scene's frames by everyone.
#[derive(Debug)]
pub(super) struct Outcome {
    scene: String,
    /// Whether it moves.
    pub(super) is_moving: bool,
    triangles: usize,
    lights: usize,
    grids: Summary,
    /// Each of Embree's build methods, the fastest first.
    embree: Vec<Summary>,
    /// What Embree's times count for making rays.
    ray_generation: Summary,
    /// Our own hierarchy, where it was asked for.
    hierarchy: Option<Summary>,
    differences: Differences,
}

/// One side's frames: medians in milliseconds.
#[derive(Clone, Debug)]
struct Summary {
    name: &'static str,
    build: f64,
    see: f64,
    survey: f64,
    shadow: f64,
    /// Median over frames and rounds.
    frame: f64,
    /// Median over frames of the best round.
    best_frame: f64,
}

/// How Embree's frames compare with ours.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ratios {
    pub(super) frame: f64,
    /// Of the best rounds.
    pub(super) best: f64,
    pub(super) without_ray_generation: f64,
    /// What a further light costs us, compared with Embree's shadow pass.
    pub(super) further_light: f64,
}

impl Outcome {
    /// Of Embree's fastest build method, by the median frame.
    pub(super) fn ratios(&self) -> Ratios {
        let best = self.embree.iter().map(|embree| embree.best_frame).fold(f64::INFINITY, f64::min);
        Ratios { best: best / self.grids.best_frame, ..self.ratios_of(&self.embree[0]) }
    }

    fn ratios_of(&self, embree: &Summary) -> Ratios {
        let Self { grids, ray_generation, .. } = self;
        Ratios {
            frame: embree.frame / grids.frame,
            best: embree.best_frame / grids.best_frame,
            without_ray_generation: (embree.frame - ray_generation.frame) / grids.frame,
            further_light: grids.shadow / embree.shadow,
        }
    }

    /// A row for each side.
    pub(super) fn rows(&self) -> impl Iterator<Item = Row> {
        let grids = self.row(&self.grids, None, Some(self.differences));
        let embree = self.embree.iter().map(|embree| self.row(embree, Some(self.ratios_of(embree)), None));
        let others = [&self.ray_generation].into_iter().chain(&self.hierarchy);
        [grids].into_iter().chain(embree).chain(others.map(|side| self.row(side, None, None)))
    }

    fn row(&self, side: &Summary, ratios: Option<Ratios>, differences: Option<Differences>) -> Row {
        let ratio = |of: fn(&Ratios) -> f64| ratios.as_ref().map(of);
        let count = |of: fn(&Differences) -> u64| differences.as_ref().map(of);
        row![
            ("scene", self.scene.as_str()),
            ("triangles", self.triangles),
            ("lights", self.lights),
            ("side", side.name),
            ("build", side.build),
            ("see", side.see),
            ("survey", side.survey),
            ("shadow", side.shadow),
            ("frame", side.frame),
            ("best", side.best_frame),
            ("ratio", ratio(|ratios| ratios.frame)),
            ("of_best", ratio(|ratios| ratios.best)),
            ("no_rays", ratio(|ratios| ratios.without_ray_generation)),
            ("light", ratio(|ratios| ratios.further_light)),
            ("hit_or_miss", count(|differ| differ.hit_or_miss)),
            ("triangle", count(|differ| differ.triangle)),
            ("at_same_t", count(|differ| differ.triangle_at_same_distance)),
            ("shadows", count(|differ| differ.shadow)),
            ("points", count(|differ| differ.points)),
        ]
    }
}

const METHODS: [(&str, BuildMethod); 4] = [
    ("Embree low, new", BuildMethod { quality: Quality::Low, kept: false }),
    ("Embree low, kept", BuildMethod { quality: Quality::Low, kept: true }),
    ("Embree med, new", BuildMethod { quality: Quality::Medium, kept: false }),
    ("Embree med, kept", BuildMethod { quality: Quality::Medium, kept: true }),
];

/// Who traces, with what each round of each frame took.
struct Side<T> {
    name: &'static str,
    tracer: T,
    times: Vec<Times>,
}

impl<T> Side<T> {
    fn new(name: &'static str, tracer: T) -> Self {
        Self { name, tracer, times: Vec::new() }
    }

    /// Has a round traced, and keeps its times if it counts.
    fn run(&mut self, is_counted: bool, trace: impl FnOnce(&mut T) -> Result<Times>) -> Result<()> {
        let times = trace(&mut self.tracer)?;
        self.times.extend(is_counted.then_some(times));
        Ok(())
    }

    fn summary(&self, rounds: u32) -> Summary {
        let of = |stage: fn(&Times) -> f64| median(self.times.iter().map(stage));
        let best = |rounds: &[Times]| rounds.iter().map(Times::frame).fold(f64::INFINITY, f64::min);
        Summary {
            name: self.name,
            build: of(|times| times.build),
            see: of(|times| times.see),
            survey: of(|times| times.survey),
            shadow: of(|times| times.shadow),
            frame: of(Times::frame),
            best_frame: median(self.times.chunks(rounds as usize).map(best)),
        }
    }
}

pub(super) fn hold(address: &str, scene: &Scene, flags: &PeersFlags, embree: &Arc<Embree>) -> Result<Outcome> {
    let mut frame = Frame::default();
    let mut grids = Side::new("grids", flags.our_side()?);
    let mut sides = METHODS.map(|(name, method)| Side::new(name, EmbreeSide::new(embree, method)));
    let mut rays_only = Side::new("rays only", Image::default());
    let mut hierarchy = flags.bvh.then(|| Side::new("bvh", Ours::new(Box::<Bvh>::default())));
    let mut differences = Differences::default();
    let mut lights = 0;
    // Kept until every scene has taken the next one, so that nobody's time counts its release.
    let mut last_posed = None;
    for number in 0..flags.frames {
        let seconds = scene.duration_seconds() * f64::from(number) / f64::from(flags.frames);
        scene.pose(seconds, &mut frame)?;
        let shot = Shot { masks: flags.masks, ..Shot::new(&frame, address, flags.size, flags.samples, flags.lights) };
        lights = shot.lights.len();
        let posed = Arc::new(Posed::new(&frame, flags.masks)?);
        // A scene's first round takes memory that later ones use again: it doesn't count.
        let uncounted = u32::from(number == 0);
        for round in 0..flags.rounds + uncounted {
            let is_counted = round >= uncounted;
            grids.run(is_counted, |grids| grids.trace(&shot))?;
            sides.iter_mut().try_for_each(|side| side.run(is_counted, |embree| embree.trace(&shot, &posed)))?;
            rays_only.run(is_counted, |image| Ok(make_rays(image, &shot, &sides[0].tracer.image)))?;
            hierarchy.iter_mut().try_for_each(|bvh| bvh.run(is_counted, |bvh| bvh.trace(&shot)))?;
        }
        differences.add(&shot, &grids.tracer, (&sides[0].tracer.image, &posed));
        last_posed = Some(posed);
    }
    drop(last_posed);
    let mut embree = sides.map(|side| side.summary(flags.rounds)).to_vec();
    embree.sort_by(|a, b| a.frame.total_cmp(&b.frame));
    Ok(Outcome {
        scene: name(address).to_owned(),
        is_moving: scene.duration_seconds() > 0.0,
        triangles: frame.triangles().len(),
        lights,
        grids: grids.summary(flags.rounds),
        embree,
        ray_generation: rays_only.summary(flags.rounds),
        hierarchy: hierarchy.map(|side| side.summary(flags.rounds)),
        differences,
    })
}
