use anyhow::Result;
use clap::Args;
use umbrage_papers::{PacketSide, UniformOptions};

use super::measure::{Costs, Way, measure};
use crate::flags::ImageFlags;
use crate::plot::{LineChart, Scale, Series};
use crate::shot::name;
use crate::table::{Cell, Row, row};

#[derive(Args, Debug)]
pub(crate) struct PacketsFlags {
    /// Files, sequences or demo:NAME
    #[arg(default_values = SCENES)]
    scenes: Vec<String>,
    #[command(flatten)]
    common: ImageFlags,
}

/// Scenes of the gallery, and one of growing detail instead of the paper's Armadillo.
const SCENES: [&str; 10] = [
    "demo:cloth",
    "demo:marbles",
    "demo:forest",
    "demo:hall",
    "demo:shatter",
    "demo:statue?triangles=10000",
    "demo:statue?triangles=30000",
    "demo:statue?triangles=100000",
    "demo:statue?triangles=300000",
    "demo:statue?triangles=1000000",
];

impl PacketsFlags {
    pub(crate) fn run(&self) -> Result<()> {
        let packets =
            PacketSide::ALL.map(|packet| (UniformOptions { packet, ..UniformOptions::DEFAULT }, Way::Packets));
        let forms: Vec<_> = [(UniformOptions::DEFAULT, Way::Single)].into_iter().chain(packets).collect();
        let mut table = self.common.start()?;
        let mut series = Vec::new();
        for address in &self.scenes {
            let costs = measure(address, self.common.size, &forms, &self.common.animation)?;
            table.push(row(name(address), &costs))?;
            for (side, costs) in PacketSide::ALL.iter().zip(&costs[1..]) {
                Series::add(&mut series, &title(*side), [costs.triangles as f64, costs.see]);
            }
        }
        let notes = [
            "The camera's rays, one at a time from cell to cell, and in packets of so many pixels.",
            "references_us: references listed in cells a microsecond, in the build.",
            "Wald et al. 2006, Table 3: 8x8 packets are 6.75 (ben), 10.1 (hand), 13.1 (toys), 20.9 (erw6) and 10.6",
            "(conf) times as fast as single rays. Figure 7: 4x4 packets pass 8x8 ones at 250 K triangles.",
        ];
        series.iter_mut().for_each(|line: &mut Series| line.points.sort_by(|a, b| a[0].total_cmp(&b[0])));
        let (x_title, y_title) = ("triangles", "milliseconds to see");
        let chart = LineChart { title: "Sizes of packets", x_title, y_title, scales: [Scale::Logarithmic; 2], series };
        self.common.finish(table, &notes, &chart)
    }
}

/// Size of packets as text.
pub(super) fn title(side: PacketSide) -> String {
    let pixels = side.pixels();
    format!("{pixels}x{pixels}")
}

fn row(name: &str, costs: &[Costs]) -> Row {
    let single = &costs[0];
    let build = costs.iter().map(|costs| costs.build).fold(f64::INFINITY, f64::min);
    let best = costs[1..].iter().map(|costs| costs.see).fold(f64::INFINITY, f64::min);
    let mut row = row![
        ("scene", name),
        ("triangles", single.triangles),
        ("references", single.references),
        ("bytes_triangle", Cell::Number(single.bytes as f64 / single.triangles.max(1) as f64, 1)),
        ("build", build),
        ("references_us", Cell::Number(single.references as f64 / (1e3 * build), 1)),
        ("single", single.see),
    ];
    row.extend(PacketSide::ALL.iter().zip(&costs[1..]).map(|(side, costs)| (title(*side), costs.see.into())));
    let of_eight =
        PacketSide::ALL.iter().position(|&side| side == PacketSide::Eight).map_or(best, |at| costs[at + 1].see);
    row.extend(row![("ratio_8x8", single.see / of_eight), ("ratio_best", single.see / best)]);
    row
}
