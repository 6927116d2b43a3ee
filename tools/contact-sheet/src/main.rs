//! Many scenes in one labelled picture: `cargo run --release -p contact-sheet -- SCENES… -o sheet.png`.
//!
//! A scene that fails gets a red tile with its error, and the exit code is 1.
#![forbid(unsafe_code)]

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use dot_font::Canvas;
use umbrage::output::BitDepth;
use umbrage::{Image, Renderer, Settings};

/// Renders scenes, animated ones at several times, into one labelled picture
#[derive(Debug, Parser)]
struct Flags {
    /// Scene files, folders of numbered ones, or demo:NAME
    #[arg(required = true)]
    scenes: Vec<PathBuf>,
    /// The PNG to write
    #[arg(short, long, default_value = "sheet.png")]
    output: PathBuf,
    /// Which moments of animated scenes are shown, as fractions of the duration
    #[arg(long, value_delimiter = ',', default_value = "0,0.5,0.9", value_parser = fraction)]
    times: Vec<f64>,
    /// Width and height of a tile in pixels
    #[arg(long, default_value = "320x180", value_parser = size)]
    size: [u32; 2],
    /// Tiles in a row [default: about a square's]
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=64))]
    columns: Option<u32>,
    /// Camera rays for each pixel
    #[arg(long, default_value = "4", value_parser = clap::value_parser!(u32).range(1..=4096))]
    samples: u32,
    /// Mirrors and surfaces of glass that light may come by, one after the other
    #[arg(long, default_value_t = Settings::STILL_BOUNCES)]
    bounces: u32,
}

fn fraction(text: &str) -> Result<f64, String> {
    let fraction = text.parse::<f64>().ok().filter(|fraction| (0.0..=1.0).contains(fraction));
    fraction.ok_or_else(|| "give fractions from 0 to 1".to_owned())
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let parsed = text.split_once('x').and_then(|(width, height)| Some([width.parse().ok()?, height.parse().ok()?]));
    let inside = parsed.filter(|size| size.iter().all(|side| (16..=2048).contains(side)));
    inside.ok_or_else(|| "give a size from 16x16 to 2048x2048, such as 320x180".to_owned())
}

fn main() -> ExitCode {
    match run(&Flags::parse()) {
        Ok(0) => ExitCode::SUCCESS,
        Ok(failed) => {
            eprintln!("{failed} scenes failed");
            ExitCode::FAILURE
        }
        Err(why) => {
            eprintln!("error: {why}");
            ExitCode::from(2)
        }
    }
}

/// A tile: a picture, or the reason why it is missing.
struct Tile {
    label: String,
    picture: Result<Image, String>,
}

/// Writes the sheet, and returns the number of scenes that failed.
fn run(flags: &Flags) -> Result<usize, String> {
    let mut renderer = Renderer::default();
    let mut tiles = Vec::new();
    let mut failed = 0;
    for scene in &flags.scenes {
        let name = scene.file_name().unwrap_or(scene.as_os_str()).to_string_lossy();
        match shots(scene, flags, &mut renderer) {
            Ok(shots) => {
                println!("{}: {} tiles", scene.display(), shots.len());
                tiles.extend(shots.into_iter().map(|(seconds, picture)| {
                    let label = seconds.map_or_else(|| name.to_string(), |seconds| format!("{name} {seconds:.2} s"));
                    Tile { label, picture: Ok(picture) }
                }));
            }
            Err(why) => {
                eprintln!("{}: {why}", scene.display());
                failed += 1;
                tiles.push(Tile { label: name.to_string(), picture: Err(why) });
            }
        }
    }
    let sheet = sheet(&tiles, flags)?;
    umbrage::output::write_png(&sheet, &flags.output, BitDepth::Eight).map_err(|error| error.to_string())?;
    println!("{}: {}x{} pixels", flags.output.display(), sheet.width, sheet.height);
    Ok(failed)
}

/// The scene's pictures, each with its time in seconds if the scene is animated.
fn shots(address: &Path, flags: &Flags, renderer: &mut Renderer) -> Result<Vec<(Option<f64>, Image)>, String> {
    let scene = umbrage::open(address).map_err(|error| error.to_string())?;
    for warning in scene.warnings() {
        eprintln!("{}: warning: {warning}", address.display());
    }
    let duration = scene.duration_seconds();
    let [width, height] = flags.size;
    let settings = Settings { width, height, samples: flags.samples, bounces: flags.bounces, ..Settings::default() };
    let times = if duration > 0.0 { flags.times.as_slice() } else { &[0.0] };
    let shot = |fraction: &f64| {
        let seconds = fraction * duration;
        let film = renderer.render(&scene, seconds, &settings).map_err(|error| error.to_string())?;
        Ok(((duration > 0.0).then_some(seconds), film.develop(&settings)))
    };
    times.iter().map(shot).collect()
}

fn sheet(tiles: &[Tile], flags: &Flags) -> Result<Image, String> {
    const GAP: u32 = 4;
    const DARK: [u16; 3] = [0x1400; 3];
    const FAILED: [u16; 3] = [0x9000, 0x1800, 0x1800];
    let [tile_width, tile_height] = flags.size;
    let (cell_width, cell_height) = (tile_width + GAP, tile_height + LINE + GAP);
    // A sheet of about equal width and height.
    let square = (tiles.len() as f64 * f64::from(cell_height) / f64::from(cell_width)).sqrt().ceil() as u32;
    let columns = flags.columns.unwrap_or(square).clamp(1, tiles.len().max(1) as u32);
    let rows = (tiles.len() as u32).div_ceil(columns);
    let (width, height) = (columns * cell_width + GAP, rows * cell_height + GAP);
    let limit = Settings::MAX_SIDE;
    if width.max(height) > limit {
        return Err(format!("a sheet of {width}x{height} pixels is larger than {limit}; use smaller tiles"));
    }
    let mut pixels = vec![DARK; width as usize * height as usize];
    let mut canvas = Canvas { pixels: &mut pixels, width };
    for (index, tile) in (0..).zip(tiles) {
        let (x, y) = (GAP + index % columns * cell_width, GAP + index / columns * cell_height);
        write(&mut canvas, [x, y], [tile_width, LINE], &tile.label);
        let y = y + LINE;
        match &tile.picture {
            Ok(picture) => {
                let rows = canvas.pixels.chunks_mut(width as usize).skip(y as usize);
                for (row, picture) in rows.zip(picture.pixels.chunks(picture.width as usize)) {
                    row[x as usize..][..picture.len()].copy_from_slice(picture);
                }
            }
            Err(why) => {
                canvas.fill([x, y], flags.size, FAILED);
                let inner = flags.size.map(|side| side.saturating_sub(2 * GAP));
                write(&mut canvas, [x + GAP, y + GAP], inner, why);
            }
        }
    }
    Ok(Image { width, height, pixels, ..Image::default() })
}

/// Distance between lines of text: a letter's height and a gap.
const LINE: u32 = dot_font::HEIGHT + 3;

/// Writes text in lines that are broken at any letter; lines that don't fit are left out.
fn write(canvas: &mut Canvas<'_, [u16; 3]>, [x, y]: [u32; 2], [width, height]: [u32; 2], text: &str) {
    const BRIGHT: [u16; 3] = [0xe000; 3];
    let letters: Vec<char> = text.chars().collect();
    let lines = letters.chunks((width / dot_font::ADVANCE).max(1) as usize);
    for (line, letters) in (0..height / LINE).zip(lines) {
        canvas.text([x, y + line * LINE], 1, &String::from_iter(letters), BRIGHT);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn failed_scenes_get_a_red_tile() {
        let folder = tempfile::tempdir().unwrap();
        let broken = folder.path().join("broken.obj");
        std::fs::write(&broken, "f 1 2 3\n").unwrap();
        let output = folder.path().join("sheet.png");
        let flags = Flags::parse_from(["contact-sheet".as_ref(), broken.as_path(), "-o".as_ref(), &output]);
        assert_eq!(run(&flags), Ok(1));
        assert!(output.exists());
        let why = "broken".to_owned();
        let sheet = sheet(&[Tile { label: String::new(), picture: Err(why) }], &flags).unwrap();
        let middle = sheet.pixels[(sheet.height / 2 * sheet.width + sheet.width / 2) as usize];
        assert!(middle[0] > 2 * middle[1] && middle[1] == middle[2], "{middle:?}");
    }

    #[test]
    fn flags_have_limits() {
        assert!(fraction("1.5").is_err() && fraction("nan").is_err() && fraction("0.9") == Ok(0.9));
        assert!(size("1x1").is_err() && size("9999x20").is_err() && size("320x180") == Ok([320, 180]));
    }
}
