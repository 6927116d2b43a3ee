use anyhow::{Context, Result};
use clap::Args;
use rayon::ThreadPoolBuilder;
use umbrage::rays::{Choice, KdBuilder, KdTraversal, KdTree, KdTreeOptions, Ray, Structure as _};
use umbrage::scene::Frame;

use super::measure::{Cost, Grouping, KdFlags, Way, frame, race};
use crate::grids::time;
use crate::measure::median;
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

/// Maximum number of triangles for the builder that takes N² time, and for the one that sorts at every node.
const MOST_FOR: [(KdBuilder, usize); 2] = [(KdBuilder::Naive, 3_000), (KdBuilder::Resorting, 200_000)];

impl KdBuildersFlags {
    pub(crate) fn run(&self) -> Result<()> {
        let mut table = self.common.start()?;
        let mut bars = Vec::new();
        for address in &self.scenes {
            let frame = frame(address)?;
            let trials = self.trials(&frame, address)?;
            let exact = trials.iter().find(|trial| trial.builder == KdBuilder::Presorted);
            for trial in &trials {
                let builder = ("builder", trial.builder.name());
                table.push(trial.row(name(address), frame.triangles().len(), builder, exact))?;
                let bar = format!("{} {}", short_name(address), trial.builder);
                bars.push(Bar { name: bar, heights: vec![trial.build] });
            }
        }
        let notes = [
            "build_1, build: milliseconds with one thread and with all; mtri_s: millions of triangles a second with all.",
            "sah_cost: what a ray is expected to cost; references and bytes for each triangle; camera_us, diffuse_us: rays",
            "a microsecond, one at a time, packets_us the camera's in packets; time_ratio: what both kinds of rays take alone,",
            "packet_ratio: what the camera's take in packets, over the exact builder's tree.",
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
        let rays = TrialRays::new(frame, address, self.common.size)?;
        let options = |builder| KdTreeOptions { builder, ..KdTreeOptions::DEFAULT };
        builders.into_iter().map(|builder| Trial::new(frame, options(builder), &rays, self.common.rounds)).collect()
    }
}

/// Camera rays, and one diffuse bounce of each that hits.
pub(super) struct TrialRays {
    pub(super) camera: Vec<Ray>,
    diffuse: Vec<Ray>,
}

impl TrialRays {
    pub(super) fn new(frame: &Frame, address: &str, size: [u32; 2]) -> Result<Self> {
        let triangles = frame.triangles();
        let camera = of_camera(&Shot::new(frame, address, size, 1, Lights::First));
        let mut first = KdTree::default();
        first.set_options(KdTreeOptions::FAST)?;
        first.build(triangles);
        let diffuse = scattered(triangles, &camera, &hits_of(&first, triangles, &camera));
        Ok(Self { camera, diffuse })
    }
}

/// Properties and costs of a tree.
pub(super) struct Trial {
    builder: KdBuilder,
    /// Milliseconds with one thread, and with all.
    build_alone: f64,
    build: f64,
    counts: umbrage::rays::KdTreeCounts,
    bytes: usize,
    /// Costs of the camera's rays and of scattered rays, one at a time, and of the camera's rays in packets.
    pub(super) costs: [Cost; 3],
}

impl Trial {
    pub(super) fn new(frame: &Frame, options: KdTreeOptions, rays: &TrialRays, rounds: u32) -> Result<Self> {
        let triangles = frame.triangles();
        let mut tree = KdTree::default();
        tree.set_options(options)?;
        let alone = ThreadPoolBuilder::new().num_threads(1).build().context("a thread")?;
        let mut times = [Vec::new(), Vec::new()];
        for round in 0..=rounds {
            let mut spent = [0.0; 2];
            time(&mut spent[0], || alone.install(|| tree.build(triangles)));
            time(&mut spent[1], || tree.build(triangles));
            if round > 0 {
                times.iter_mut().zip(spent).for_each(|(times, spent)| times.push(spent));
            }
        }
        let way = Way { traversal: KdTraversal::Stack, packets: None, shafts: None, grouping: Grouping::Neighbours };
        let in_packets = Way { packets: Some(options.packets), ..way };
        let mut cost = |rays: &[Ray], way| Ok(race(&mut tree, triangles, rays, &[way], rounds)?[0]);
        let costs: Result<_> =
            [cost(&rays.camera, way), cost(&rays.diffuse, way), cost(&rays.camera, in_packets)].into_iter().collect();
        let costs: Vec<Cost> = costs?;
        let [build_alone, build] = times.map(median);
        Ok(Self {
            builder: options.builder,
            build_alone,
            build,
            counts: tree.counts(),
            bytes: tree.bytes().triangles,
            costs: [costs[0], costs[1], costs[2]],
        })
    }

    /// Columns for `what` of a scene, and the costs of rays, relative to `first`.
    pub(super) fn row(&self, scene: &str, triangles: usize, what: (&'static str, &str), first: Option<&Self>) -> Row {
        let each = |number: f64| number / (triangles as f64).max(1.0);
        let seconds = |trial: &Self| trial.costs[..2].iter().map(|cost| 1.0 / cost.rate).sum::<f64>();
        let rate = |cost: &Cost| Cell::Number(cost.rate, 3);
        row![
            ("scene", scene),
            ("triangles", triangles),
            (what.0, what.1),
            ("build_1", Cell::Number(self.build_alone, 1)),
            ("build", Cell::Number(self.build, 1)),
            ("speedup", self.build_alone / self.build),
            ("mtri_s", triangles as f64 / (1e3 * self.build)),
            ("sah_cost", Cell::Number(self.counts.sah_cost, 1)),
            ("depth", self.counts.depth),
            ("references", each(self.counts.references as f64)),
            ("bytes", Cell::Number(each(self.bytes as f64), 0)),
            ("camera_us", rate(&self.costs[0])),
            ("diffuse_us", rate(&self.costs[1])),
            ("packets_us", rate(&self.costs[2])),
            ("time_ratio", first.map(|first| seconds(self) / seconds(first))),
            ("packet_ratio", first.map(|first| first.costs[2].rate / self.costs[2].rate)),
        ]
    }
}
