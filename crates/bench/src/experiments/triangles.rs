//! Ray–triangle tests of the literature, side by side (Rahikainen 2013, §2.1).

mod contest;
mod pairs;

use anyhow::{Context, Result, ensure};
use clap::Args;
use umbrage::rays::{Projection, SimdLevel};
use umbrage::scene::Frame;
use umbrage_papers::triangle::{
    Badouel, BadouelBundle, HavelHerout, KenslerShirley, MollerTrumbore, MollerTrumboreBundle, Plucker, PluckerBundle,
    Shevtsov, Wachter,
};

use crate::flags::{OutputFlags, size};
use crate::plot::{Bar, BarChart};
use crate::shot::{Lights, Shot, name, short_name};
use crate::table::{Cell, Row, Table, row};
use contest::{Contest, Costs};
use pairs::Pairs;

#[derive(Args, Debug)]
pub(crate) struct TrianglesFlags {
    /// Files, sequences or demo:NAME
    #[arg(default_values = ["demo:cloth", "demo:hall"])]
    scenes: Vec<String>,
    /// Width and height of the image whose rays are taken, in pixels
    #[arg(long, value_name = "WxH", default_value = "1024x1024", value_parser = size)]
    size: [u32; 2],
    /// How often all tests are run in turn; once more comes first and doesn't count
    #[arg(long, value_name = "N", default_value = "15", value_parser = clap::value_parser!(u32).range(1..))]
    rounds: u32,
    /// SIMD instructions for sixteen rays: sse2, avx2 or avx512 [default: the widest]
    #[arg(long, value_name = "LEVEL")]
    simd: Option<SimdLevel>,
    #[command(flatten)]
    output: OutputFlags,
}

/// Explanations of the columns.
const NOTES: [&str; 4] = [
    "Pairs are what one ray of 4x4 tests on its way through a uniform grid, each triangle once; sixteen rays are all",
    "of the 4x4, and their hits are triangles that any of them hits. A fan's tests are all of its triangles: more_tests",
    "times those of the pairs alone. Speedups are over Möller and Trumbore's test of all pairs for as many rays,",
    "medians over rounds. Triangles are prepared first, apart, and read from caches as far as they fit.",
];

/// Speedups over Möller and Trumbore's test that papers report, as the thesis cites them.
const REPORTED: [(&str, &str); 7] = [
    ("Badouel (Wald)", "2.1-2.3 eye, 1.9-2.0 shadow (Wald 04); 1.003 (Komatsu 08)"),
    ("Wächter", "faster than floating-point comparisons (Wächter 04), no ratio"),
    ("Plücker", "1.025 (Komatsu 08); 1.2 over Badouel (Benthin 06)"),
    ("Shevtsov et al.", "among the three fastest (Rahikainen 13), no ratio"),
    ("Havel–Herout", "fastest in general (Rahikainen 13), no ratio"),
    ("Kensler–Shirley", "1.72-2.16 (Kensler and Shirley 06)"),
    ("Galin–Akkouche", "nearly 1.4 (Galin and Akkouche 05)"),
];

impl TrianglesFlags {
    pub(crate) fn run(&self) -> Result<()> {
        let (simd, rounds) = (self.simd.unwrap_or_default(), self.rounds);
        let conditions = format!(
            "{simd} for sixteen rays, one thread, medians of {rounds} rounds, in million tests of one ray a second"
        );
        let mut table = self.output.start(&conditions)?;
        let mut bars = Vec::new();
        for address in &self.scenes {
            let costs = self.measure(address, &mut table).with_context(|| format!("scene {address}"))?;
            for test in &costs {
                table.push(row(name(address), test))?;
                let title = format!("{}, {}, {}", short_name(address), test.rays, test.name);
                bars.push(Bar { name: title, heights: vec![test.speedup] });
            }
        }
        let parts = vec!["all pairs".to_owned()];
        let chart = BarChart { title: "Triangle tests", y_title: "speedup over Möller–Trumbore", parts, bars };
        self.output.finish(table, &NOTES, &chart)
    }

    fn measure(&self, address: &str, table: &mut Table) -> Result<Vec<Costs>> {
        let scene = umbrage::open(address)?;
        let mut frame = Frame::default();
        scene.pose(0.5 * scene.duration_seconds(), &mut frame)?;
        let shot = Shot::new(&frame, address, self.size, 1, Lights::First);
        let is_perspective = matches!(shot.view.camera.projection, Projection::Perspective { .. });
        ensure!(is_perspective, "rays share no origin: the camera is orthographic");
        let pairs = Pairs::new(frame.triangles(), &shot.view)?;
        let shares =
            [&pairs.single, &pairs.sixteen].map(|lists| 100.0 * lists.hits.len() as f64 / lists.all.len() as f64);
        let (count, blocks) = (pairs.single.all.len(), pairs.blocks.len());
        table.note(&format!(
            "{}: {count} pairs of {blocks} rays or groups; hits {:.1} % for one ray, {:.1} % for sixteen",
            name(address),
            shares[0],
            shares[1]
        ))?;

        let mut contest = Contest::new(frame.triangles(), &pairs, self.simd.unwrap_or_default());
        contest.add::<MollerTrumbore>();
        contest.add::<KenslerShirley>();
        contest.add::<Badouel>();
        contest.add::<Wachter>();
        contest.add::<Plucker>();
        contest.add::<Shevtsov>();
        contest.add::<HavelHerout>();
        contest.add_fans();
        contest.add_bundle::<MollerTrumboreBundle>();
        contest.add_bundle::<BadouelBundle>();
        contest.add_bundle::<PluckerBundle>();
        Ok(contest.run(self.rounds))
    }
}

fn row(scene: &str, test: &Costs) -> Row {
    let reported = REPORTED.iter().find(|(name, _)| *name == test.name).map(|(_, text)| *text);
    row![
        ("scene", scene),
        ("rays", test.rays.to_string()),
        ("test", test.name),
        ("bytes_triangle", Cell::Number(test.bytes, 1)),
        ("prepare_ns", Cell::Number(test.prepare_ns, 1)),
        ("all_mtests", Cell::Number(test.rate, 1)),
        ("hits_mtests", Cell::Number(test.hit_rate, 1)),
        ("misses_mtests", Cell::Number(test.miss_rate, 1)),
        ("more_tests", test.more_tests),
        ("speedup", test.speedup),
        ("reported_speedup", reported),
    ]
}
