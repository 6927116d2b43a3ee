//! `umbrage heatmap`: the work of each pixel (Guntury and Narayanan 2010, Figure 2).

mod legend;

use std::io::{self, Write};
use std::path::Path;

use umbrage::output::{BitDepth, write_png};
use umbrage::rays::Choice;
use umbrage::{Error, HeatKind, HeatScale, Image, Renderer, Settings, WorkCounts};

use crate::failure::Failure;
use crate::flags::HeatmapFlags;
use crate::job::{check_inputs_stay, check_memory};
use crate::progress::Progress;
use crate::staging::camera_choice;
use crate::threads::use_threads;
use crate::values::Size;
use legend::{Legend, sixteen_bits};

pub(crate) fn run(flags: &HeatmapFlags) -> Result<(), Failure> {
    if flags.light.is_some() && flags.of != HeatKind::Points {
        return Err(Failure::input("camera rays know no lights", "--light says whose grid `--of points` shows"));
    }
    let structure = flags.structure.clone();
    let Size { width, height } = flags.size;
    check_memory(&Settings { width, height, ..Settings::default() }, &flags.scene.opening)?;
    let address = flags.scene.address();
    use_threads(flags.scene.threads, Some([width, height]))?;
    let opening = Progress::task("opening", &address, false);
    let scene = umbrage::open_with(&address, &flags.scene.opening.options())?;
    drop(opening);
    let path = flags.output.as_deref().unwrap_or(Path::new("heatmap.png"));
    check_inputs_stay([path.to_owned()], &scene, None)?;
    let frame = scene.at(flags.time.unwrap_or(scene.still_seconds()))?;
    let camera = camera_choice(flags.camera.as_ref(), &frame.cameras, scene.origin())?;
    let settings = Settings { width, height, camera, structure, ..Settings::default() };
    let light = (flags.of == HeatKind::Points).then(|| flags.light.unwrap_or(0));
    let mut counts = WorkCounts::default();
    Renderer::default().count_work(&frame, &settings, light, &mut counts).map_err(no_such_light)?;
    let WorkCounts { pixels: work, cells } = counts;
    let pixels = || (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let of_pixels = |count: &dyn Fn(u32, u32) -> u32| pixels().map(|(x, y)| count(x, y)).collect::<Vec<u32>>();
    let mut all: Vec<(HeatKind, Vec<u32>)> = HeatKind::all()
        .filter(|kind| *kind != HeatKind::Points)
        .map(|kind| (kind, of_pixels(&|x, y| kind.of(work.at(x, y)).unwrap_or_default())))
        .collect();
    if light.is_some() {
        all.push((HeatKind::Points, of_pixels(&|x, y| cells.points_at(x, y))));
    }
    let shown = all.iter().find(|(kind, _)| *kind == flags.of).map_or(&[][..], |(_, counts)| counts);
    let image = picture(shown, flags.size, flags.of.title(), flags.max);
    write_png(&image, path, BitDepth::Eight)?;
    let mut stdout = io::stdout();
    for (kind, counts) in &all {
        writeln!(stdout, "{:<22} {}", kind.title(), Summary::of(counts).text())?;
    }
    Ok(())
}

/// The error for a light that isn't there, which lists the lights that are.
fn no_such_light(error: Error) -> Failure {
    match error {
        Error::NoSuchLight { light, lights } => {
            let hint = format!("the scene has {lights}, counted from 0; `umbrage info` lists them");
            Failure::input(format!("--light: the scene has no light {light}"), hint)
        }
        error => error.into(),
    }
}

/// Draws counts in rows of pixels, with a legend below. The last colour is for `max`, or for a count that few pixels
/// exceed.
fn picture(counts: &[u32], size: Size, title: &str, max: Option<u32>) -> Image {
    let summary = Summary::of(counts);
    let scale = max.map_or_else(|| HeatScale::of(counts), HeatScale::up_to);
    let background = std::iter::repeat_n([0; 3], Legend::height(size.width) as usize * size.width as usize);
    let colors = counts.iter().map(|&count| scale.color(count).map(sixteen_bits));
    let height = size.height + Legend::height(size.width);
    let mut image = Image { width: size.width, height, pixels: colors.chain(background).collect(), ..Image::default() };
    let title = format!("{title}  {}", summary.text());
    Legend { title: &title, scale, highest: summary.highest }.draw(&mut image, size.height);
    image
}

/// Statistics of all counts.
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
