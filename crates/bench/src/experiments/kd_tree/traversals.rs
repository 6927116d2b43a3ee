use anyhow::Result;
use clap::Args;
use umbrage::rays::Counts;
use umbrage_papers::{KdPacketOptions, KdPacketWidth, KdTraversal};

use super::measure::{Cost, Grouping, KdFlags, Way, frame, race, tree};
use crate::plot::{LineChart, Scale, Series};
use crate::rays::{hits_of, mirrored, of_camera, scattered, to_light};
use crate::shot::{Lights, Shot, name};
use crate::table::{Cell, Row, row};

#[derive(Args, Debug)]
pub(crate) struct KdTraversalsFlags {
    /// Files, sequences or demo:NAME
    #[arg(default_values = ["demo:cloth", "demo:hall", "demo:statue"])]
    scenes: Vec<String>,
    #[command(flatten)]
    common: KdFlags,
}

const TRAVERSALS: [KdTraversal; 7] = [
    KdTraversal::Stack,
    KdTraversal::Restart,
    KdTraversal::PushDown,
    KdTraversal::ShortStack(2),
    KdTraversal::ShortStack(3),
    KdTraversal::ShortStack(4),
    KdTraversal::ShortStack(8),
];

impl KdTraversalsFlags {
    pub(crate) fn run(&self) -> Result<()> {
        let mut table = self.common.start()?;
        let mut series = Vec::new();
        for address in &self.scenes {
            let frame = frame(address)?;
            let (triangles, mut tree) = (frame.triangles(), tree(&frame));
            let shot = Shot::new(&frame, address, self.common.size, 1, Lights::First);
            let camera = of_camera(&shot);
            let hits = hits_of(&tree, triangles, &camera);
            let shadow = to_light(triangles, &camera, &hits, shot.lights.first());
            let (mirrored, scattered) = (mirrored(triangles, &camera, &hits), scattered(triangles, &camera, &hits));
            let kinds = [("camera", &camera), ("shadow", &shadow), ("mirror", &mirrored), ("diffuse", &scattered)];
            for (kind, rays) in kinds {
                for (width, packets) in widths() {
                    let neighbours = Grouping::Neighbours;
                    let mut ways: Vec<Way> = TRAVERSALS
                        .map(|traversal| Way { traversal, packets, shafts: None, grouping: neighbours })
                        .into();
                    if packets.is_some() {
                        ways.push(Way { grouping: Grouping::Signs, ..ways[0] });
                    }
                    let costs = race(&mut tree, triangles, rays, &ways, self.common.rounds)?;
                    for (at, (way, cost)) in ways.iter().zip(&costs).enumerate() {
                        let row = row([name(address), kind, width], way, cost, &costs[0], rays.len());
                        table.push(row)?;
                        if packets.is_none() {
                            Series::add(&mut series, &format!("{} {kind}", name(address)), [at as f64, cost.rate]);
                        }
                    }
                }
            }
        }
        let notes = [
            "rays_us: rays a microsecond; of_stack: that over the full stack's. nodes, leaves, tests: for each ray, of",
            "packets for each of their rays' packet (with the feature `statistics`); node_ratio: over the full stack's.",
            "together: neighbours, whichever way they run (omnidirectional), or those that run towards the same sides, as packets",
            "of one near child need it. Shadow rays ask for the nearest hit, as in the paper. Horn et al. 2007, §4 and §5.1.1: packets of four with a stack",
            "of three entries visit less than 3 % more nodes than with a full one.",
        ];
        let x_title = "full stack, restart, push-down, short stacks of 2, 3, 4 and 8";
        let (y_title, scales) = ("rays a microsecond", [Scale::Linear, Scale::Logarithmic]);
        let chart = LineChart { title: "Traversals, one ray at a time", x_title, y_title, scales, series };
        self.common.output.finish(table, &notes, &chart)
    }
}

/// One ray at a time, and packets.
fn widths() -> [(&'static str, Option<KdPacketOptions>); 4] {
    let of = |width| Some(KdPacketOptions { width, ..KdPacketOptions::default() });
    [("1", None), ("4", of(KdPacketWidth::Four)), ("8", of(KdPacketWidth::Eight)), ("16", of(KdPacketWidth::Sixteen))]
}

fn row([scene, kind, width]: [&str; 3], way: &Way, cost: &Cost, stack: &Cost, rays: usize) -> Row {
    let packets = rays as f64 / width.parse::<f64>().unwrap_or(1.0);
    let each = |number: u64| Cell::Number(number as f64 / packets, 1);
    let of_ray = |pick: fn(&Counts) -> u64| cost.visits.map(|visits| each(pick(&visits)));
    let ratio = cost.visits.zip(stack.visits).map(|(own, full)| own.nodes as f64 / full.nodes.max(1) as f64);
    row![
        ("scene", scene),
        ("rays", kind),
        ("traversal", way.traversal.to_string()),
        ("together", if way.grouping == Grouping::Signs { "by signs" } else { "neighbours" }),
        ("width", width),
        ("rays_us", Cell::Number(cost.rate, 3)),
        ("of_stack", cost.rate / stack.rate),
        ("nodes", of_ray(|visits| visits.nodes)),
        ("leaves", of_ray(|visits| visits.leaves)),
        ("tests", of_ray(|visits| visits.tests)),
        ("node_ratio", ratio.map(|ratio| Cell::Number(ratio, 3))),
    ]
}
