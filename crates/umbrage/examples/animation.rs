//! An animation without a window: a second of a scene as a GIF.
//!
//! `cargo run --release --example animation -- OUTPUT.gif`; numbered files are `OUTPUT.%03d.png` or so, and `.apng`,
//! `.jpg`, `.webp`, `.exr`, `.mp4` (through ffmpeg) and `.y4m` are written too.

use std::error::Error;
use std::path::PathBuf;

use umbrage::output::{Format, FrameRate, Options, Picture, Target, Writer};
use umbrage::{Renderer, Settings};

const FRAMES_PER_SECOND: u32 = 10;

fn main() -> Result<(), Box<dyn Error>> {
    let default = || std::env::temp_dir().join("umbrage-animation.gif");
    let path = std::env::args_os().nth(1).map_or_else(default, PathBuf::from);
    let format = Format::of_path(&path).ok_or("the name's end says no format")?;

    // A file that glTF, OBJ, PLY or STL readers know does as well.
    let scene = umbrage::open("demo:marbles?triangles=3000")?;
    let settings = Settings { width: 160, height: 90, samples: 2, ..Settings::default() };
    let rate = FrameRate::new(FRAMES_PER_SECOND, 1).ok_or("no frames a second")?;
    let options = Options { rate, ..Options::default() };
    let frames = 0..FRAMES_PER_SECOND;
    let mut writer = Writer::create(&Target::Path(path.clone()), format, &frames, &settings, &options)?;
    let (mut renderer, mut picture) = (Renderer::default(), Picture::default());
    for frame in frames {
        let seconds = f64::from(frame) / f64::from(FRAMES_PER_SECOND);
        renderer.render_picture(&scene, seconds, &settings, (writer.form(), &mut picture))?;
        writer.write(frame, &picture)?;
    }
    // Before this there is no file.
    writer.finish()?;
    println!("{}", path.display());
    Ok(())
}
