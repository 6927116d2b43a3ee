use std::sync::Arc;

use anyhow::Result;
use umbrage::Scene;
use umbrage::rays::{Bvh, predicate};
use umbrage::scene::Frame;
use umbrage_peers::{BuildMethod, Embree, Image, Layout, Posed, Quality, TinyBvh};

use super::PeersFlags;
use super::contestants::{EmbreeSide, TinySide, make_rays};
use crate::grids::{Ours, Times};
use crate::measure::{geometric_mean, median};
use crate::shot::{Lights, Shot, name};
use crate::table::{Cell, Row, row};
use umbrage::Samples;

/// Libraries of the other ray tracers.
#[derive(Debug)]
pub(super) struct Libraries {
    pub(super) embree: Arc<Embree>,
    pub(super) tinybvh: Option<Arc<TinyBvh>>,
}

/// A scene's frames by all sides.
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
    /// Each of tinybvh's layouts, the fastest first, and its pictures' differences from ours; empty if it doesn't take part.
    tinybvh: Vec<(Summary, Differences)>,
    /// Ray generation, which Embree's times include.
    ray_generation: Summary,
    /// Our own hierarchy, if requested.
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

/// Ratios of another side's frames to ours.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ratios {
    pub(super) frame: f64,
    /// Of the best rounds.
    pub(super) best: f64,
    pub(super) without_ray_generation: f64,
    /// Our cost of a further light, compared with the other's shadow pass.
    pub(super) further_light: f64,
}

impl Outcome {
    /// Ratios of Embree's fastest build method, by the median frame.
    pub(super) fn ratios(&self) -> Ratios {
        let best = self.embree.iter().map(|embree| embree.best_frame).fold(f64::INFINITY, f64::min);
        Ratios { best: best / self.grids.best_frame, ..self.ratios_of(&self.embree[0]) }
    }

    /// Ratio of tinybvh's fastest layout, if it takes part.
    pub(super) fn tinybvh_ratio(&self) -> Option<f64> {
        self.tinybvh.first().map(|(tinybvh, _)| self.ratios_of(tinybvh).frame)
    }

    fn ratios_of(&self, peer: &Summary) -> Ratios {
        let Self { grids, ray_generation, .. } = self;
        Ratios {
            frame: peer.frame / grids.frame,
            best: peer.best_frame / grids.best_frame,
            without_ray_generation: (peer.frame - ray_generation.frame) / grids.frame,
            further_light: grids.shadow / peer.shadow,
        }
    }

    /// A row for each side. `before` has the same scene's frames with fewer lights, if there are any.
    pub(super) fn rows(&self, before: Option<&Self>) -> impl Iterator<Item = Row> {
        let grids = [(&self.grids, None, Some(self.differences))];
        let embree = self.embree.iter().map(|side| (side, Some(self.ratios_of(side)), None));
        let tinybvh = self.tinybvh.iter().map(|(side, differ)| (side, Some(self.ratios_of(side)), Some(*differ)));
        let others = [&self.ray_generation].into_iter().chain(&self.hierarchy).map(|side| (side, None, None));
        let sides = grids.into_iter().chain(embree).chain(tinybvh).chain(others);
        sides.map(move |(side, ratios, differences)| self.row((side, before), ratios, differences))
    }

    fn sides(&self) -> impl Iterator<Item = &Summary> {
        let tinybvh = self.tinybvh.iter().map(|(side, _)| side);
        [&self.grids, &self.ray_generation].into_iter().chain(&self.embree).chain(tinybvh).chain(&self.hierarchy)
    }

    /// Milliseconds that each light beyond those of `before` has added to a side's frame.
    fn further_light(&self, side: &Summary, before: &Self) -> Option<f64> {
        let earlier = before.sides().find(|earlier| earlier.name == side.name)?;
        let lights = self.lights.checked_sub(before.lights).filter(|&lights| lights > 0)?;
        Some((side.frame - earlier.frame) / lights as f64)
    }

    fn row(
        &self,
        (side, before): (&Summary, Option<&Self>),
        ratios: Option<Ratios>,
        differences: Option<Differences>,
    ) -> Row {
        let per_light = before.and_then(|before| self.further_light(side, before));
        let scene = [Cell::from(self.scene.as_str()), self.triangles.into(), self.lights.into()];
        columns(scene, Some((side, per_light)), ratios, differences)
    }

    /// A row of the grids and Embree at its fastest.
    pub(super) fn brief_row(&self) -> Row {
        let Summary { build, see, survey, shadow, frame, .. } = self.grids;
        let grids = format!("{:.1} / {:.1} = {frame:.1}", build + see, survey + shadow);
        let Summary { build, see, shadow, frame, .. } = self.embree[0];
        let embree = format!("{build:.1} / {see:.1} / {shadow:.1} = {frame:.1}");
        brief_columns(self.scene.as_str().into(), Some((self.triangles, grids, embree)), self.ratios())
    }
}

impl Ratios {
    /// The geometric means; `None` of no scene.
    pub(super) fn mean(all: &[Self]) -> Option<Self> {
        let mean = |of: fn(&Self) -> f64| geometric_mean(all.iter().map(of));
        (!all.is_empty()).then(|| Self {
            frame: mean(|ratios| ratios.frame),
            best: mean(|ratios| ratios.best),
            without_ray_generation: mean(|ratios| ratios.without_ray_generation),
            further_light: mean(|ratios| ratios.further_light),
        })
    }

    /// The lowest ratios, and the highest cost of a further light.
    pub(super) fn worst(all: &[Self]) -> Option<Self> {
        all.iter().copied().reduce(|one, other| Self {
            frame: one.frame.min(other.frame),
            best: one.best.min(other.best),
            without_ray_generation: one.without_ray_generation.min(other.without_ray_generation),
            further_light: one.further_light.max(other.further_light),
        })
    }

    /// A row of ratios of many scenes.
    pub(super) fn row(self, name: String, lights: Lights) -> Row {
        columns([name.into(), Cell::Nothing, lights.to_string().into()], None, Some(self), None)
    }

    pub(super) fn brief_row(self, name: String) -> Row {
        brief_columns(name.into(), None, self)
    }
}

/// A row: the scene with its numbers of triangles and lights, a side's times and its cost of a further light, its ratios,
/// and how its picture differs.
fn columns(
    [scene, triangles, lights]: [Cell; 3],
    side: Option<(&Summary, Option<f64>)>,
    ratios: Option<Ratios>,
    differences: Option<Differences>,
) -> Row {
    let time = |of: fn(&Summary) -> f64| side.map(|(side, _)| of(side));
    let ratio = |of: fn(&Ratios) -> f64| ratios.as_ref().map(of);
    let count = |of: fn(&Differences) -> u64| differences.as_ref().map(of);
    row![
        ("scene", scene),
        ("triangles", triangles),
        ("lights", lights),
        ("side", side.map(|(side, _)| side.name)),
        ("build", time(|side| side.build)),
        ("see", time(|side| side.see)),
        ("survey", time(|side| side.survey)),
        ("shadow", time(|side| side.shadow)),
        ("frame", time(|side| side.frame)),
        ("best", time(|side| side.best_frame)),
        ("per_light", side.and_then(|(_, per_light)| per_light)),
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

/// A row of a scene, its number of triangles, the times of both sides in words, and their ratios.
fn brief_columns(scene: Cell, times: Option<(usize, String, String)>, ratios: Ratios) -> Row {
    let (triangles, grids, embree) = times.map_or((None, None, None), |(t, g, e)| (Some(t), Some(g), Some(e)));
    row![
        ("scene", scene),
        ("triangles", triangles),
        ("grids: build + see / shadow = frame", grids),
        ("Embree: build / see / shadow = frame", embree),
        ("ratio", Cell::Number(ratios.frame, 1)),
        ("a further light", ratios.further_light),
    ]
}

/// Build methods; each has a name for packets with rays of all samples that are traced together, and one for packets of
/// one sample.
const METHODS: [([&str; 2], BuildMethod); 4] = [
    (["Embree low, new", "Embree low, new, by sample"], BuildMethod { quality: Quality::Low, kept: false }),
    (["Embree low, kept", "Embree low, kept, by sample"], BuildMethod { quality: Quality::Low, kept: true }),
    (["Embree med, new", "Embree med, new, by sample"], BuildMethod { quality: Quality::Medium, kept: false }),
    (["Embree med, kept", "Embree med, kept, by sample"], BuildMethod { quality: Quality::Medium, kept: true }),
];

const LAYOUTS: [(&str, Layout); 2] = [("tinybvh, 2-wide", Layout::Binary), ("tinybvh, 8-wide", Layout::Wide)];

/// A side, with its times for each round of each frame.
struct Side<T> {
    name: &'static str,
    tracer: T,
    /// Times for each number of lights.
    times: Vec<Vec<Times>>,
}

impl<T> Side<T> {
    /// A side for `numbers` different numbers of lights.
    fn new(name: &'static str, tracer: T, numbers: usize) -> Self {
        Self { name, tracer, times: vec![Vec::new(); numbers] }
    }

    /// Traces a round, and keeps its times for the number of lights with index `counted`, if it counts.
    fn run(&mut self, counted: Option<usize>, trace: impl FnOnce(&mut T) -> Result<Times>) -> Result<()> {
        let times = trace(&mut self.tracer)?;
        if let Some(number) = counted {
            self.times[number].push(times);
        }
        Ok(())
    }

    fn summary(&self, number: usize, rounds: u32) -> Summary {
        let times = &self.times[number];
        let of = |stage: fn(&Times) -> f64| median(times.iter().map(stage));
        let best = |rounds: &[Times]| rounds.iter().map(Times::frame).fold(f64::INFINITY, f64::min);
        Summary {
            name: self.name,
            build: of(|times| times.build),
            see: of(|times| times.see),
            survey: of(|times| times.survey),
            shadow: of(|times| times.shadow),
            frame: of(Times::frame),
            best_frame: median(times.chunks(rounds as usize).map(best)),
        }
    }
}

/// Traces a scene's frames by all sides, in turn with each number of lights; returns an outcome for each number.
pub(super) fn hold(
    address: &str,
    scene: &Scene,
    flags: &PeersFlags,
    Libraries { embree, tinybvh }: &Libraries,
) -> Result<Vec<Outcome>> {
    let numbers = flags.lights.len();
    let mut frame = Frame::default();
    let mut grids = Side::new("grids", flags.our_side()?, numbers);
    let are_together = Samples::all(flags.samples, true).any(|samples| samples.side() > 1);
    let mut sides = Vec::new();
    for by_sample in [false, true].into_iter().filter(|by_sample| are_together || !by_sample) {
        sides.extend(METHODS.map(|(names, method)| {
            Side::new(names[usize::from(by_sample)], EmbreeSide::new(embree, method, by_sample), numbers)
        }));
    }
    let layouts =
        tinybvh.iter().flat_map(|library| LAYOUTS.map(|(name, layout)| (name, TinySide::new(library, layout))));
    let mut tiny_sides: Vec<_> = layouts.map(|(name, side)| Side::new(name, side, numbers)).collect();
    let mut rays_only = Side::new("rays only", Image::default(), numbers);
    let mut hierarchy = flags.bvh.then(|| Side::new("bvh", Ours::new(Box::<Bvh>::default()), numbers));
    let mut differences = vec![Differences::default(); numbers];
    let mut tiny_differences = vec![vec![Differences::default(); numbers]; tiny_sides.len()];
    let mut lights = vec![0; numbers];
    // Kept until every side has taken the next one, so that no side's time includes its release.
    let mut last_posed = None;
    for number in 0..flags.frames {
        let seconds = scene.duration_seconds() * f64::from(number) / f64::from(flags.frames);
        scene.pose(seconds, &mut frame)?;
        let posed = Arc::new(Posed::new(&frame, flags.masks)?);
        // A scene's first round takes memory that later ones use again: it doesn't count.
        let uncounted = u32::from(number == 0);
        for (round, (index, &of)) in (0..flags.rounds + uncounted)
            .flat_map(|round| flags.lights.iter().enumerate().map(move |lights| (round, lights)))
        {
            let shot = Shot { masks: flags.masks, ..Shot::new(&frame, address, flags.size, flags.samples, of) };
            lights[index] = shot.lights.len();
            let counted = (round >= uncounted).then_some(index);
            grids.run(counted, |grids| grids.trace(&shot))?;
            sides.iter_mut().try_for_each(|side| side.run(counted, |embree| embree.trace(&shot, &posed)))?;
            tiny_sides.iter_mut().try_for_each(|side| side.run(counted, |tiny| tiny.trace(&shot, &posed)))?;
            rays_only.run(counted, |image| Ok(make_rays(image, &shot, &sides[0].tracer.image)))?;
            hierarchy.iter_mut().try_for_each(|bvh| bvh.run(counted, |bvh| bvh.trace(&shot)))?;
            if round + 1 == flags.rounds + uncounted {
                differences[index].add(&shot, &grids.tracer, (&sides[0].tracer.image, &posed));
                for (side, differences) in tiny_sides.iter().zip(&mut tiny_differences) {
                    differences[index].add(&shot, &grids.tracer, (&side.tracer.image, &posed));
                }
            }
        }
        last_posed = Some(posed);
    }
    drop(last_posed);
    let outcome = |index: usize| {
        let mut embree: Vec<_> = sides.iter().map(|side| side.summary(index, flags.rounds)).collect();
        embree.sort_by(|a, b| a.frame.total_cmp(&b.frame));
        let tinybvh = tiny_sides.iter().zip(&tiny_differences);
        let tinybvh = tinybvh.map(|(side, differences)| (side.summary(index, flags.rounds), differences[index]));
        let mut tinybvh: Vec<_> = tinybvh.collect();
        tinybvh.sort_by(|(a, _), (b, _)| a.frame.total_cmp(&b.frame));
        Outcome {
            scene: name(address).to_owned(),
            is_moving: scene.duration_seconds() > 0.0,
            triangles: frame.triangles().len(),
            lights: lights[index],
            grids: grids.summary(index, flags.rounds),
            embree,
            tinybvh,
            ray_generation: rays_only.summary(index, flags.rounds),
            hierarchy: hierarchy.as_ref().map(|side| side.summary(index, flags.rounds)),
            differences: differences[index],
        }
    };
    Ok((0..numbers).map(outcome).collect())
}

/// Numbers of pixels in which two pictures of the same frame differ, at the last sample and light.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Differences {
    /// Pixels of ours that show a triangle.
    pub(super) points: u64,
    /// Only one of the two shows a triangle.
    pub(super) hit_or_miss: u64,
    /// Both show a triangle, but not the same, at different distances.
    pub(super) triangle: u64,
    /// Both show a triangle, but not the same, at the same distance to about f32's last bits.
    pub(super) triangle_at_same_distance: u64,
    /// Both show the same triangle, lit in one only.
    pub(super) shadow: u64,
}

impl Differences {
    pub(super) fn add(&mut self, shot: &Shot<'_>, ours: &Ours, (theirs, posed): (&Image, &Posed)) {
        /// Maximum relative difference of equal distances: eight roundings of f32.
        const SAME: f64 = 8.0 * f32::EPSILON as f64;
        let view = &shot.view;
        for y in 0..view.height {
            for x in 0..view.width {
                let (ray, [column, row]) = shot.last_ray(x, y);
                let (our, their) = (ours.pixel(column, row), theirs.seen(column, row));
                self.points += u64::from(our.is_some());
                match (our, their) {
                    (None, None) => {}
                    (Some(our), Some((name, t))) => {
                        if our.triangle == posed.triangle(name) {
                            self.shadow += u64::from(our.is_lit != theirs.is_lit(column, row));
                            continue;
                        }
                        let hit = predicate::hit(&ray, shot.frame.triangles(), our.triangle);
                        let is_tie = hit.is_some_and(|hit| (hit.t - f64::from(t)).abs() <= SAME * hit.t);
                        *(if is_tie { &mut self.triangle_at_same_distance } else { &mut self.triangle }) += 1;
                    }
                    _ => self.hit_or_miss += 1,
                }
            }
        }
    }
}
