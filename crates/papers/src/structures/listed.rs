use std::num::NonZeroU32;

use umbrage::rays::{self, SimdLevel};
use umbrage::{Error, GpuGrids, GpuStructure, KindOption, OptionValues, StructureKind};

use super::{choice, option, parsed, whole_among};
use crate::{Cells, LightMapping, ListedGrids, ListedLightOptions, ListedOptions};

/// Grids as their paper describes them, with triangles listed by cell, for the camera and for each light.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Listed {
    /// Cells of the camera's grid.
    pub camera: ListedOptions,
    /// Cells of each light's grid, and their blocks of work.
    pub light: ListedLightOptions,
}

impl StructureKind for Listed {
    const NAME: &'static str = "listed";
    const ABOUT: &'static str = "perspective grids in their paper's form, with triangles listed by cell";
    const PAPER: Option<&'static str> =
        Some("Guntury and Narayanan, Raytracing Dynamic Scenes on the GPU Using Grids, 2010");
    const OPTIONS: &'static [KindOption<Self>] = &[
        option!("sorting-tile", gpu; "Pixels a side of the tiles that triangles are listed in"; OptionValues::Names(tiles);
        |listed| listed.camera.cells.sorting_tile();
        |listed, value| {
            let tile = whole_among(value, tiles)?;
            listed.camera.cells = with_sorting_tile(listed.camera.cells, tile).ok_or("tiles have at most 64 pixels a side")?;
        }),
        option!("tracing-tiles", gpu;
        "Sorting tiles a side of the tiles that are searched at once, of 64 pixels a side at most";
        OptionValues::Names(tiles_of_tiles);
        |listed| listed.camera.cells.tracing_tiles();
        |listed, value| {
            let cells = &mut listed.camera.cells;
            *cells = cells_of(cells.sorting_tile(), whole_among(value, tiles_of_tiles)?, cells.slices())?;
        }),
        option!("slices", gpu; "Depth slices of the camera's grid"; OptionValues::Whole(1..=Cells::MOST_SLICES);
        |listed| listed.camera.cells.slices();
        |listed, value| {
            let cells = &mut listed.camera.cells;
            *cells = cells_of(cells.sorting_tile(), cells.tracing_tiles(), parsed(value)?)?;
        }),
        option!("whole-tiles"; "Test all triangles of a cell on all pixels of its tile, as one GPU thread for each pixel does";
            OptionValues::Switch;
            |listed| !listed.camera.skips_blocks;
            |listed, value| listed.camera.skips_blocks = value != "true"),
        option!("camera-triangles";
            "The most triangles that a thread searches in 64×64 pixels, where more are divided among threads; auto divides none";
            OptionValues::WholeOrAuto(1..=u32::MAX);
            |listed| listed.camera.most_triangles.map_or_else(|| "auto".to_owned(), |most| most.to_string());
            |listed, value| listed.camera.most_triangles = value.parse().ok().and_then(NonZeroU32::new)),
        option!("light-cells"; "Cells a side of the light grids"; OptionValues::Whole(1..=ListedLightOptions::MOST_CELLS);
        |listed| listed.light.cells();
        |listed, value| {
            let light = &mut listed.light;
            *light = with_sizes(light, parsed(value)?, light.points(), light.triangles())?;
        }),
        option!("light-rays";
        "The most shadow rays in a block of work of the light grids, the paper's r; a multiple of 16";
        OptionValues::Whole(1..=ListedLightOptions::LARGEST_BLOCK);
        |listed| listed.light.points();
        |listed, value| {
            let light = &mut listed.light;
            *light = with_sizes(light, light.cells(), parsed(value)?, light.triangles())?;
        }),
        option!("light-triangles"; "The most triangles in a block of work of the light grids";
        OptionValues::Whole(1..=ListedLightOptions::LARGEST_BLOCK);
        |listed| listed.light.triangles();
        |listed, value| {
            let light = &mut listed.light;
            *light = with_sizes(light, light.cells(), light.points(), parsed(value)?)?;
        }),
        option!("light-slices", gpu; "Depth slices of the light grids";
        OptionValues::Whole(1..=ListedLightOptions::MOST_SLICES);
        |listed| listed.light.slices();
        |listed, value| {
            listed.light = listed.light.with_slices(parsed(value)?).ok_or("there are at most 32 slices")?;
        }),
        option!("light-map", gpu; "How lights that are somewhere see points and triangles";
            OptionValues::Names(<LightMapping as rays::Choice>::names);
            |listed| listed.light.map;
            |listed, value| listed.light.map = choice(value)?),
        option!("light-clamp", gpu;
            "Angles that a spherical light map divides into cells: the lowest and highest α, and β, in degrees around the \
             light's forward direction, as -30:30:-20:20; border cells hold the rest, and auto takes the angles at which \
             the camera sees something";
            OptionValues::Rectangle;
            |listed| listed.light.clamp.map_or_else(|| "auto".to_owned(), |clamp| clamp.to_string());
            |listed, value| listed.light.clamp = value.parse().ok()),
    ];
    const IS_SPECIALISED: bool = true;

    fn make(&self, level: SimdLevel, _sends_rays_onward: bool) -> Result<Box<dyn rays::Structure>, Error> {
        Ok(Box::new(ListedGrids::with_options(level, self.camera, self.light)))
    }

    fn check(&self) -> Result<(), Error> {
        if self.light.map == LightMapping::Faces && self.light.clamp.is_some() {
            let why = "`light-clamp` divides angles, which only a spherical light map has: set `light-map` to spherical \
                       as well";
            return Err(Error::StructureOptions(why.into()));
        }
        Ok(())
    }

    fn on_gpu(&self) -> Result<Option<GpuStructure>, Error> {
        let cells = self.camera.cells;
        let (tile, tiles) = (cells.sorting_tile(), cells.tracing_tiles());
        let by_default = with_sorting_tile(Cells::DEFAULT, tile).map(|cells| cells.tracing_tiles());
        if !(matches!(tile, 8 | 16) && (tile * tiles == 16 || Some(tiles) == by_default)) {
            let why = "a GPU traces tiles of 16 pixels a side: sorting tiles have 8 or 16, and 2 or 1 of them a side make a \
                       tracing tile";
            return Err(Error::StructureOptions(why.into()));
        }
        Ok(Some(GpuStructure::grids_of(GpuGrids {
            sorting_tile: tile,
            slices: cells.slices(),
            lights_are_spherical: self.light.map == LightMapping::Spherical,
            light_clamp: self.light.clamp,
            light_slices: self.light.slices(),
        })))
    }
}

fn cells_of(sorting_tile: u32, tracing_tiles: u32, slices: u32) -> Result<Cells, String> {
    Cells::new(sorting_tile, tracing_tiles, slices).map_err(|impossible| impossible.to_string())
}

fn with_sizes(
    light: &ListedLightOptions,
    cells: u32,
    points: u32,
    triangles: u32,
) -> Result<ListedLightOptions, String> {
    light.with_sizes(cells, points, triangles).map_err(|impossible| impossible.to_string())
}

/// The same cells with larger or smaller sorting tiles, and no more of them in a tracing tile than fit.
fn with_sorting_tile(cells: Cells, tile: u32) -> Option<Cells> {
    let fit = Cells::LARGEST_TILE.checked_div(tile)?;
    Cells::new(tile, cells.tracing_tiles().min(fit), cells.slices()).ok()
}

fn tiles() -> Vec<(&'static str, &'static str)> {
    vec![("8", ""), ("16", ""), ("32", ""), ("64", "")]
}

fn tiles_of_tiles() -> Vec<(&'static str, &'static str)> {
    vec![("1", ""), ("2", ""), ("4", ""), ("8", "")]
}
