use anyhow::{Result, bail};
use clap::Args;
use umbrage::rays::{Counts, PacketSide, UniformOptions};

use super::measure::{Way, measure};
use crate::flags::ImageFlags;
use crate::shot::name;
use crate::table::{Cell, Row, row};

#[derive(Args, Debug)]
pub(crate) struct CullingFlags {
    /// Files, sequences or demo:NAME
    #[arg(default_values = ["demo:cloth", "demo:marbles", "demo:forest", "demo:hall", "demo:shatter", "demo:statue"])]
    scenes: Vec<String>,
    #[command(flatten)]
    common: ImageFlags,
}

impl CullingFlags {
    pub(crate) fn run(&self) -> Result<()> {
        if !cfg!(feature = "statistics") {
            bail!("this `umbrage-bench` counts nothing: build it with `--features statistics`");
        }
        let packets = [PacketSide::Four, PacketSide::Eight, PacketSide::ThirtyTwo];
        let forms = packets.map(|packet| (UniformOptions { packet, ..UniformOptions::DEFAULT }, Way::Packets));
        let mut table = self.common.start_without_chart()?;
        for address in &self.scenes {
            for (packet, costs) in
                packets.iter().zip(measure(address, self.common.size, &forms, &self.common.animation)?)
            {
                table.push(row(name(address), packet.pixels(), &costs.counts))?;
            }
        }
        table.finish(&[
            "Millions: pairs of a packet and a cell, and of a ray and a triangle that would be tested with neither",
            "mailbox nor culling, with the mailbox, with frustum culling too, and without what is behind all hits.",
            "ratio: neither by frustum. Wald et al. 2006, Table 1: 8.5 (ben), 13.4 (hand), 14.0 (toys), 13.9 (conf).",
            "settled: pairs of a ray and a triangle that went to the exact predicate, not in millions.",
        ])?;
        Ok(())
    }
}

fn row(name: &str, side: u32, counts: &Counts) -> Row {
    let Counts { cells, mailbox_hits, frustum_culls, depth_culls, tests, settled, .. } = *counts;
    let rays = f64::from(side * side);
    let millions = |pairs: u64| pairs as f64 * rays / 1e6;
    let after_depth = tests;
    let after_frustum = after_depth + depth_culls;
    let after_mailbox = after_frustum + frustum_culls;
    let all = after_mailbox + mailbox_hits;
    row![
        ("scene", name),
        ("packet", side),
        ("cells", cells as f64 / 1e6),
        ("neither", millions(all)),
        ("mailbox", millions(after_mailbox)),
        ("frustum", millions(after_frustum)),
        ("depth", millions(after_depth)),
        ("ratio", Cell::Number(all as f64 / after_frustum as f64, 1)),
        ("settled", settled),
    ]
}
