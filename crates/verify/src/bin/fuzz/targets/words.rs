//! Words of command lines.

use std::fmt::{Debug, Display};
use std::path::{Path, PathBuf};
use std::process::{self, Stdio};
use std::str::FromStr;
use std::time::{Duration, Instant};

use anyhow::{Result, bail, ensure};
use umbrage::output::{FrameRate, NumberedPath};
use umbrage::rays::SimdLevel;
use umbrage::scene::check_lights;
use umbrage::spec::{BackgroundSpec, CameraSpec, LightSpec};
use umbrage::{OptionValues, Structure, ToneMap};
use umbrage_papers::structures;
use umbrage_verify::Random;

use super::{Answer, Target};
use crate::mutate::{any, changed_words, written_number};
use crate::worker::Workplace;

/// Values of flags.
const VALUES: &str = "\
    point:1,2,3:40:1,0.5,0 sun:-1,-2,-1 spot:0,3,0:0,0,0:40:500:noshadow 9,4,9:0,1,0:30 0 1 cpu #ff8000 0.5,0.5,0.5 sky 24 \
    30000/1001 0..2 0..=1 4x4 8 16 32 neutral clip gif exr y4m apng a.gif a_%02d.png a.exr %04d.exr - bvh grid listed \
    kdtree:lazy=64 listed:slices=3,light-rays=48 short-stack:8 444 json text all none";

/// A value: unchanged, changed, or a number.
fn value(random: &mut Random) -> String {
    let values: Vec<&str> = VALUES.split_whitespace().collect();
    let (seed, other) = (any(random, &values), any(random, &values));
    match random.below(4) {
        0 => written_number(random),
        1 => String::from_utf8_lossy(&changed_words(random, seed.as_bytes(), other.as_bytes())).into_owned(),
        _ => (*seed).to_owned(),
    }
}

/// The library's parsers of structures, lights, cameras and the like, and its table of options.
pub(crate) struct Options;

impl Target for Options {
    fn run(&mut self, random: &mut Random, _: &mut Workplace<'_>) -> Result<Answer> {
        let text = value(random);
        let light = said_again::<LightSpec>(&text)?;
        if let Some(light) = &light {
            check_lights(&[light.light(glam::Vec3::ONE, 3.0)])?;
        }
        let is_camera = said_again::<CameraSpec>(&text)?.is_some_and(|camera| matches!(camera, CameraSpec::LookAt(_)));
        let is_background =
            said_again::<BackgroundSpec>(&text)?.is_some_and(|of| !matches!(of, BackgroundSpec::File(_)));
        let is_name = said_again::<ToneMap>(&text)?.is_some() || text.parse::<SimdLevel>().is_ok();
        let is_number = said_again::<FrameRate>(&text)?.is_some();
        let is_path = NumberedPath::parse(Path::new(&text)).is_ok_and(|path| path.is_some());
        let (known, number) = (structures(), random.below(structures().iter().len()));
        let mut structure = known.parse(&text).unwrap_or(known.iter().nth(number).cloned().unwrap_or_default());
        let options: Vec<_> = known.iter().flat_map(Structure::options).collect();
        let option = any(random, &options);
        let value = match &option.values {
            OptionValues::Names(names) if random.below(2) == 0 => any(random, &names()).0.to_owned(),
            _ => value(random),
        };
        let before = structure.clone();
        let is_set = structure.set_option(option.name, &value).is_ok();
        ensure!(is_set || structure == before, "{} is refused {value} and changes", option.name);
        ensure!(known.parse(&structure.to_string()).as_ref() == Ok(&structure), "{structure} is not what it says");
        let is_accepted = is_camera || is_background || is_name || is_number || is_path || is_set || light.is_some();
        Ok(if is_accepted { Answer::Accepted } else { Answer::Refused })
    }
}

/// Parses a text, if it can be parsed, and checks that the value's own text parses to the same value.
fn said_again<T: FromStr + Display + Debug + PartialEq>(text: &str) -> Result<Option<T>> {
    let Ok(value) = text.parse::<T>() else { return Ok(None) };
    let again = value.to_string();
    ensure!(again.parse::<T>().is_ok_and(|parsed| parsed == value), "`{text}` is {value:?}, which says `{again}`");
    Ok(Some(value))
}

/// Command lines for the program `umbrage` beside this one, made of the flags in its help.
pub(crate) struct Command {
    program: PathBuf,
    flags: Vec<String>,
}

impl Command {
    /// Time limit of a picture of a few pixels.
    const PATIENCE: Duration = Duration::from_secs(10);

    pub(crate) fn open(place: &Workplace<'_>) -> Result<Self> {
        let program = std::env::current_exe()?.with_file_name(format!("umbrage{}", std::env::consts::EXE_SUFFIX));
        ensure!(program.is_file(), "{} is not there: build umbrage-cli as this program was", program.display());
        std::fs::create_dir(place.folder.join("pictures"))?;
        let help = process::Command::new(&program).args(["render", "--help"]).output()?.stdout;
        let help = String::from_utf8(help)?;
        let words = help.split(|c: char| c != '-' && !c.is_ascii_lowercase());
        Ok(Self { program, flags: words.filter(|word| word.starts_with("--")).map(str::to_owned).collect() })
    }
}

impl Target for Command {
    fn run(&mut self, random: &mut Random, place: &mut Workplace<'_>) -> Result<Answer> {
        let mut words = ["render", "demo:cloth?triangles=100"].map(str::to_owned).to_vec();
        for _ in 0..1 + random.below(3) {
            words.push(any(random, &self.flags).clone());
            if random.below(4) > 0 {
                words.push(value(random));
            }
        }
        // The last value of a flag counts; these keep the work small.
        words.extend(["--size", "4x4", "--samples", "1", "--threads", "2"].map(str::to_owned));
        if !words.iter().any(|word| word == "--time") {
            words.extend(["--frames", "0..1"].map(str::to_owned));
        }
        let errors = place.folder.join("said");
        let started = Instant::now();
        let mut command = process::Command::new(&self.program)
            .current_dir(place.folder.join("pictures"))
            .args(&words)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(std::fs::File::create(&errors)?)
            .spawn()?;
        let status = loop {
            match command.try_wait()? {
                Some(status) => break status,
                None if started.elapsed() > Self::PATIENCE => {
                    command.kill()?;
                    command.wait()?;
                    bail!("{}: takes over {} s", words.join(" "), Self::PATIENCE.as_secs());
                }
                None => std::thread::sleep(Duration::from_millis(1)),
            }
        };
        let said = String::from_utf8_lossy(&std::fs::read(errors)?).into_owned();
        match status.code() {
            Some(0) => Ok(Answer::Accepted),
            Some(2) if said.starts_with("error") => Ok(Answer::Refused),
            _ => bail!("{}: {status}: {said}", words.join(" ")),
        }
    }
}
