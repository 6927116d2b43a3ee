use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use anyhow::{Context, Result};
use clap::Args;
use umbrage::Scene;
use umbrage::rays::{
    BackgroundKdTree, HierarchyKdTree, KdMoved, KdTree, KdTreeOptions, Parts, Structure, Triangles, TwoLevelKdTree,
};
use umbrage::scene::{Frame, Mesh};
use umbrage_papers::clusters::{ClusterOptions, clusters};
use umbrage_peers::{BuildMethod, Embree, Posed, Quality};

use super::measure::KdFlags;
use crate::grids::{Ours, Times, time};
use crate::measure::median;
use crate::peers::EmbreeSide;
use crate::shot::{Lights, Shot, name};
use crate::table::{Cell, Row, row};

#[derive(Args, Debug)]
pub(crate) struct KdMovingFlags {
    /// Files, sequences or demo:NAME [default: some of the gallery's, and the real ones of --files]
    scenes: Vec<String>,
    /// Folder of the real scenes
    #[arg(long, value_name = "DIR")]
    files: Option<PathBuf>,
    /// Frames a second of the animation
    #[arg(long, value_name = "FPS", default_value = "24")]
    fps: f64,
    /// Poses that fuzzy trees are prepared for, spread over the animation
    #[arg(long, value_name = "N", default_value = "48", value_parser = clap::value_parser!(u32).range(1..=1000))]
    poses: u32,
    /// Embree's library; it is left out where there is none [default: the system's]
    #[arg(long, value_name = "PATH", env = "UMBRAGE_EMBREE")]
    embree: Option<PathBuf>,
    #[command(flatten)]
    common: KdFlags,
}

const WHOLE: &str = "whole, binned";
const BACKGROUND: &str = "background";

const GALLERY: [&str; 3] = ["demo:marbles", "demo:hall", "demo:gears"];
const FILES: [&str; 5] =
    ["vintage_fan.glb", "robot_arm.glb", "robot_expressive.glb", "cesium_man.glb", "elephant_gallop.glb"];

/// Maximum number of triangles for finding clusters.
const MOST_CLUSTERED: usize = 100_000;
const CLUSTERS: ClusterOptions = ClusterOptions { most: 16, rounds: 4, residual: 1.0 / 256.0 };

impl KdMovingFlags {
    pub(crate) fn run(&self) -> Result<()> {
        let mut table = self.common.start_without_chart()?;
        let embree = Embree::load(self.embree.as_deref(), rayon::current_num_threads());
        if let Err(error) = &embree {
            table.note(&format!("Embree is left out: {error}"))?;
        }
        for address in self.addresses() {
            let scene = umbrage::open(&address).with_context(|| format!("scene {address}"))?;
            let trials = self.trials(&scene, &address, embree.as_ref().ok())?;
            let first = median(trials[0].times.iter().map(Times::frame));
            let triangles = scene.at(0.0)?.triangles().len();
            trials.iter().try_for_each(|trial| table.push(trial.row(name(&address), triangles, first)))?;
        }
        table.finish(&[
            "Frames in turn of each animation, with one light; medians in milliseconds. prepare: before the first frame, from",
            "poses over the whole animation; update: what is built or moved for a frame; ratio: of the whole tree's frame.",
            "parts: of the scene, or clusters. differ: pixels that show something else than through the whole tree, or are lit",
            "where it says that they aren't; Embree's answers are in f32. The background's next tree is ready for the next frame.",
        ])?;
        Ok(())
    }

    fn addresses(&self) -> Vec<String> {
        if !self.scenes.is_empty() {
            return self.scenes.clone();
        }
        let path = |folder: &PathBuf| FILES.map(|name| folder.join(name)).to_vec();
        let files = self.files.iter().flat_map(path).filter(|path| path.exists());
        let files = files.map(|path: PathBuf| Path::to_string_lossy(&path).into_owned());
        GALLERY.map(str::to_owned).into_iter().chain(files).collect()
    }

    fn trials(&self, scene: &Scene, address: &str, embree: Option<&Arc<Embree>>) -> Result<Vec<Trial>> {
        let mut frame = Frame::default();
        let poses: Result<Vec<_>, umbrage::scene::Error> = (0..self.poses)
            .map(|pose| {
                scene.pose(scene.duration_seconds() * f64::from(pose) / f64::from(self.poses), &mut frame)?;
                Ok(frame.positions.clone())
            })
            .collect();
        let poses = poses?;
        scene.pose(0.0, &mut frame)?;
        let mut trials = Trial::all(&frame, &poses, embree)?;
        for number in 0..=self.common.rounds {
            scene.pose((f64::from(number) / self.fps) % scene.duration_seconds().max(1e-9), &mut frame)?;
            let posed = embree.map(|_| Posed::new(&frame, false).map(Arc::new)).transpose()?;
            let mut whole_build = 0.0;
            for index in 0..trials.len() {
                let (before, trial) = trials.split_at_mut(index);
                let times = trial[0].run(&mut frame, (address, self.common.size), posed.as_ref(), number > 0)?;
                match trial[0].name {
                    WHOLE => whole_build = times.build,
                    // Its next tree, which is built in the background, mustn't slow down the others.
                    BACKGROUND => std::thread::sleep(Duration::from_secs_f64(3e-3 * whole_build)),
                    _ => {}
                }
                if let Some(whole) = before.first() {
                    trial[0].differ += trial[0].differences(whole, self.common.size);
                }
            }
        }
        Ok(trials)
    }
}

/// A side of the comparison.
enum Side {
    Ours(Box<Ours>),
    Embree(Box<EmbreeSide>, Option<Arc<Posed>>),
}

struct Trial {
    name: &'static str,
    /// Number of parts, of the scene or of clusters.
    parts: Option<usize>,
    side: Side,
    /// A mesh that replaces the frame's, if the parts aren't the scene's.
    mesh: Option<Arc<Mesh>>,
    prepare: Option<f64>,
    times: Vec<Times>,
    differ: usize,
}

fn count(numbers: &[u32]) -> usize {
    numbers.iter().max().map_or(1, |&last| last as usize + 1)
}

impl Trial {
    fn new(name: &'static str, structure: Box<dyn Structure>, parts: Option<usize>) -> Self {
        let side = Side::Ours(Box::new(Ours::new(structure)));
        Self { name, parts, side, mesh: None, prepare: None, times: Vec::new(), differ: 0 }
    }

    fn all(frame: &Frame, poses: &[Vec<glam::Vec3>], embree: Option<&Arc<Embree>>) -> Result<Vec<Self>> {
        let two_level = |moved| -> Result<Box<TwoLevelKdTree>> {
            let mut trees = Box::new(TwoLevelKdTree::new(moved));
            trees.set_options(KdTreeOptions::FAST)?;
            Ok(trees)
        };
        let (mut whole, mut hierarchy) = (Box::<KdTree>::default(), Box::<HierarchyKdTree>::default());
        whole.set_options(KdTreeOptions::FAST)?;
        hierarchy.set_options(KdTreeOptions::FAST)?;
        let mut background = Box::new(BackgroundKdTree::new(rayon::current_num_threads())?);
        background.set_options(KdTreeOptions::FAST)?;
        let mesh = &frame.mesh;
        let objects = if mesh.object_of_part.is_empty() { &mesh.part_of_triangle } else { &mesh.object_of_part };
        let (objects, parts) = (Some(count(objects)), Some(count(&mesh.part_of_triangle)));
        let mut trials = vec![
            Self::new(WHOLE, whole, None),
            Self::new("hierarchy", hierarchy, None),
            Self::new(BACKGROUND, background, None),
            Self::new("two-level", two_level(KdMoved::Transform)?, objects),
            Self::new("groups (gkDtree)", two_level(KdMoved::Rebuild)?, objects),
            Self::new("fuzzy, unprepared", two_level(KdMoved::Enclose)?, parts),
        ];
        let rest = Triangles { positions: &poses[0], ..frame.triangles() };
        let prepared = |name, parts: Parts<'_>| -> Result<Self> {
            let (mut trees, mut milliseconds) = (two_level(KdMoved::Enclose)?, 0.0);
            time(&mut milliseconds, || trees.prepare(rest, parts, poses));
            let parts = Some(count(parts.of_triangle));
            Ok(Self { prepare: Some(milliseconds), ..Self::new(name, trees, parts) })
        };
        trials.push(prepared("fuzzy, bones", frame.parts())?);
        if rest.len() <= MOST_CLUSTERED {
            let mut milliseconds = 0.0;
            let some: Vec<_> = poses.iter().step_by(4).cloned().collect();
            let of_triangle = time(&mut milliseconds, || clusters(rest.indices, &some, CLUSTERS));
            let mut trial = prepared("fuzzy, clusters", Parts { of_triangle: &of_triangle, objects: &[] })?;
            trial.prepare = trial.prepare.map(|prepare| prepare + milliseconds);
            let (part_of_triangle, object_of_part) = (of_triangle, Vec::new());
            trial.mesh = Some(Arc::new(Mesh { part_of_triangle, object_of_part, ..(**mesh).clone() }));
            trials.push(trial);
        }
        trials.extend(embree.map(|embree| {
            let method = BuildMethod { quality: Quality::Refit, kept: true };
            let side = Side::Embree(Box::new(EmbreeSide::new(embree, method, false)), None);
            let name = "Embree, refit";
            Self { name, parts: None, side, mesh: None, prepare: None, times: Vec::new(), differ: 0 }
        }));
        Ok(trials)
    }

    fn run(
        &mut self,
        frame: &mut Frame,
        (address, size): (&str, [u32; 2]),
        posed: Option<&Arc<Posed>>,
        counts: bool,
    ) -> Result<Times> {
        let mesh = self.mesh.as_ref().map(|mesh| std::mem::replace(&mut frame.mesh, Arc::clone(mesh)));
        let shot = Shot::new(frame, address, size, 1, Lights::Count(1));
        let times = match (&mut self.side, posed) {
            (Side::Ours(ours), _) => ours.trace(&shot)?,
            (Side::Embree(embree, last), Some(posed)) => {
                *last = Some(Arc::clone(posed));
                embree.trace(&shot, posed)?
            }
            (Side::Embree(..), None) => Times::default(),
        };
        if let Some(mesh) = mesh {
            frame.mesh = mesh;
        }
        self.times.extend(counts.then_some(times));
        Ok(times)
    }

    /// Number of pixels with another triangle or another light than with `other`.
    fn differences(&self, other: &Self, [width, height]: [u32; 2]) -> usize {
        let Side::Ours(other) = &other.side else { return 0 };
        let differs = |x: u32, y: u32| {
            let expected = other.pixel(x, y);
            match &self.side {
                Side::Ours(ours) => ours.pixel(x, y) != expected,
                Side::Embree(embree, posed) => {
                    let seen = embree.image.seen(x, y).zip(posed.as_ref());
                    let seen = seen.map(|((triangle, _), posed)| posed.triangle(triangle));
                    let is_lit = embree.image.is_lit(x, y);
                    expected.is_none_or(|pixel| pixel.is_lit != is_lit) && expected.is_some()
                        || seen != expected.map(|pixel| pixel.triangle)
                }
            }
        };
        (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).filter(|&(x, y)| differs(x, y)).count()
    }

    fn row(&self, scene: &str, triangles: usize, first: f64) -> Row {
        let of = |stage: fn(&Times) -> f64| median(self.times.iter().map(stage));
        let frame = of(Times::frame);
        row![
            ("scene", scene),
            ("triangles", triangles),
            ("tree", self.name),
            ("parts", self.parts),
            ("prepare", self.prepare.map(|prepare| Cell::Number(prepare, 0))),
            ("update", Cell::Number(of(|times| times.build), 2)),
            ("see", Cell::Number(of(|times| times.see), 1)),
            ("shadow", Cell::Number(of(|times| times.survey + times.shadow), 1)),
            ("frame", Cell::Number(frame, 1)),
            ("ratio", Cell::Number(frame / first, 2)),
            ("differ", self.differ),
        ]
    }
}
