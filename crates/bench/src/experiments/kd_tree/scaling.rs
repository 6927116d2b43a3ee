use anyhow::{Context, Result};
use clap::Args;
use rayon::ThreadPoolBuilder;
use umbrage::rays::{Choice as _, KdBuilder, KdTree, KdTreeOptions};
use umbrage_papers::kd_tasks::tasks;

use super::measure::{KdFlags, frame};
use crate::grids::time;
use crate::measure::median;
use crate::plot::{LineChart, Scale, Series};
use crate::shot::{name, short_name};
use crate::table::{Cell, Row, row};

#[derive(Args, Debug)]
pub(crate) struct KdScalingFlags {
    /// Files, sequences or demo:NAME
    #[arg(default_values = ["demo:cloth", "demo:hall", "demo:statue?triangles=500000"])]
    scenes: Vec<String>,
    #[command(flatten)]
    common: KdFlags,
}

const BUILDERS: [KdBuilder; 4] = [KdBuilder::Presorted, KdBuilder::Nested, KdBuilder::InPlace, KdBuilder::Binned];

/// Numbers of threads whose time is simulated from counted work.
const SIMULATED: [usize; 5] = [1, 2, 4, 8, 16];

impl KdScalingFlags {
    pub(crate) fn run(&self) -> Result<()> {
        let mut table = self.common.start()?;
        let mut series = Vec::new();
        for address in &self.scenes {
            let frame = frame(address)?;
            let triangles = frame.triangles();
            let alone = ThreadPoolBuilder::new().num_threads(1).build().context("a thread")?;
            for builder in BUILDERS {
                let mut tree = KdTree::default();
                tree.set_options(KdTreeOptions { builder, ..KdTreeOptions::DEFAULT })?;
                let mut times = [Vec::new(), Vec::new()];
                for round in 0..=self.common.rounds {
                    let mut spent = [0.0; 2];
                    time(&mut spent[0], || alone.install(|| tree.build(triangles)));
                    time(&mut spent[1], || tree.build(triangles));
                    if round > 0 {
                        times.iter_mut().zip(spent).for_each(|(times, spent)| times.push(spent));
                    }
                }
                let [build_alone, build] = times.map(median);
                let mut row: Row = row![
                    ("scene", name(address)),
                    ("triangles", triangles.len()),
                    ("builder", builder.name()),
                    ("build_1", Cell::Number(build_alone, 1)),
                    ("build", Cell::Number(build, 1)),
                    ("measured", Cell::Number(build_alone / build, 2)),
                ];
                let tasks = tasks(&tree, builder);
                let line = format!("{} {builder}", short_name(address));
                for threads in SIMULATED {
                    let speedup = tasks.total() as f64 / tasks.simulated(threads).max(1) as f64;
                    Series::add(&mut series, &line, [threads as f64, speedup]);
                    if threads > 1 {
                        row.push((format!("simulated_{threads}"), Cell::Number(speedup, 2)));
                    }
                }
                table.push(row)?;
            }
        }
        let notes = [
            "build_1, build: milliseconds with one thread and with all; measured: one by the other. simulated: how many times as",
            "fast as one thread so many would be by counted work: a node's pass counts as its references, cut into tasks as the",
            "builder does, and a thread that is done takes the task that has waited longest. Memory, caches, handing out tasks,",
            "the first sorting and the layout aren't counted. Choi et al. 2010: 7 to 8 times on 20 to 24 cores.",
        ];
        let (x_title, y_title) = ("threads, simulated", "times as fast as one");
        let scales = [Scale::Doubling, Scale::Doubling];
        let chart = LineChart { title: "Builds on more threads", x_title, y_title, scales, series };
        self.common.output.finish(table, &notes, &chart)
    }
}
