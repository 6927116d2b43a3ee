//! Maps of a light's points (§4.1 of the paper): by two angles all around it, or through faces, each with cells; and
//! the direct form, which has none.

use anyhow::{Context, Result};
use clap::Args;
use glam::Vec3;
use umbrage::rays::LightSource;
use umbrage_papers::{LightMapping, ListedLightOptions};

use crate::flags::{ImageFlags, SceneFlags};
use crate::grids::Forms;
use crate::measure::{Costs, measure};
use crate::plot::{Bar, BarChart};
use crate::shot::{name, short_name, viewpoints};
use crate::table::{Row, row};

#[derive(Args, Debug)]
pub(crate) struct LightMapsFlags {
    #[command(flatten)]
    scenes: SceneFlags,
    /// Put the light near the scene's middle, by this part of half the diagonal of the scene's box above it, rather than
    /// where the scene has it
    #[arg(long, value_name = "PART")]
    inside: Option<f32>,
    /// Cells a side of the listed grids
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_values_t = [ListedLightOptions::DEFAULT.cells()])]
    cells: Vec<u32>,
    /// Depth slices of the listed grids
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_values_t = [1, 8])]
    slices: Vec<u32>,
    /// The most triangles in a block of work of the listed grids
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_values_t = [ListedLightOptions::DEFAULT.triangles()])]
    triangles: Vec<u32>,
    #[command(flatten)]
    common: ImageFlags,
}

impl LightMapsFlags {
    pub(crate) fn run(&self) -> Result<()> {
        // `None` stands for the direct form.
        let options: Vec<Option<ListedLightOptions>> =
            std::iter::once(Ok(None)).chain(self.listed().map(|options| options.map(Some))).collect::<Result<_>>()?;
        let forms: Vec<Forms> = options.iter().map(|&lights| Forms { lights, ..Forms::default() }).collect();
        let addresses = self.scenes.addresses();
        let mut bars = Vec::new();
        let mut table = self.common.start()?;
        for address in &addresses {
            let all = measure(address, self.common.size, &forms, &self.common.animation, |shot| {
                if let Some(part) = self.inside {
                    let above = Vec3::Y * (0.5 * part * shot.bounds.size().length());
                    shot.lights = vec![LightSource::Point { position: shot.bounds.center() + above }];
                }
            })?;
            for (options, costs) in options.iter().zip(&all) {
                table.push(cells(name(address), options.as_ref(), costs))?;
                let form = options
                    .map_or("direct".to_owned(), |options| format!("{}, {} slices", options.map, options.slices()));
                bars.push(bar(&format!("{}, {form}", short_name(address)), costs));
            }
        }
        viewpoints(&addresses).iter().try_for_each(|viewpoint| table.note(viewpoint))?;
        let notes = [
            "Points are their mapping and sorting, list is the sorting of triangles by cell with their projection.",
            "The direct form has no cells: its list is the projection of patches, and its points' sorting is in trace.",
        ];
        let parts = ["points", "list", "trace", "settle"].map(str::to_owned).to_vec();
        let chart = BarChart { title: "Shadows of one light", y_title: "milliseconds", parts, bars };
        self.common.finish(table, &notes, &chart)
    }

    /// All listed grids.
    fn listed(&self) -> impl Iterator<Item = Result<ListedLightOptions>> {
        let sizes =
            self.cells.iter().flat_map(|&cells| self.triangles.iter().map(move |&triangles| [cells, triangles]));
        let sizes = sizes.flat_map(|sizes| self.slices.iter().map(move |&slices| (sizes, slices)));
        sizes.flat_map(|([cells, triangles], slices)| {
            [LightMapping::Faces, LightMapping::Spherical].map(|map| {
                let sizes = ListedLightOptions::new(cells, ListedLightOptions::DEFAULT.points(), triangles)?;
                let mut options =
                    sizes.with_slices(slices).with_context(|| format!("{slices} slices are impossible"))?;
                options.map = map;
                Ok(options)
            })
        })
    }
}

/// Milliseconds of groups of stages.
fn stages(costs: &Costs) -> [f64; 4] {
    let of = |names: &[&str]| names.iter().map(|name| costs.light_stage(name)).sum::<f64>();
    [of(&["survey", "map", "points"]), of(&["project", "list", "sort"]), of(&["trace"]), of(&["settle"])]
}

fn cells(name: &str, options: Option<&ListedLightOptions>, costs: &Costs) -> Row {
    let [points, list, trace, settle] = stages(costs);
    let counts = costs.light_counts;
    row![
        ("scene", name),
        ("triangles", costs.triangles),
        ("map", options.map_or("direct", |options| umbrage::rays::Choice::name(options.map))),
        ("cells", options.map(ListedLightOptions::cells)),
        ("slices", options.map(ListedLightOptions::slices)),
        ("block_triangles", options.map(ListedLightOptions::triangles)),
        ("faces", counts.faces),
        ("pairs", counts.pairs),
        ("tests", counts.tests),
        ("undecided", counts.undecided),
        ("outliers", counts.outliers),
        ("points", points),
        ("list", list),
        ("trace", trace),
        ("settle", settle),
        ("shadow", costs.survey + costs.shadow),
    ]
}

fn bar(name: &str, costs: &Costs) -> Bar {
    Bar { name: name.to_owned(), heights: stages(costs).to_vec() }
}
