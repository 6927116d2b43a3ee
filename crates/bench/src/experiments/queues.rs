//! Distribution of work to threads: queues of earlier ray tracers beside rayon's stealing.

use std::time::Instant;

use anyhow::Result;
use clap::Args;
use rayon::prelude::*;
use umbrage::rays::{KdTree, KdTreeOptions, Ray, SingleRays as _, Triangles};
use umbrage_papers::queue::Queue;

use super::kd_tree::frame;
use crate::flags::ImageFlags;
use crate::grids::time;
use crate::measure::median;
use crate::rays::of_camera;
use crate::shot::{Lights, Shot, name};
use crate::table::{Cell, row};

#[derive(Args, Debug)]
pub(crate) struct QueuesFlags {
    /// Files, sequences or demo:NAME
    #[arg(default_values = ["demo:cloth", "demo:hall", "demo:statue"])]
    scenes: Vec<String>,
    /// Rays in a group of work
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_values_t = [16, 256, 4096])]
    rays: Vec<usize>,
    #[command(flatten)]
    common: ImageFlags,
}

/// Numbers of threads whose time is simulated from that of each group.
const SIMULATED: [usize; 2] = [16, 128];

impl QueuesFlags {
    pub(crate) fn run(&self) -> Result<()> {
        let mut table = self.common.start_without_chart()?;
        for address in &self.scenes {
            let frame = frame(address)?;
            let mut tree = KdTree::default();
            tree.set_options(KdTreeOptions::FAST)?;
            tree.build(frame.triangles());
            let rays = of_camera(&Shot::new(&frame, address, self.common.size, 1, Lights::First));
            for &of_group in &self.rays {
                let groups: Vec<&[Ray]> = rays.chunks(of_group.max(1)).collect();
                let mut spent = vec![Vec::new(); Queue::ALL.len()];
                for _ in 0..self.common.animation.frames {
                    for (queue, spent) in Queue::ALL.iter().zip(&mut spent) {
                        let mut milliseconds = 0.0;
                        let work = |group: usize| trace(&tree, frame.triangles(), groups[group]);
                        time(&mut milliseconds, || queue.for_each(groups.len(), work));
                        spent.push(milliseconds);
                    }
                }
                let mut row = row![("scene", name(address)), ("rays_a_group", of_group), ("groups", groups.len())];
                let titles = Queue::ALL.iter().map(|queue| queue.name().replace(' ', "_"));
                row.extend(titles.zip(&spent).map(|(title, spent)| (title, median(spent.iter().copied()).into())));
                row.extend(speedups(&costs(&tree, frame.triangles(), &groups)));
                table.push(row)?;
            }
        }
        table.finish(&[
            "Camera rays one at a time through a kd-tree, milliseconds. in_turn, one and decreasing: how many times as fast as one",
            "thread so many would be that have nothing else to do, by the time that each group takes: round robin, one group after",
            "the other (locked, swapped or stolen), and fewer at a time as they come to an end.",
        ])?;
        Ok(())
    }
}

fn trace(tree: &KdTree, triangles: Triangles<'_>, rays: &[Ray]) {
    for ray in rays {
        std::hint::black_box(tree.nearest(triangles, ray, &|_| true));
    }
}

/// Microseconds of each group: the least of three.
fn costs(tree: &KdTree, triangles: Triangles<'_>, groups: &[&[Ray]]) -> Vec<f64> {
    let once = |rays: &[Ray]| {
        let start = Instant::now();
        trace(tree, triangles, rays);
        1e6 * start.elapsed().as_secs_f64()
    };
    groups.par_iter().map(|rays| (0..3).map(|_| once(rays)).fold(f64::INFINITY, f64::min)).collect()
}

/// Speedups of many threads over one.
fn speedups(costs: &[f64]) -> Vec<(String, Cell)> {
    let all: f64 = costs.iter().sum();
    let kinds = [("in_turn", Queue::RoundRobin), ("one", Queue::Swapped), ("decreasing", Queue::Decreasing)];
    let of = |threads: usize| {
        kinds.map(|(kind, queue)| (format!("{kind}_{threads}"), Cell::Number(all / queue.simulated(costs, threads), 1)))
    };
    SIMULATED.into_iter().flat_map(of).collect()
}
