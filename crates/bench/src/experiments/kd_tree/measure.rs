use std::hint::black_box;
use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::Args;
use rayon::prelude::*;
use umbrage::rays::{KdPacketOptions, KdTraversal, KdTree, KdTreeOptions, Ray, SingleRays as _, Triangles};
use umbrage::scene::Frame;
use umbrage_study::shaft::{ShaftOptions, ShaftVisits, nearest_of_shafts};

use crate::flags::{draw, size, use_threads};
use crate::grids::time;
use crate::median::median;
use crate::rays::{Hits, PACKET};
use crate::table::{Columns, Form, Table};

/// Flags of every experiment with kd-trees.
#[derive(Args, Debug)]
pub(crate) struct KdFlags {
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "512x512", value_parser = size)]
    pub(super) size: [u32; 2],
    /// How often everything is done, in turn; once more comes first and doesn't count
    #[arg(long, value_name = "N", default_value = "5", value_parser = clap::value_parser!(u32).range(1..))]
    pub(super) rounds: u32,
    /// Threads to work with [default: one for each core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// How the results are written
    #[arg(long, value_enum, default_value = "table")]
    form: Form,
    /// Draw them as well
    #[arg(long, value_name = "FILE.svg")]
    plot: Option<PathBuf>,
}

impl KdFlags {
    /// Has everything use as many threads as are asked for, and begins the table.
    pub(super) fn start(&self, columns: Columns) -> Result<Table> {
        use_threads(self.threads)?;
        Ok(Table::start(self.form, &self.conditions(), columns)?)
    }

    /// The same for what a device does, in milliseconds.
    pub(super) fn start_on(&self, device: &str, columns: Columns) -> Result<Table> {
        use_threads(self.threads)?;
        let conditions = format!("{device}, {}, milliseconds", self.conditions());
        Ok(Table::start(self.form, &conditions, columns)?)
    }

    /// How everything is measured, in one line.
    fn conditions(&self) -> String {
        let [width, height] = self.size;
        let (threads, rounds) = (rayon::current_num_threads(), self.rounds);
        format!("rays of {width}x{height} pixels, threads {threads}, medians of {rounds} rounds")
    }

    /// Writes the chart, if one is wanted.
    pub(super) fn draw(&self, svg: impl FnOnce() -> String) -> Result<()> {
        draw(self.plot.as_ref(), svg)
    }
}

/// A moment of the scene at `address`.
pub(super) fn frame(address: &str) -> Result<Frame> {
    let scene = umbrage::open(address).with_context(|| format!("scene {address}"))?;
    Ok(scene.at(0.4 * scene.duration_seconds())?)
}

/// A tree of an exact builder over a frame.
pub(super) fn tree(frame: &Frame) -> KdTree {
    let mut tree = KdTree::default();
    tree.build(frame.triangles());
    tree
}

/// How rays go through a tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Way {
    pub(super) traversal: KdTraversal,
    /// `None` for one ray at a time.
    pub(super) packets: Option<KdPacketOptions>,
    /// Shafts around packets, if there are any.
    pub(super) shafts: Option<ShaftOptions>,
}

/// What a way cost.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cost {
    /// Rays a microsecond.
    pub(super) rate: f64,
    /// Nodes visited for each ray or packet, leaves, and triangles tested: of one round; `None` where nothing is counted.
    pub(super) visits: Option<Visits>,
}

/// All of one round.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Visits {
    pub(super) nodes: u64,
    pub(super) leaves: u64,
    pub(super) tests: u64,
    /// Triangles that were left out for all rays of a packet.
    pub(super) culled: u64,
    /// Nodes on which packets looked for where to begin.
    pub(super) searched: u64,
}

impl Way {
    fn trace(self, tree: &mut KdTree, triangles: Triangles<'_>, rays: &[Ray], hits: &mut Hits) -> Result<Visits> {
        tree.set_options(KdTreeOptions { traversal: self.traversal, ..tree.options() })?;
        if let Some(options) = self.packets {
            tree.set_packet_options(options);
        }
        hits.resize(rays.len(), None);
        let tree = &*tree;
        let chunks = rays.par_chunks(PACKET).zip(hits.par_chunks_mut(PACKET));
        let visits = chunks.map(|(rays, hits)| match (self.packets, self.shafts) {
            (_, Some(options)) => nearest_of_shafts(tree, triangles, rays, options, |_| true, hits).into(),
            (Some(_), None) => {
                tree.nearest_of_packet(triangles, rays, |_| true, hits);
                Visits::default()
            }
            (None, None) => {
                let all = rays.iter().zip(hits);
                all.for_each(|(ray, hit)| *hit = tree.nearest(triangles, ray, &|_| true));
                Visits::default()
            }
        });
        Ok(visits.reduce(Visits::default, Visits::plus))
    }

    /// What the tree has counted besides those of shafts.
    fn visits(self, tree: &KdTree, of_shafts: Visits) -> Option<Visits> {
        let (alone, packets) = (tree.take_visits(), tree.take_packet_visits());
        let [nodes, leaves, tests] = match self.packets {
            None => [alone.nodes, alone.leaves, alone.tests],
            Some(_) => [packets.nodes, packets.leaves, packets.tests],
        };
        cfg!(feature = "statistics").then_some(of_shafts.plus(Visits { nodes, leaves, tests, ..Visits::default() }))
    }
}

impl Visits {
    fn plus(self, other: Self) -> Self {
        Self {
            nodes: self.nodes + other.nodes,
            leaves: self.leaves + other.leaves,
            tests: self.tests + other.tests,
            culled: self.culled + other.culled,
            searched: self.searched + other.searched,
        }
    }
}

impl From<ShaftVisits> for Visits {
    fn from(ShaftVisits { nodes, leaves, tests, culled, searched, .. }: ShaftVisits) -> Self {
        Self { nodes, leaves, tests, culled, searched }
    }
}

/// Traces the same rays each way, in turn.
pub(super) fn race(
    tree: &mut KdTree,
    triangles: Triangles<'_>,
    rays: &[Ray],
    ways: &[Way],
    rounds: u32,
) -> Result<Vec<Cost>> {
    let mut hits = Hits::new();
    let mut times = vec![Vec::new(); ways.len()];
    let mut visits = vec![None; ways.len()];
    for round in 0..=rounds {
        for (place, way) in ways.iter().enumerate() {
            let mut spent = 0.0;
            let of_shafts = time(&mut spent, || way.trace(tree, triangles, rays, &mut hits))?;
            black_box(&hits);
            visits[place] = way.visits(tree, of_shafts);
            if round > 0 {
                times[place].push(spent);
            }
        }
    }
    let costs = times.into_iter().zip(visits);
    Ok(costs.map(|(times, visits)| Cost { rate: rays.len() as f64 / (1e3 * median(times)), visits }).collect())
}
