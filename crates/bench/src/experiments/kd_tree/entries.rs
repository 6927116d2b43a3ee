use anyhow::{Result, ensure};
use clap::Args;
use umbrage::rays::{Choice as _, Counts};
use umbrage_papers::shaft::{KdCulling, KdEntry, ShaftLead, ShaftOptions};
use umbrage_papers::{KdMailbox, KdPacketOptions, KdTraversal, KdTree, KdTreeOptions, SahCosts};

use super::measure::{Cost, Grouping, KdFlags, Way, frame, race};
use crate::rays::{hits_of, mirrored, of_camera_by_tiles};
use crate::shot::{Lights, Shot, name};
use crate::table::{Cell, Row, row};

#[derive(Args, Debug)]
pub(crate) struct KdEntriesFlags {
    /// Files, sequences or demo:NAME
    #[arg(default_values = ["demo:cloth", "demo:hall", "demo:statue"])]
    scenes: Vec<String>,
    #[command(flatten)]
    common: KdFlags,
}

/// Side of a tile in pixels.
const TILE: u32 = 128;

impl KdEntriesFlags {
    pub(crate) fn run(&self) -> Result<()> {
        let size = self.common.size;
        ensure!(
            size.iter().all(|side| side.is_multiple_of(TILE)),
            "tiles have {TILE}x{TILE} pixels: --size must be a multiple of that"
        );
        let mut table = self.common.start_without_chart()?;
        for address in &self.scenes {
            let frame = frame(address)?;
            let triangles = frame.triangles();
            let camera = of_camera_by_tiles(&Shot::new(&frame, address, size, 1, Lights::First));
            for (kind, options) in [("fine", KdTreeOptions::DEFAULT), ("coarse", COARSE)] {
                let mut tree = KdTree::default();
                tree.set_options(options)?;
                tree.build(triangles);
                let counts = tree.counts();
                let of_leaf = counts.references as f64 / (counts.leaves - counts.empty_leaves).max(1) as f64;
                let mirrored = mirrored(triangles, &camera, &hits_of(&tree, triangles, &camera));
                for (source, rays) in [("camera", &camera), ("mirror", &mirrored)] {
                    let ways: Vec<Way> = forms(source == "camera").collect();
                    let costs = race(&mut tree, triangles, rays, &ways, self.common.rounds)?;
                    for (way, cost) in ways.iter().zip(&costs) {
                        table.push(row([name(address), source, kind], of_leaf, way, cost, &costs[0]))?;
                    }
                }
            }
        }
        table.finish(&[
            "tree: coarse ends where leaves have hundreds of triangles (of_leaf: on average); Reshetov 2007 has such, and a tenth",
            "of the nodes. entry: where 256 rays begin; tiles: where tiles of 128x128 pixels begin, split 16 ways and again by four",
            "(Reshetov et al. 2005). rays_us: rays a microsecond; ratio: over packets of 16 from the same tree's root. Thousands of",
            "nodes, of nodes on which packets looked for where to begin, of leaves, of triangles tested for up to 16 rays, and of",
            "triangles left out for all rays of a shaft (with the feature `statistics`).",
        ])?;
        Ok(())
    }
}

/// A tree with leaves of hundreds of triangles.
const COARSE: KdTreeOptions = KdTreeOptions {
    costs: SahCosts { step: 500.0, failures: 0, ..KdTreeOptions::DEFAULT.costs },
    ..KdTreeOptions::DEFAULT
};

/// Packets of 16 and shafts with each entry, also of whole tiles; shafts with each culling, and each mailbox, from the root.
fn forms(has_tiles: bool) -> impl Iterator<Item = Way> {
    let shaft = ShaftOptions::default();
    let leads = [ShaftLead::Packets, shaft.lead];
    let entries = leads.into_iter().flat_map(move |lead| {
        let of_packets = KdEntry::ALL.map(|entry| (entry, Grouping::Neighbours));
        let of_tiles = KdEntry::ALL.into_iter().filter(move |&entry| has_tiles && entry != KdEntry::Root);
        let all = of_packets.into_iter().chain(of_tiles.map(|entry| (entry, Grouping::Tiles)));
        all.map(move |(entry, grouping)| (ShaftOptions { entry, lead, ..shaft }, grouping))
    });
    let culled = KdCulling::ALL.map(ShaftLead::Shaft).into_iter().filter(move |&lead| lead != shaft.lead);
    let culled = culled.map(move |lead| (ShaftOptions { lead, ..shaft }, Grouping::Neighbours));
    let kept = KdMailbox::all().filter(move |&mailbox| mailbox != shaft.mailbox);
    let kept = kept.map(move |mailbox| (ShaftOptions { mailbox, ..shaft }, Grouping::Neighbours));
    let packets = Some(KdPacketOptions::default());
    entries.chain(culled).chain(kept).map(move |(shafts, grouping)| Way {
        traversal: KdTraversal::Stack,
        packets,
        shafts: Some(shafts),
        grouping,
    })
}

fn row([scene, kind, tree]: [&str; 3], of_leaf: f64, way: &Way, cost: &Cost, first: &Cost) -> Row {
    let ShaftOptions { entry, lead, mailbox } = way.shafts.unwrap_or_default();
    let (width, culling) = match lead {
        ShaftLead::Packets => ("Sixteen", String::new()),
        ShaftLead::Shaft(culling) => ("Shaft", format!("{culling:?}")),
    };
    let thousands = |of: fn(&Counts) -> u64| cost.visits.map(|visits| Cell::Number(of(&visits) as f64 / 1e3, 1));
    row![
        ("scene", scene),
        ("rays", kind),
        ("tree", tree),
        ("of_leaf", Cell::Number(of_leaf, 1)),
        ("width", width),
        ("entry", format!("{entry:?}")),
        ("begins", if way.grouping == Grouping::Tiles { "tile" } else { "packet" }),
        ("culling", culling),
        ("mailbox", format!("{mailbox:?}")),
        ("rays_us", Cell::Number(cost.rate, 3)),
        ("ratio", cost.rate / first.rate),
        ("nodes", thousands(|visits| visits.nodes)),
        ("searched", thousands(|visits| visits.searched)),
        ("leaves", thousands(|visits| visits.leaves)),
        ("tests", thousands(|visits| visits.tests)),
        ("culled", thousands(|visits| visits.frustum_culls)),
    ]
}
