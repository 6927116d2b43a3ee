use anyhow::Result;
use clap::Args;
use umbrage::rays::{Choice as _, Counts, KdMailbox, KdPacketOptions, KdTraversal};
use umbrage_study::shaft::{KdCulling, KdEntry, ShaftLead, ShaftOptions};

use super::measure::{Cost, KdFlags, Way, frame, race, tree};
use crate::rays::{hits_of, mirrored, of_camera};
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

impl KdEntriesFlags {
    pub(crate) fn run(&self) -> Result<()> {
        let mut table = self.common.start_without_chart()?;
        let all = forms();
        let packets = Some(KdPacketOptions::default());
        let of = |&options| Way { traversal: KdTraversal::Stack, packets, shafts: Some(options) };
        let ways: Vec<Way> = all.iter().map(of).collect();
        for address in &self.scenes {
            let frame = frame(address)?;
            let (triangles, mut tree) = (frame.triangles(), tree(&frame));
            let camera = of_camera(&Shot::new(&frame, address, self.common.size, 1, Lights::First));
            let mirrored = mirrored(triangles, &camera, &hits_of(&tree, triangles, &camera));
            for (kind, rays) in [("camera", &camera), ("mirror", &mirrored)] {
                let costs = race(&mut tree, triangles, rays, &ways, self.common.rounds)?;
                for (options, cost) in all.iter().zip(&costs) {
                    table.push(row(name(address), kind, options, cost, &costs[0]))?;
                }
            }
        }
        table.finish(&[
            "rays_us: rays a microsecond; ratio: over packets of 16 from the root. Thousands of nodes, of nodes on which",
            "packets looked for where to begin, of leaves, of triangles tested for up to 16 rays, and of triangles left",
            "out for all rays of a shaft (with the feature `statistics`).",
        ])?;
        Ok(())
    }
}

/// Packets of 16 and shafts with each entry; shafts with each culling, and each mailbox, from the root.
fn forms() -> Vec<ShaftOptions> {
    let of = |lead| move |entry| ShaftOptions { entry, lead, ..ShaftOptions::default() };
    let shaft = ShaftOptions::default();
    let entries = KdEntry::ALL.map(of(ShaftLead::Packets)).into_iter().chain(KdEntry::ALL.map(of(shaft.lead)));
    let leads = KdCulling::ALL.map(ShaftLead::Shaft).into_iter().filter(|&lead| lead != shaft.lead);
    let culled = leads.map(|lead| ShaftOptions { lead, ..shaft });
    let kept = KdMailbox::all().filter(move |&mailbox| mailbox != shaft.mailbox);
    entries.chain(culled).chain(kept.map(|mailbox| ShaftOptions { mailbox, ..shaft })).collect()
}

fn row(scene: &str, kind: &str, options: &ShaftOptions, cost: &Cost, first: &Cost) -> Row {
    let ShaftOptions { entry, lead, mailbox } = options;
    let (width, culling) = match lead {
        ShaftLead::Packets => ("Sixteen", String::new()),
        ShaftLead::Shaft(culling) => ("Shaft", format!("{culling:?}")),
    };
    let thousands = |of: fn(&Counts) -> u64| cost.visits.map(|visits| Cell::Number(of(&visits) as f64 / 1e3, 1));
    row![
        ("scene", scene),
        ("rays", kind),
        ("width", width),
        ("entry", format!("{entry:?}")),
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
