use anyhow::Result;
use clap::Args;
use umbrage_papers::{KdPacketOptions, KdTraversal};

use super::measure::{Grouping, KdFlags, Way, frame, race, tree};
use crate::plot::{LineChart, Scale, Series};
use crate::rays::{hits_of, mirrored, of_camera};
use crate::shot::{Lights, Shot, name, short_name};
use crate::table::{Cell, row};

#[derive(Args, Debug)]
pub(crate) struct KdBouncesFlags {
    /// Files, sequences or demo:NAME
    #[arg(default_values = ["demo:hall"])]
    scenes: Vec<String>,
    /// Bounces after the camera's rays
    #[arg(long, value_name = "N", default_value = "8", value_parser = clap::value_parser!(u32).range(1..=64))]
    bounces: u32,
    #[command(flatten)]
    common: KdFlags,
}

const TRAVERSALS: [KdTraversal; 4] =
    [KdTraversal::Stack, KdTraversal::Restart, KdTraversal::PushDown, KdTraversal::ShortStack(4)];

impl KdBouncesFlags {
    pub(crate) fn run(&self) -> Result<()> {
        let mut table = self.common.start()?;
        let mut series = Vec::new();
        let packets = Some(KdPacketOptions::default());
        let ways: Vec<Way> = TRAVERSALS
            .iter()
            .flat_map(|&traversal| {
                [None, packets].map(|packets| Way { traversal, packets, shafts: None, grouping: Grouping::Neighbours })
            })
            .collect();
        for address in &self.scenes {
            let frame = frame(address)?;
            let (triangles, mut tree) = (frame.triangles(), tree(&frame));
            let mut rays = of_camera(&Shot::new(&frame, address, self.common.size, 1, Lights::First));
            for bounce in 0..=self.bounces {
                if rays.is_empty() {
                    break;
                }
                let costs = race(&mut tree, triangles, &rays, &ways, self.common.rounds)?;
                for (traversal, pair) in TRAVERSALS.iter().zip(costs.chunks_exact(2)) {
                    let [single, packets] = [pair[0].rate, pair[1].rate];
                    table.push(row![
                        ("scene", name(address)),
                        ("bounce", bounce),
                        ("rays", rays.len()),
                        ("traversal", traversal.to_string()),
                        ("single", Cell::Number(single, 3)),
                        ("packets", Cell::Number(packets, 3)),
                        ("ratio", packets / single),
                    ])?;
                    for (kind, rate) in [("alone", single), ("by 16", packets)] {
                        let name = format!("{} {traversal} {kind}", short_name(address));
                        Series::add(&mut series, &name, [f64::from(bounce), rate]);
                    }
                }
                rays = mirrored(triangles, &rays, &hits_of(&tree, triangles, &rays));
            }
        }
        let notes = [
            "Every triangle a flat mirror; only rays that hit bounce. single, packets: rays a microsecond, one at a time",
            "and by 16. Horn et al. 2007, Figure 2: single rays pass packets of four after the first bounce.",
        ];
        let (x_title, y_title, scales) = ("bounce", "rays a microsecond", [Scale::Linear; 2]);
        let chart = LineChart { title: "Mirror bounces", x_title, y_title, scales, series };
        self.common.output.finish(table, &notes, &chart)
    }
}
