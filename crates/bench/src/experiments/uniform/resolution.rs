use anyhow::Result;
use clap::Args;
use umbrage_papers::{PacketSide, UniformOptions};

use super::measure::{Way, measure};
use super::packets::title;
use crate::flags::AnimationFlags;
use crate::plot::{LineChart, Scale, Series};
use crate::shot::{name, short_name};
use crate::table::row;

#[derive(Args, Debug)]
pub(crate) struct ResolutionFlags {
    /// Files, sequences or demo:NAME
    #[arg(default_values = ["demo:cloth", "demo:forest", "demo:hall", "demo:statue"])]
    scenes: Vec<String>,
    /// Widths and heights of the image in pixels
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_values_t = [256, 512, 1024, 2048, 4096])]
    sides: Vec<u32>,
    #[command(flatten)]
    common: AnimationFlags,
}

/// The packet sizes that pay.
const PACKETS: [PacketSide; 3] = [PacketSide::Eight, PacketSide::Sixteen, PacketSide::ThirtyTwo];

impl ResolutionFlags {
    pub(crate) fn run(&self) -> Result<()> {
        let forms = PACKETS.map(|packet| (UniformOptions { packet, ..UniformOptions::DEFAULT }, Way::Packets));
        let mut table = self.common.output.start(&self.common.prepare(None)?)?;
        let mut series = Vec::new();
        for address in &self.scenes {
            let mut before = None;
            for &side in &self.sides {
                let costs = measure(address, [side, side], &forms, &self.common)?;
                let times: Vec<f64> = costs.iter().map(|costs| costs.see).collect();
                let best = times.iter().copied().fold(f64::INFINITY, f64::min);
                let pixels = f64::from(side) * f64::from(side);
                let mut row = row![("scene", name(address)), ("side", side)];
                row.extend(PACKETS.iter().zip(&times).map(|(&packet, &time)| (title(packet), time.into())));
                row.extend(row![
                    ("best", best),
                    ("ns_ray", 1e6 * best / pixels),
                    ("growth", before.map(|before: f64| best / before)),
                ]);
                table.push(row)?;
                before = Some(best);
                Series::add(&mut series, short_name(address), [pixels, best]);
            }
        }
        let notes = [
            "growth: the best time by that of the row above; 4 is linear in pixels where sides double.",
            "Wald et al. 2006, §4.2: from 1024x1024 to 2048x2048 the rate drops by a factor of 1.75 to 2.25.",
        ];
        let (x_title, y_title) = ("pixels", "milliseconds to see");
        let chart = LineChart { title: "Resolution", x_title, y_title, scales: [Scale::Logarithmic; 2], series };
        self.common.output.finish(table, &notes, &chart)
    }
}
