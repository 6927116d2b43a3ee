use std::sync::Arc;

use anyhow::{Context, Result};
use serde::Serialize;
use umbrage::Scene;
use umbrage::rays::Bvh;
use umbrage::scene::Frame;
use umbrage_peers::{BuildMethod, Embree, Posed, Quality};

use super::PeersFlags;
use super::compare::Differences;
use super::contestants::{EmbreeSide, RaysOnly};
use crate::grids::{Ours, Times};
use crate::median::median;
use crate::shot::{Shot, name};

/// A scene's frames by everyone, in milliseconds.
#[derive(Debug, Serialize)]
pub(super) struct Row {
    pub(super) scene: String,
    /// Whether it is the same at every moment.
    pub(super) is_static: bool,
    pub(super) triangles: usize,
    pub(super) lights: usize,
    pub(super) grids: Summary,
    /// The fastest of Embree's build methods, by the median frame.
    pub(super) embree: Summary,
    /// Each of Embree's build methods.
    pub(super) embree_methods: Vec<Summary>,
    /// What Embree's times count for making rays.
    pub(super) ray_generation: Summary,
    /// Our own hierarchy, where it was asked for.
    pub(super) hierarchy: Option<Summary>,
    pub(super) ratio: f64,
    pub(super) ratio_of_best: f64,
    pub(super) ratio_without_ray_generation: f64,
    /// What a further light costs us, compared with Embree's shadow pass.
    pub(super) further_light: f64,
    pub(super) differences: Differences,
}

/// One side's frames.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Summary {
    pub(super) name: &'static str,
    pub(super) build: f64,
    pub(super) see: f64,
    pub(super) survey: f64,
    pub(super) shadow: f64,
    /// Median over frames and rounds.
    pub(super) frame: f64,
    /// Median over frames of the best round.
    pub(super) best_frame: f64,
}

impl Summary {
    /// `times` holds the rounds of each frame.
    fn new(name: &'static str, times: &[Vec<Times>]) -> Self {
        let of = |stage: fn(&Times) -> f64| median(times.iter().flatten().map(stage));
        let best = |rounds: &Vec<Times>| rounds.iter().map(Times::frame).fold(f64::INFINITY, f64::min);
        Self {
            name,
            build: of(|times| times.build),
            see: of(|times| times.see),
            survey: of(|times| times.survey),
            shadow: of(|times| times.shadow),
            frame: of(Times::frame),
            best_frame: median(times.iter().map(best)),
        }
    }
}

const METHODS: [(&str, BuildMethod); 4] = [
    ("low, new", BuildMethod { quality: Quality::Low, kept: false }),
    ("low, kept", BuildMethod { quality: Quality::Low, kept: true }),
    ("medium, new", BuildMethod { quality: Quality::Medium, kept: false }),
    ("medium, kept", BuildMethod { quality: Quality::Medium, kept: true }),
];

/// Times of each frame's rounds.
type Log = Vec<Vec<Times>>;

pub(super) fn hold(address: &str, scene: &Scene, flags: &PeersFlags, embree: &Arc<Embree>) -> Result<Row> {
    let mut frame = Frame::default();
    let mut grids = flags.our_side()?;
    let mut sides = METHODS.map(|(_, method)| EmbreeSide::new(embree, method));
    let mut rays_only = RaysOnly::default();
    let mut hierarchy = flags.bvh.then(|| Ours::new(Box::<Bvh>::default()));
    let (mut grid_log, mut rays_log, mut hierarchy_log) = (Log::new(), Log::new(), Log::new());
    let mut side_logs: [Log; 4] = Default::default();
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
        for log in side_logs.iter_mut().chain([&mut grid_log, &mut rays_log, &mut hierarchy_log]) {
            log.push(Vec::new());
        }
        // A scene's first round takes memory that later ones use again: it doesn't count.
        let uncounted = u32::from(number == 0);
        for round in 0..flags.rounds + uncounted {
            let counts = round >= uncounted;
            let note = |log: &mut Log, times: Times| {
                if counts {
                    log.last_mut().context("a log without frames").map(|rounds| rounds.push(times))
                } else {
                    Ok(())
                }
            };
            note(&mut grid_log, grids.trace(&shot)?)?;
            for (side, log) in sides.iter_mut().zip(&mut side_logs) {
                note(log, side.trace(&shot, &posed)?)?;
            }
            note(&mut rays_log, rays_only.trace(&shot, &sides[0].image))?;
            if let Some(hierarchy) = &mut hierarchy {
                note(&mut hierarchy_log, hierarchy.trace(&shot)?)?;
            }
        }
        differences.add(&shot, &grids, (&sides[0].image, &posed));
        last_posed = Some(posed);
    }
    drop(last_posed);
    let embree_methods: Vec<Summary> =
        METHODS.iter().zip(&side_logs).map(|((name, _), log)| Summary::new(name, log)).collect();
    let fastest = |by: fn(&Summary) -> f64| embree_methods.iter().min_by(|a, b| by(a).total_cmp(&by(b)));
    let embree = fastest(|side| side.frame).context("nobody to compare with")?.clone();
    let best_frame = fastest(|side| side.best_frame).map_or(f64::NAN, |side| side.best_frame);
    let grids = Summary::new("grids", &grid_log);
    let ray_generation = Summary::new("rays only", &rays_log);
    Ok(Row {
        scene: name(address).to_owned(),
        is_static: scene.duration_seconds() == 0.0,
        triangles: frame.triangles().len(),
        lights,
        ratio: embree.frame / grids.frame,
        ratio_of_best: best_frame / grids.best_frame,
        ratio_without_ray_generation: (embree.frame - ray_generation.frame) / grids.frame,
        further_light: grids.shadow / embree.shadow,
        grids,
        embree,
        embree_methods,
        ray_generation,
        hierarchy: hierarchy.is_some().then(|| Summary::new("bvh", &hierarchy_log)),
        differences,
    })
}
