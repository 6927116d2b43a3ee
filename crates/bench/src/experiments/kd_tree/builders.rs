use anyhow::{Context, Result};
use clap::Args;
use rayon::ThreadPoolBuilder;
use umbrage::rays::{Choice, KdBuilder, KdTraversal, KdTree, KdTreeOptions, Ray, Structure as _};
use umbrage::scene::Frame;

use super::measure::{Cost, KdFlags, Way, frame, race};
use crate::grids::time;
use crate::median::median;
use crate::plot::{Bar, BarChart};
use crate::rays::{hits_of, of_camera, scattered};
use crate::shot::{Lights, Shot, name, short_name};
use crate::table::{Cell, Row, row};

#[derive(Args, Debug)]
pub(crate) struct KdBuildersFlags {
    /// Files, sequences or demo:NAME
    #[arg(default_values = ["demo:cloth", "demo:hall", "demo:statue?triangles=500000"])]
    scenes: Vec<String>,
    #[command(flatten)]
    common: KdFlags,
}

/// Scenes of more triangles go without the builder that takes N² time, and the one that sorts at every node.
const MOST_FOR: [(KdBuilder, usize); 2] = [(KdBuilder::Naive, 3_000), (KdBuilder::Resorting, 200_000)];

impl KdBuildersFlags {
    pub(crate) fn run(&self) -> Result<()> {
        let mut table = self.common.start()?;
        let mut bars = Vec::new();
        for address in &self.scenes {
            let frame = frame(address)?;
            let mut trials = self.trials(&frame, address)?;
            let exact = trials.iter().position(|trial| trial.builder == KdBuilder::Presorted);
            let exact = exact.map(|at| trials[at].costs);
            for trial in &mut trials {
                table.push(trial.row(name(address), frame.triangles().len(), exact.as_ref()))?;
                let bar = format!("{} {}", short_name(address), trial.builder);
                bars.push(Bar { name: bar, heights: vec![trial.build] });
            }
        }
        let notes = [
            "build_1, build: milliseconds with one thread and with all; mtri_s: millions of triangles a second with all.",
            "sah_cost: what a ray is expected to cost; references and bytes for each triangle; camera_us, diffuse_us: rays",
            "a microsecond, one at a time; time_ratio: what both kinds of rays take, over the exact builder's tree.",
            "The thesis (Rahikainen 2013, chapter 4): an exact O(N log N) build of the Bunny's 70 K triangles took 3.2 s.",
        ];
        let (title, parts) = ("Builders of kd-trees", vec!["all threads".to_owned()]);
        let chart = BarChart { title, y_title: "milliseconds to build", parts, bars };
        self.common.output.finish(table, &notes, &chart)
    }

    fn trials(&self, frame: &Frame, address: &str) -> Result<Vec<Trial>> {
        let triangles = frame.triangles();
        let is_for =
            |builder: &KdBuilder| MOST_FOR.iter().all(|(slow, most)| slow != builder || triangles.len() <= *most);
        let builders: Vec<KdBuilder> = KdBuilder::all().filter(is_for).collect();
        let camera = of_camera(&Shot::new(frame, address, self.common.size, 1, Lights::First));
        let mut first = KdTree::default();
        first.set_options(KdTreeOptions::FAST)?;
        first.build(triangles);
        let diffuse = scattered(triangles, &camera, &hits_of(&first, triangles, &camera));
        drop(first);
        builders.into_iter().map(|builder| self.trial(frame, builder, [&camera, &diffuse])).collect()
    }

    fn trial(&self, frame: &Frame, builder: KdBuilder, rays: [&[Ray]; 2]) -> Result<Trial> {
        let triangles = frame.triangles();
        let mut tree = KdTree::default();
        tree.set_options(KdTreeOptions { builder, ..KdTreeOptions::DEFAULT })?;
        let alone = ThreadPoolBuilder::new().num_threads(1).build().context("a thread")?;
        let mut times = [Vec::new(), Vec::new()];
        for round in 0..=self.common.rounds {
            let mut spent = [0.0; 2];
            time(&mut spent[0], || alone.install(|| tree.build(triangles)));
            time(&mut spent[1], || tree.build(triangles));
            if round > 0 {
                times.iter_mut().zip(spent).for_each(|(times, spent)| times.push(spent));
            }
        }
        let way = Way { traversal: KdTraversal::Stack, packets: None, shafts: None };
        let mut costs = Vec::new();
        for rays in rays {
            costs.extend(race(&mut tree, triangles, rays, &[way], self.common.rounds)?);
        }
        let [build_alone, build] = times.map(median);
        Ok(Trial {
            builder,
            build_alone,
            build,
            counts: tree.counts(),
            bytes: tree.bytes().triangles,
            costs: [costs[0], costs[1]],
        })
    }
}

struct Trial {
    builder: KdBuilder,
    /// Milliseconds.
    build_alone: f64,
    build: f64,
    counts: umbrage::rays::KdTreeCounts,
    bytes: usize,
    /// Of the camera's rays and of scattered ones.
    costs: [Cost; 2],
}

impl Trial {
    fn row(&self, scene: &str, triangles: usize, exact: Option<&[Cost; 2]>) -> Row {
        let each = |number: f64| number / (triangles as f64).max(1.0);
        let seconds = |costs: &[Cost; 2]| costs.iter().map(|cost| 1.0 / cost.rate).sum::<f64>();
        row![
            ("scene", scene),
            ("triangles", triangles),
            ("builder", self.builder.name()),
            ("build_1", Cell::Number(self.build_alone, 1)),
            ("build", Cell::Number(self.build, 1)),
            ("speedup", self.build_alone / self.build),
            ("mtri_s", triangles as f64 / (1e3 * self.build)),
            ("sah_cost", Cell::Number(self.counts.sah_cost, 1)),
            ("depth", self.counts.depth),
            ("references", each(self.counts.references as f64)),
            ("bytes", Cell::Number(each(self.bytes as f64), 0)),
            ("camera_us", Cell::Number(self.costs[0].rate, 3)),
            ("diffuse_us", Cell::Number(self.costs[1].rate, 3)),
            ("time_ratio", exact.map(|exact| seconds(&self.costs) / seconds(exact))),
        ]
    }
}
