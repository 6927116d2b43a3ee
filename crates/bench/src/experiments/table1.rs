//! Table 1 of the paper: times of building and tracing, beside the paper's own.

use anyhow::Result;
use clap::Args;
use umbrage_papers::{ListedLightOptions, ListedOptions};

use crate::flags::{ImageFlags, SceneFlags};
use crate::grids::Forms;
use crate::measure::{Costs, measure};
use crate::plot::{Bar, BarChart};
use crate::shot::{name, short_name, viewpoints};
use crate::table::{Row, row};

#[derive(Args, Debug)]
pub(crate) struct Table1Flags {
    #[command(flatten)]
    scenes: SceneFlags,
    /// Lights: the scene's own, and where it has fewer, its first one, turned around the scene. The paper has one in its
    /// table and two in a trial of Fairy
    #[arg(long, value_name = "N", default_value = "1", value_parser = clap::value_parser!(u32).range(1..=64))]
    lights: u32,
    #[command(flatten)]
    common: ImageFlags,
}

/// A row of the paper's table, in milliseconds.
struct PaperRow {
    scene: &'static str,
    /// Our scene of the same kind and size.
    like: &'static str,
    triangles: usize,
    build: f64,
    trace: f64,
    with_shadows: f64,
}

const fn paper(
    scene: &'static str,
    like: &'static str,
    triangles: usize,
    [build, trace]: [f64; 2],
    with_shadows: f64,
) -> PaperRow {
    PaperRow { scene, like, triangles, build, trace, with_shadows }
}

/// From the text below the paper's Table 1: 7.6 frames a second with two lights.
const PAPER_WITH_TWO_LIGHTS: [PaperRow; 1] = [paper("Fairy", "demo:forest", 174_000, [8.73, 32.43], 131.58)];

/// The columns "our method" of the paper's Table 1.
const PAPER: [PaperRow; 6] = [
    paper("Fairy", "demo:forest", 174_000, [8.73, 32.43], 82.18),
    paper("Sibenik", "sibenik.obj", 82_000, [8.86, 13.11], 58.81),
    paper("Bunny/Dragon", "demo:shatter", 252_000, [3.71, 10.92], 31.63),
    paper("Conference", "demo:hall", 284_000, [7.51, 17.64], 61.15),
    paper("Cloth", "demo:cloth", 92_000, [5.23, 11.23], 44.47),
    paper("Buddha", "demo:statue", 1_090_000, [13.76, 38.91], 114.57),
];

impl Table1Flags {
    pub(crate) fn run(&self) -> Result<()> {
        let addresses = self.scenes.addresses();
        let mut bars = Vec::new();
        let mut table = self.common.start()?;
        for address in &addresses {
            let listed = Forms { camera: Some(ListedOptions::DEFAULT), lights: Some(ListedLightOptions::DEFAULT) };
            let forms = [Forms::default(), listed];
            let costs = measure(address, self.common.size, &forms, &self.common.animation, |shot| {
                if self.lights > 1 {
                    shot.make_lights(self.lights);
                }
            })?;
            let [direct, listed] = &costs[..] else { continue };
            let paper = self.paper().iter().find(|row| row.like == name(address));
            table.push(cells(name(address), direct, listed, paper))?;
            // The chart shows the paper's scenes only.
            if let Some(PaperRow { scene, build, trace, with_shadows, .. }) = paper {
                bars.push(bar(&format!("{}, direct", short_name(address)), direct));
                bars.push(bar(&format!("{}, listed", short_name(address)), listed));
                let heights = vec![*build, *trace, with_shadows - build - trace];
                bars.push(Bar { name: format!("{scene}, 2010"), heights });
            }
        }
        viewpoints(&addresses).iter().try_for_each(|viewpoint| table.note(viewpoint))?;
        let notes = [
            "A frame is build + see + shadow of all lights; each form has its own grids for the camera and for the lights.",
            "The direct form tests tiny triangles while it builds: its build is part of what others call tracing.",
            "The paper's numbers are of an NVIDIA GTX 280, at 1024x1024, for its own scenes, and without sorting out",
            "what its f32 tests can't decide; ours named beside them are of the same kind and about the same size.",
        ];
        let parts = ["build", "see", "shadow"].map(str::to_owned).to_vec();
        let chart = BarChart { title: "A frame, rebuilt and traced", y_title: "milliseconds", parts, bars };
        self.common.finish(table, &notes, &chart)
    }

    /// The paper's measurements with this number of lights.
    fn paper(&self) -> &'static [PaperRow] {
        match self.lights {
            1 => &PAPER,
            2 => &PAPER_WITH_TWO_LIGHTS,
            _ => &[],
        }
    }
}

fn cells(name: &str, direct: &Costs, listed: &Costs, paper: Option<&PaperRow>) -> Row {
    row![
        ("scene", name),
        ("triangles", direct.triangles),
        ("build", direct.build),
        ("see", direct.see),
        ("frame", direct.frame),
        ("listed_build", listed.build),
        ("listed_see", listed.see),
        ("listed_frame", listed.frame),
        ("paper_scene", paper.map(|paper| paper.scene)),
        ("paper_triangles", paper.map(|paper| paper.triangles)),
        ("paper_build", paper.map(|paper| paper.build)),
        ("paper_see", paper.map(|paper| paper.trace)),
        ("paper_frame", paper.map(|paper| paper.with_shadows)),
    ]
}

fn bar(name: &str, costs: &Costs) -> Bar {
    Bar { name: name.to_owned(), heights: vec![costs.build, costs.see, costs.survey + costs.shadow] }
}
