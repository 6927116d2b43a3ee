use anyhow::{Context, Result};
use clap::Args;
use rayon::prelude::*;
use umbrage::rays::{
    BackgroundKdTree, HierarchyKdTree, Hit, KdBuilder, KdTree, KdTreeOptions, Ray, SingleRays as _, Structure as _,
    Triangles,
};
use umbrage::scene::Frame;

use super::measure::KdFlags;
use crate::grids::time;
use crate::measure::median;
use crate::rays::{Hits, PACKET, of_camera};
use crate::shot::{Lights, Shot, name};
use crate::table::{Cell, Row, row};

#[derive(Args, Debug)]
pub(crate) struct KdFramesFlags {
    /// Files, sequences or demo:NAME
    #[arg(default_values = ["demo:cloth", "demo:marbles", "demo:shatter"])]
    scenes: Vec<String>,
    /// Frames a second of the animation
    #[arg(long, value_name = "FPS", default_value = "24")]
    fps: f64,
    /// How many times narrower the camera's view is than the scene's: rays then see little of it
    #[arg(long, value_name = "TIMES", default_value = "1", value_parser = times)]
    zoom: f32,
    #[command(flatten)]
    common: KdFlags,
}

fn times(text: &str) -> Result<f32, &'static str> {
    text.parse().ok().filter(|times: &f32| times.is_finite() && *times > 0.0).ok_or("a number above zero is needed")
}

impl KdFramesFlags {
    pub(crate) fn run(&self) -> Result<()> {
        let mut table = self.common.start_without_chart()?;
        for address in &self.scenes {
            let scene = umbrage::open(address).with_context(|| format!("scene {address}"))?;
            let mut frame = Frame::default();
            scene.pose(0.0, &mut frame)?;
            let mut trials = Trial::all(frame.triangles())?;
            for number in 0..=self.common.rounds {
                scene.pose((f64::from(number) / self.fps) % scene.duration_seconds().max(1e-9), &mut frame)?;
                let mut shot = Shot::new(&frame, address, self.common.size, 1, Lights::First);
                shot.narrow(self.zoom);
                let rays = of_camera(&shot);
                let mut expected: Option<Hits> = None;
                for trial in &mut trials {
                    let hits = trial.run(frame.triangles(), &rays, number > 0)?;
                    let expected = expected.get_or_insert_with(|| hits.clone());
                    trial.differ += hits.iter().zip(expected.iter()).filter(|(hit, expected)| hit != expected).count();
                }
            }
            let first = trials[0].milliseconds();
            for trial in &trials {
                table.push(trial.row(name(address), frame.triangles().len(), &first))?;
            }
        }
        table.finish(&[
            "Camera rays one at a time, frame after frame; medians in milliseconds. ratio: of the first one's frame. built:",
            "parts of the frames for which a tree was built, or of lazy trees' subtrees that rays reached; age: frames since",
            "the traced tree's own. differ: rays that hit something else than through the first tree.",
        ])?;
        Ok(())
    }
}

/// How a tree is rebuilt for each frame.
enum Rebuild {
    /// Anew.
    Anew(Box<KdTree>),
    /// From the hierarchy of the first frame's tree.
    From(Box<HierarchyKdTree>),
    /// On threads of its own.
    Beside(Box<BackgroundKdTree>),
}

struct Trial {
    name: &'static str,
    rebuild: Rebuild,
    /// Milliseconds to build, and to trace.
    times: Vec<[f64; 2]>,
    /// Fraction of the tree that was built, and its age, for each frame.
    built: Vec<f64>,
    ages: Vec<f64>,
    differ: usize,
}

impl Trial {
    fn all(triangles: Triangles<'_>) -> Result<Vec<Self>> {
        let tree = |options: KdTreeOptions| -> Result<Box<KdTree>> {
            let mut tree = Box::<KdTree>::default();
            tree.set_options(options)?;
            Ok(tree)
        };
        let exact = KdTreeOptions { builder: KdBuilder::Presorted, ..KdTreeOptions::FAST };
        let lazy = |options| KdTreeOptions { lazy_below: 1_000, ..options };
        let from = |options: KdTreeOptions| -> Result<Rebuild> {
            let mut tree = Box::<HierarchyKdTree>::default();
            tree.set_options(KdTreeOptions::DEFAULT)?;
            tree.build(triangles);
            tree.set_options(options)?;
            Ok(Rebuild::From(tree))
        };
        let mut beside = Box::new(BackgroundKdTree::new(0)?);
        beside.set_options(KdTreeOptions::FAST)?;
        let rebuilds = [
            ("binned", Rebuild::Anew(tree(KdTreeOptions::FAST)?)),
            ("binned, lazy", Rebuild::Anew(tree(lazy(KdTreeOptions::FAST))?)),
            ("presorted", Rebuild::Anew(tree(exact)?)),
            ("presorted, lazy", Rebuild::Anew(tree(lazy(exact))?)),
            ("from hierarchy", from(KdTreeOptions::FAST)?),
            ("hierarchy, lazy", from(lazy(KdTreeOptions::FAST))?),
            ("beside tracing", Rebuild::Beside(beside)),
        ];
        let trial =
            |(name, rebuild)| Self { name, rebuild, times: Vec::new(), built: Vec::new(), ages: Vec::new(), differ: 0 };
        Ok(rebuilds.map(trial).into())
    }

    fn run(&mut self, triangles: Triangles<'_>, rays: &[Ray], is_counted: bool) -> Result<Hits> {
        let mut spent = [0.0; 2];
        let age = time(&mut spent[0], || -> Result<_> {
            match &mut self.rebuild {
                Rebuild::Anew(tree) => tree.build(triangles),
                Rebuild::From(tree) => tree.build(triangles),
                Rebuild::Beside(trees) => return Ok(Some(trees.advance(triangles))),
            }
            Ok(None)
        })?;
        let hits = time(&mut spent[1], || match &self.rebuild {
            Rebuild::Anew(tree) => trace(rays, |ray| tree.nearest(triangles, ray, &|_| true)),
            Rebuild::From(tree) => trace(rays, |ray| tree.tree().nearest(triangles, ray, &|_| true)),
            Rebuild::Beside(trees) => trace(rays, |ray| trees.nearest(triangles, ray, &|_| true)),
        });
        if is_counted {
            self.times.push(spent);
            self.ages.push(age.map_or(0.0, |age| f64::from(age.frames)));
            self.built.push(match &self.rebuild {
                Rebuild::Anew(tree) => parts_built(tree),
                Rebuild::From(tree) => parts_built(tree.tree()),
                Rebuild::Beside(_) => f64::from(u8::from(age.is_some_and(|age| age.frames == 0))),
            });
        }
        Ok(hits)
    }

    /// Medians of the times to build, and to trace.
    fn milliseconds(&self) -> [f64; 2] {
        [0, 1].map(|stage| median(self.times.iter().map(|times| times[stage])))
    }

    fn row(&self, scene: &str, triangles: usize, first: &[f64; 2]) -> Row {
        let [build, trace] = self.milliseconds();
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
        row![
            ("scene", scene),
            ("triangles", triangles),
            ("rebuild", self.name),
            ("build", build),
            ("trace", trace),
            ("frame", build + trace),
            ("ratio", (build + trace) / first.iter().sum::<f64>()),
            ("built", mean(&self.built)),
            ("age", Cell::Number(mean(&self.ages), 1)),
            ("differ", self.differ),
        ]
    }
}

/// Fraction of a tree that was built.
fn parts_built(tree: &KdTree) -> f64 {
    let counts = tree.counts();
    if counts.deferred == 0 { 1.0 } else { counts.reached as f64 / counts.deferred as f64 }
}

fn trace(rays: &[Ray], nearest: impl Fn(&Ray) -> Option<Hit> + Sync + Send) -> Hits {
    rays.par_iter().with_min_len(PACKET).map(nearest).collect()
}
