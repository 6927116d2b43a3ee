//! The camera's cells of many triangles in blocks, which the paper leaves to future work (§5).

use std::num::NonZeroU32;

use anyhow::Result;
use clap::Args;
use umbrage_papers::ListedOptions;

use crate::flags::AnimationFlags;
use crate::measure::measure;
use crate::shot::name;
use crate::table::row;

#[derive(Args, Debug)]
pub(crate) struct CameraTrianglesFlags {
    /// Files, sequences or demo:NAME
    #[arg(default_values = ["demo:hall", "demo:statue"])]
    scenes: Vec<String>,
    /// The most triangles that a thread searches in a tile of 64x64 pixels
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_values = ["512", "2048", "8192", "32768"])]
    triangles: Vec<NonZeroU32>,
    /// Widths and heights of the image in pixels: of 64, all triangles are in one tile
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_values_t = [64, 256, 1024])]
    sides: Vec<u32>,
    #[command(flatten)]
    common: AnimationFlags,
}

impl CameraTrianglesFlags {
    pub(crate) fn run(&self) -> Result<()> {
        let mut table = self.common.output.start_without_chart(&self.common.prepare(None)?)?;
        let limits: Vec<_> = std::iter::once(None).chain(self.triangles.iter().copied().map(Some)).collect();
        let options = |most_triangles| ListedOptions { most_triangles, ..ListedOptions::DEFAULT };
        let forms: Vec<_> = limits.iter().map(|&most| options(most).into()).collect();
        for address in &self.scenes {
            for &side in &self.sides {
                let all = measure(address, [side, side], &forms, &self.common, |shot| shot.lights.clear())?;
                let undivided = all.first().map_or(f64::NAN, |costs| costs.see);
                for (limit, costs) in limits.iter().zip(&all) {
                    table.push(row![
                        ("scene", name(address)),
                        ("side", side),
                        ("triangles", limit.map_or_else(|| "all".to_owned(), |most| most.to_string())),
                        ("pairs", costs.counts.pairs),
                        ("block_tests", costs.counts.tests),
                        ("build", costs.build),
                        ("see", costs.see),
                        ("ratio", costs.see / undivided),
                    ])?;
                }
            }
        }
        table.finish(&[
            "triangles: the most that a thread searches in a tile of 64x64 pixels; what is found is compared in the end.",
            "ratio: see by that of undivided tiles. Primary rays only.",
        ])?;
        Ok(())
    }
}
