use umbrage::rays::{self, Choice, SimdLevel};
use umbrage::{Error, KindOption, OptionValues, StructureKind};

use super::{choice, option, parsed};
use crate::uniform::{Insertion, PacketSide, UniformGrid, UniformOptions};

/// One uniform grid for all rays, traced in packets. Where the frame has see-through surfaces, crowded cells hold grids of
/// their own even if the options don't ask for that.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Uniform(pub UniformOptions);

impl StructureKind for Uniform {
    const NAME: &'static str = "grid";
    const ABOUT: &'static str = "a uniform grid for all rays, traced in packets";
    const PAPER: Option<&'static str> =
        Some("Wald, Ize, Kensler, Knoll and Parker, Ray Tracing Animated Scenes using Coherent Grid Traversal, 2006");
    const OPTIONS: &'static [KindOption<Self>] = &[
        option!("density"; "Cells for each triangle, λ of the paper"; OptionValues::Positive;
            |grid| grid.0.cells_per_triangle;
            |grid, value| grid.0.cells_per_triangle = parsed(value)?),
        option!("macrocell"; "Cells a side of macrocells, by which empty space is skipped; 1 does without";
            OptionValues::Whole(1..=UniformOptions::LARGEST_MACROCELL);
            |grid| grid.0.macrocell;
            |grid, value| grid.0.macrocell = parsed(value)?),
        option!("insertion"; "Which cells list a triangle"; OptionValues::Names(Insertion::names);
            |grid| grid.0.insertion;
            |grid, value| grid.0.insertion = choice(value)?),
        option!("spread"; "Split packets of shadow rays where inverse depths differ by more than this part of the first";
        OptionValues::Positive;
        |grid| grid.0.shadow_spread;
        |grid, value| {
            let spread: f32 = parsed(value)?;
            if !(spread > 0.0 && spread.is_finite()) {
                return Err("give a number above 0".to_owned());
            }
            grid.0.shadow_spread = spread;
        }),
        option!("nested";
            "Let cells that list more than so many triangles hold grids of their own, for scenes of very uneven density; \
             auto: more than 64, and only in scenes with surfaces that one sees through";
            OptionValues::WholeOrAuto(1..=u32::MAX);
            |grid| grid.0.nested_above.map_or_else(|| "auto".to_owned(), |most| most.to_string());
            |grid, value| grid.0.nested_above = value.parse().ok()),
        option!("packet"; "Pixels a side of the packets of rays"; OptionValues::Names(PacketSide::names);
            |grid| grid.0.packet;
            |grid, value| grid.0.packet = choice(value)?),
    ];

    fn make(&self, level: SimdLevel, sends_rays_onward: bool) -> Result<Box<dyn rays::Structure>, Error> {
        let Self(mut options) = *self;
        if sends_rays_onward {
            // Single rays need nested grids where triangles crowd: a twelfth of the time for `demo:glass`.
            options.nested_above = options.nested_above.or(UniformOptions::NESTED.nested_above);
        }
        let mut grid = UniformGrid::with_level(level);
        grid.set_options(options).map_err(|impossible| Error::StructureOptions(impossible.into()))?;
        Ok(Box::new(grid))
    }

    fn check(&self) -> Result<(), Error> {
        self.0.check().map_err(|impossible| Error::StructureOptions(impossible.into()))
    }
}
