use std::hint::black_box;

use anyhow::{Context, Result};
use clap::Args;
use rayon::prelude::*;
use umbrage::rays::{
    Counts, Hit, KdPacketOptions, KdTraversal, KdTree, KdTreeOptions, Ray, SingleRays as _, Triangles,
};
use umbrage::scene::Frame;
use umbrage_papers::shaft::{EntryPoint, ShaftOptions, nearest_of_shafts, nearest_of_shafts_below};

use crate::flags::{OutputFlags, size, use_threads};
use crate::grids::time;
use crate::measure::median;
use crate::rays::{Hits, PACKET, PACKET_CORNERS};
use crate::table::Table;

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
    #[command(flatten)]
    pub(super) output: OutputFlags,
}

impl KdFlags {
    /// Begins the table of a command that also draws, on the requested number of threads.
    pub(super) fn start(&self) -> Result<Table> {
        self.output.start(&self.prepare()?)
    }

    /// Begins the table of a command that draws nothing.
    pub(super) fn start_without_chart(&self) -> Result<Table> {
        self.output.start_without_chart(&self.prepare()?)
    }

    /// The same for times of a device, in milliseconds.
    pub(super) fn start_on(&self, device: &str) -> Result<Table> {
        self.output.start_without_chart(&format!("{device}, {}, milliseconds", self.prepare()?))
    }

    /// Starts the requested number of threads, and returns a line with the conditions of measurement.
    fn prepare(&self) -> Result<String> {
        use_threads(self.threads)?;
        let [width, height] = self.size;
        let (threads, rounds) = (rayon::current_num_threads(), self.rounds);
        Ok(format!("rays of {width}x{height} pixels, threads {threads}, medians of {rounds} rounds"))
    }
}

/// A moment of the scene at `address`.
pub(in crate::experiments) fn frame(address: &str) -> Result<Frame> {
    let scene = umbrage::open(address).with_context(|| format!("scene {address}"))?;
    Ok(scene.at(0.4 * scene.duration_seconds())?)
}

/// A tree of an exact builder over a frame.
pub(super) fn tree(frame: &Frame) -> KdTree {
    let mut tree = KdTree::default();
    tree.build(frame.triangles());
    tree
}

/// How rays traverse a tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Way {
    pub(super) traversal: KdTraversal,
    /// `None` for one ray at a time.
    pub(super) packets: Option<KdPacketOptions>,
    /// Shafts around packets, if there are any.
    pub(super) shafts: Option<ShaftOptions>,
    pub(super) grouping: Grouping,
}

/// How rays are grouped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Grouping {
    /// Neighbours.
    Neighbours,
    /// Neighbours that run towards the same sides along all axes, as packets must if the near child is the same for all
    /// (Wald et al. 2001).
    Signs,
    /// Neighbours that begin at the entry of their tile of [`TILE_PACKETS`], as shafts find it.
    Tiles,
}

/// Packets of a tile of 128×128 pixels, and of each of the 16 parts that it is split into.
const TILE_PACKETS: usize = 64;
const PART_PACKETS: usize = 4;

/// Cost of a way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cost {
    /// Rays a microsecond.
    pub(super) rate: f64,
    /// Counts of one round; `None` if nothing is counted.
    pub(super) visits: Option<Counts>,
}

impl Way {
    fn trace(self, tree: &mut KdTree, triangles: Triangles<'_>, rays: &[Ray], hits: &mut Hits) -> Result<Counts> {
        let packets = self.packets.unwrap_or_default();
        tree.set_options(KdTreeOptions { traversal: self.traversal, packets, ..tree.options() })?;
        hits.resize(rays.len(), None);
        let tree = &*tree;
        if let (Some(options), Grouping::Tiles) = (self.shafts, self.grouping) {
            let tiles =
                rays.par_chunks_exact(TILE_PACKETS * PACKET).zip(hits.par_chunks_exact_mut(TILE_PACKETS * PACKET));
            let visits = tiles.map(|(rays, hits)| trace_tile(tree, triangles, rays, options, hits));
            return Ok(visits.reduce(Counts::default, sum));
        }
        let chunks = rays.par_chunks(PACKET).zip(hits.par_chunks_mut(PACKET));
        let visits = chunks.map(|(rays, hits)| match (self.packets, self.shafts) {
            (_, Some(options)) => nearest_of_shafts(tree, triangles, rays, options, |_| true, hits),
            (Some(_), None) if self.grouping == Grouping::Signs => {
                trace_by_signs(tree, triangles, rays, hits);
                Counts::default()
            }
            (Some(_), None) => {
                tree.nearest_of_packet(triangles, rays, |_| true, hits);
                Counts::default()
            }
            (None, None) => {
                let all = rays.iter().zip(hits);
                all.for_each(|(ray, hit)| *hit = tree.nearest(triangles, ray, &|_| true));
                Counts::default()
            }
        });
        Ok(visits.reduce(Counts::default, sum))
    }
}

/// Traces a tile's rays from the tile's entry, each part's rays from the part's, and each packet's from its own
/// (Reshetov et al. 2005).
fn trace_tile(
    tree: &KdTree,
    triangles: Triangles<'_>,
    rays: &[Ray],
    options: ShaftOptions,
    hits: &mut [Option<Hit>],
) -> Counts {
    let mut visits = Counts::default();
    let root = EntryPoint::root(tree);
    hits.fill(None);
    // The first ray of the first packet, and so on.
    let corners = |rays: &[Ray], packets: [usize; 4]| -> [Ray; 4] {
        [0, 1, 2, 3].map(|corner| rays[packets[corner] * PACKET + PACKET_CORNERS[corner]])
    };
    let of_tile = [[0, 0], [3, 1], [12, 2], [15, 3]].map(|[part, packet]| part * PART_PACKETS + packet);
    let Some(entry) = root.of_tile(tree, triangles, &corners(rays, of_tile), options.entry, &mut visits) else {
        return visits;
    };
    let parts = rays.chunks_exact(PART_PACKETS * PACKET).zip(hits.chunks_exact_mut(PART_PACKETS * PACKET));
    for (rays, hits) in parts {
        let corners = corners(rays, [0, 1, 2, 3]);
        let Some(entry) = entry.of_tile(tree, triangles, &corners, options.entry, &mut visits) else { continue };
        for (rays, hits) in rays.chunks_exact(PACKET).zip(hits.chunks_exact_mut(PACKET)) {
            visits += nearest_of_shafts_below(&entry, tree, triangles, rays, options, |_| true, hits);
        }
    }
    visits
}

/// Traces rays that run towards the same sides together.
fn trace_by_signs(tree: &KdTree, triangles: Triangles<'_>, rays: &[Ray], hits: &mut [Option<Hit>]) {
    let mut alike: [(Vec<usize>, Vec<Ray>); 8] = Default::default();
    for (index, ray) in rays.iter().enumerate() {
        let signs = ray.direction.to_array().map(|component| usize::from(component.is_sign_negative()));
        let (indices, group) = &mut alike[signs[0] | signs[1] << 1 | signs[2] << 2];
        indices.push(index);
        group.push(*ray);
    }
    for (indices, group) in &alike {
        let mut found = vec![None; group.len()];
        tree.nearest_of_packet(triangles, group, |_| true, &mut found);
        for (&index, hit) in indices.iter().zip(found) {
            hits[index] = hit;
        }
    }
}

fn sum(mut counts: Counts, others: Counts) -> Counts {
    counts += others;
    counts
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
        for (index, way) in ways.iter().enumerate() {
            let mut spent = 0.0;
            let of_shafts = time(&mut spent, || way.trace(tree, triangles, rays, &mut hits))?;
            black_box(&hits);
            visits[index] = cfg!(feature = "statistics").then(|| sum(of_shafts, tree.take_visits()));
            if round > 0 {
                times[index].push(spent);
            }
        }
    }
    let costs = times.into_iter().zip(visits);
    Ok(costs.map(|(times, visits)| Cost { rate: rays.len() as f64 / (1e3 * median(times)), visits }).collect())
}
