//! `umbrage heatmap`: how much work each pixel is (Guntury and Narayanan 2010, Figure 2).

mod font;
mod legend;

use std::io::{self, Write};
use std::path::Path;

use umbrage::output::{BitDepth, write_png};
use umbrage::rays::{Cells, ListedLightOptions, ListedOptions, Work};
use umbrage::{CameraChoice, Error, HeatScale, Image, Renderer, Settings, Structure, WorkCounts};

use crate::failure::Failure;
use crate::flags::{CountedFlag, GridFlag, HeatmapFlags};
use crate::job::{DEFAULT_SCENE, DEFAULT_SCENE_SECONDS, use_threads};
use crate::staging::listed_camera;
use crate::values::{CameraFlag, Size};
use legend::{Legend, sixteen_bits};

/// What is counted of the work of finding each pixel's triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Counted {
    Tested,
    Cells,
    Undecided,
    Pairs,
}

impl Counted {
    const ALL: [Self; 4] = [Self::Tested, Self::Cells, Self::Undecided, Self::Pairs];

    fn of(self, work: Work) -> u32 {
        match self {
            Self::Tested => work.tested,
            Self::Cells => work.cells,
            Self::Undecided => work.undecided,
            Self::Pairs => work.pairs,
        }
    }

    fn title(self) -> &'static str {
        match self {
            Self::Tested => "triangles tested",
            Self::Cells => "cells visited",
            Self::Undecided => "undecided",
            Self::Pairs => "pairs per tile",
        }
    }
}

/// The title of [`Shown::Points`].
const POINTS_TITLE: &str = "points per cell";

/// What a picture shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Shown {
    Work(Counted),
    /// How many points share each pixel's cell for a light, which counts from 0.
    Points {
        light: usize,
    },
}

impl Shown {
    fn new(flags: &HeatmapFlags) -> Result<Self, Failure> {
        let counted = match flags.of {
            CountedFlag::Points => return Ok(Self::Points { light: flags.light.unwrap_or(0) }),
            _ if flags.light.is_some() => {
                let hint = "--light says whose grid `--of points` shows";
                return Err(Failure::input("camera rays know no lights", hint));
            }
            CountedFlag::Tested => Counted::Tested,
            CountedFlag::Cells => Counted::Cells,
            CountedFlag::Undecided => Counted::Undecided,
            CountedFlag::Pairs => Counted::Pairs,
        };
        Ok(Self::Work(counted))
    }
}

pub(crate) fn run(flags: HeatmapFlags) -> Result<(), Failure> {
    let (shown, structure) = (Shown::new(&flags)?, structure(&flags)?);
    let default_seconds = if flags.scene.is_none() { DEFAULT_SCENE_SECONDS } else { 0.0 };
    let seconds = flags.time.unwrap_or(default_seconds);
    let address = flags.scene.unwrap_or_else(|| DEFAULT_SCENE.into());
    use_threads(flags.threads)?;
    let scene = umbrage::open_with(&address, &flags.opening.into())?;
    let frame = scene.at(seconds)?;
    let camera = match flags.camera {
        None => CameraChoice::Default,
        Some(CameraFlag::Placed(camera)) => camera.into(),
        Some(CameraFlag::Listed(name)) => CameraChoice::Scene(listed_camera(&frame, &name)?),
    };
    let Size { width, height } = flags.size;
    let settings = Settings { width, height, camera, structure, ..Settings::default() };
    let light = match shown {
        Shown::Work(_) => None,
        Shown::Points { light } => Some(light),
    };
    let mut counts = WorkCounts::default();
    Renderer::default().count_work(&frame, &settings, light, &mut counts).map_err(no_such_light)?;
    let WorkCounts { pixels: work, cells } = counts;
    let pixels = || (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let mut all: Vec<(&str, Vec<u32>)> = Counted::ALL
        .map(|counted| (counted.title(), pixels().map(|(x, y)| counted.of(work.at(x, y))).collect()))
        .into();
    let place = match shown {
        Shown::Work(counted) => counted as usize,
        Shown::Points { .. } => {
            all.push((POINTS_TITLE, pixels().map(|(x, y)| cells.points_at(x, y)).collect()));
            all.len() - 1
        }
    };

    let (title, counts) = &all[place];
    let image = picture(counts, flags.size, title, flags.max);
    let path = flags.output.as_deref().unwrap_or(Path::new("heatmap.png"));
    write_png(&image, path, BitDepth::Eight)?;
    let mut stdout = io::stdout();
    for (title, counts) in &all {
        writeln!(stdout, "{title:<16}  {}", Summary::of(counts).text())?;
    }
    Ok(())
}

/// Says which lights there are, where one was asked for that isn't there.
fn no_such_light(error: Error) -> Failure {
    match error {
        Error::NoSuchLight { light, lights } => {
            let hint = format!("the scene has {lights}, counted from 0; `umbrage info` lists them");
            Failure::input(format!("--light: the scene has no light {light}"), hint)
        }
        error => error.into(),
    }
}

/// What finds the triangles.
fn structure(flags: &HeatmapFlags) -> Result<Structure, Failure> {
    let asked = [flags.sorting_tile, flags.tracing_tiles, flags.slices];
    match flags.structure {
        GridFlag::Perspective if flags.whole_tiles || asked.iter().any(Option::is_some) => Err(Failure::input(
            "the perspective grid's cells can't be chosen",
            "--sorting-tile, --tracing-tiles, --slices and --whole-tiles are for `--structure listed`",
        )),
        GridFlag::Perspective => Ok(Structure::Perspective),
        GridFlag::Listed => {
            let default = Cells::DEFAULT;
            let sorting_tile = flags.sorting_tile.unwrap_or(default.sorting_tile());
            let tracing_tiles = flags.tracing_tiles.unwrap_or_else(|| {
                // As many as fit, where that is fewer.
                let fit = Cells::LARGEST_TILE.checked_div(sorting_tile).unwrap_or(1);
                default.tracing_tiles().min(fit.max(1))
            });
            let slices = flags.slices.unwrap_or(default.slices());
            let cells = Cells::new(sorting_tile, tracing_tiles, slices)
                .map_err(|impossible| Failure::Input { message: impossible.to_string(), hint: None })?;
            let skips_blocks = !flags.whole_tiles;
            let camera = ListedOptions { cells, skips_blocks, ..ListedOptions::DEFAULT };
            Ok(Structure::Listed { camera, light: ListedLightOptions::DEFAULT })
        }
    }
}

/// Draws counts in rows of pixels, with a legend below. Colours end at `max`, or where few pixels go beyond.
fn picture(counts: &[u32], size: Size, title: &str, max: Option<u32>) -> Image {
    let summary = Summary::of(counts);
    let scale = max.map_or_else(|| HeatScale::of(counts), HeatScale::up_to);
    let background = std::iter::repeat_n([0; 3], Legend::height(size.width) as usize * size.width as usize);
    let colors = counts.iter().map(|&count| scale.color(count).map(sixteen_bits));
    let height = size.height + Legend::height(size.width);
    let mut image = Image { width: size.width, height, pixels: colors.chain(background).collect() };
    let title = format!("{title}  {}", summary.text());
    Legend { title: &title, scale, highest: summary.highest }.draw(&mut image, size.height);
    image
}

/// What all counts come to.
struct Summary {
    lowest: u32,
    mean: f64,
    highest: u32,
}

impl Summary {
    fn of(counts: &[u32]) -> Self {
        let sum: u64 = counts.iter().copied().map(u64::from).sum();
        Self {
            lowest: counts.iter().copied().min().unwrap_or(0),
            mean: sum as f64 / counts.len().max(1) as f64,
            highest: counts.iter().copied().max().unwrap_or(0),
        }
    }

    fn text(&self) -> String {
        let Self { lowest, mean, highest } = self;
        format!("min {lowest}  mean {mean:.2}  max {highest}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_shows_each_count_in_its_place() {
        let counts = [0, 1, 2, 3, 4, 50];
        let image = picture(&counts, Size { width: 3, height: 2 }, "CELLS", Some(4));
        assert_eq!((image.width, image.height), (3, 2 + Legend::height(3)));
        assert_eq!(image.pixels.len(), 3 * image.height as usize);
        let scale = HeatScale::up_to(4);
        let expected = counts.map(|count| scale.color(count).map(sixteen_bits));
        assert_eq!(image.pixels[..6], expected);
        assert_eq!(Summary::of(&counts).text(), "min 0  mean 10.00  max 50");
    }
}
