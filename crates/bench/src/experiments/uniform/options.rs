use anyhow::Result;
use clap::Args;
use umbrage_papers::{Insertion, PacketSide, UniformOptions};

use super::measure::{Costs, Way, measure};
use crate::flags::ImageFlags;
use crate::shot::name;
use crate::table::{Cell, Row, row};

#[derive(Args, Debug)]
pub(crate) struct GridOptionsFlags {
    /// Files, sequences or demo:NAME
    #[arg(default_values = ["demo:cloth", "demo:forest", "demo:hall", "demo:shatter", "demo:statue"])]
    scenes: Vec<String>,
    #[command(flatten)]
    common: ImageFlags,
}

/// Variants of the defaults: macrocells of another size, exact insertion, and packets of shadow rays that are split
/// sooner or later.
fn variants() -> Vec<(String, UniformOptions)> {
    let default = UniformOptions::DEFAULT;
    let macrocells = [1, 2, 3, 4, 8, 12].map(|macrocell| {
        let title = if macrocell == 1 { "no macrocells".to_owned() } else { format!("macrocells of {macrocell}³") };
        (title, UniformOptions { macrocell, ..default })
    });
    let exact = ("exact insertion".to_owned(), UniformOptions { insertion: Insertion::Exact, ..default });
    let spreads = [0.0125, 0.025, 0.1, 0.25, 1.0]
        .map(|shadow_spread| (format!("shadow spread {shadow_spread}"), UniformOptions { shadow_spread, ..default }));
    [("defaults".to_owned(), default)].into_iter().chain(macrocells).chain([exact]).chain(spreads).collect()
}

impl GridOptionsFlags {
    pub(crate) fn run(&self) -> Result<()> {
        let variants = variants();
        let eight = |options| (UniformOptions { packet: PacketSide::Eight, ..options }, Way::Packets);
        let ways = |&(_, options): &(String, UniformOptions)| [(options, Way::PacketsAndShadows), eight(options)];
        let forms: Vec<_> = variants.iter().flat_map(ways).collect();
        let mut table = self.common.start_without_chart()?;
        for address in &self.scenes {
            let costs = measure(address, self.common.size, &forms, &self.common.animation)?;
            for ((title, _), costs) in variants.iter().zip(costs.chunks_exact(2)) {
                table.push(row(name(address), title, costs))?;
            }
        }
        table.finish(&[
            "see, shadow: packets of 32x32 pixels. Defaults: macrocells of 6³, insertion by boxes, shadow spread 0.05.",
            "Wald et al. 2006, section 2.4: macrocells of 6³ give around 30 %. Section 3: exact insertion takes more than a",
            "third of the references away, and tests shrink by a few percent. Section 4.6: packets are split.",
        ])?;
        Ok(())
    }
}

fn row(name: &str, variant: &str, costs: &[Costs]) -> Row {
    let [large, eight] = [&costs[0], &costs[1]];
    row![
        ("scene", name),
        ("options", Cell::Text(variant.to_owned())),
        ("references", large.references),
        ("build", large.build),
        ("see", large.see),
        ("shadow", large.shadow),
        ("see_8x8", eight.see),
    ]
}
