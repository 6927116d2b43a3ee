//! Times of whole pictures, from the scene to the file: of one build of the command, or of two in turn.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};
use clap::Args;
use serde::Deserialize;

use crate::flags::{OutputFlags, SceneFlags};
use crate::measure::median;
use crate::table::{Cell, Row, row};

#[derive(Args, Debug)]
pub(crate) struct PictureFlags {
    #[command(flatten)]
    scenes: SceneFlags,
    /// The command that renders [default: `umbrage` beside this program]
    #[arg(long, value_name = "PROGRAM")]
    program: Option<PathBuf>,
    /// Another build of it, such as one of an older commit; both render each scene in turn
    #[arg(long, value_name = "PROGRAM")]
    against: Option<PathBuf>,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "1024x1024")]
    size: String,
    /// Camera rays for each pixel
    #[arg(long, value_name = "N", default_value = "1")]
    samples: u32,
    /// How often rays go on from mirrors and through glass
    #[arg(long, value_name = "N", default_value = "0")]
    bounces: u32,
    /// Frames of each run; one more comes first and doesn't count
    #[arg(long, value_name = "N", default_value = "8", value_parser = clap::value_parser!(u32).range(1..))]
    frames: u32,
    /// Runs of each build
    #[arg(long, value_name = "N", default_value = "3", value_parser = clap::value_parser!(u32).range(1..))]
    rounds: u32,
    #[command(flatten)]
    output: OutputFlags,
}

/// The command's output of `--stats json`.
#[derive(Deserialize)]
struct Run {
    engine: String,
    threads: usize,
    open_milliseconds: f64,
    frames: Vec<Frame>,
}

#[derive(Deserialize)]
struct Frame {
    render_milliseconds: f64,
    write_milliseconds: f64,
    stages: Vec<Stage>,
}

#[derive(Deserialize)]
struct Stage {
    name: String,
    milliseconds: f64,
}

/// Milliseconds under the names of columns.
type Times = Vec<(String, f64)>;

impl PictureFlags {
    pub(crate) fn run(&self) -> Result<()> {
        let own = self.program.clone().map_or_else(beside_this_program, Ok)?;
        let builds: Vec<(&str, &Path)> = match &self.against {
            Some(against) => vec![("the other", against), ("this", &own)],
            None => vec![("this", &own)],
        };
        let Self { size, samples, frames, rounds, .. } = self;
        let conditions =
            format!("{size}, samples {samples}, medians of {rounds} runs of {frames} frames in milliseconds");
        let mut table = self.output.start_without_chart(&conditions)?;
        let folder = tempfile::tempdir()?;
        let mut on = None;
        for scene in self.scenes.addresses() {
            let mut runs: Vec<Vec<Run>> = builds.iter().map(|_| Vec::new()).collect();
            for _ in 0..*rounds {
                for ((_, program), runs) in builds.iter().zip(&mut runs) {
                    runs.push(self.render(program, &scene, folder.path()).with_context(|| format!("scene {scene}"))?);
                }
            }
            on = runs.iter().flatten().next().map(|run| format!("On {} threads, {}.", run.threads, run.engine));
            let times: Vec<Times> = runs.iter().map(|runs| medians(runs)).collect();
            for ((build, _), times) in builds.iter().zip(&times) {
                table.push(columns(&scene, build, times.iter().map(|(name, time)| (name, Cell::from(*time)))))?;
            }
            if let [other, this] = times.as_slice() {
                let ratio = |name: &str, time: f64| {
                    other.iter().find(|(stage, _)| stage == name).map(|(_, other)| time / other)
                };
                let ratios = this.iter().map(|(name, time)| (name, Cell::from(ratio(name, *time))));
                table.push(columns(&scene, "this by the other", ratios))?;
            }
        }
        let notes = [
            "rest: of rendering what no stage has; write: while the next frame is rendered, so it isn't in rendering.",
            on.as_deref().unwrap_or_default(),
        ];
        Ok(table.finish(&notes)?)
    }

    /// Frames of a scene by one build.
    fn render(&self, program: &Path, scene: &str, folder: &Path) -> Result<Run> {
        let mut command = Command::new(program);
        command.args(["render", scene, "--stats", "json", "--size", &self.size]);
        command.args(["--samples", &self.samples.to_string(), "--bounces", &self.bounces.to_string()]);
        command.args(["--frames", &format!("0..={}", self.frames), "-o"]).arg(folder.join("%04d.png"));
        let output = command.output().with_context(|| format!("could not start {}", program.display()))?;
        let said = String::from_utf8_lossy(&output.stderr);
        ensure!(output.status.success(), "{}", said.trim().trim_start_matches("error: "));
        serde_json::from_slice(&output.stdout).with_context(|| format!("what {} says of itself", program.display()))
    }
}

/// The command that is built with this program.
fn beside_this_program() -> Result<PathBuf> {
    let program = std::env::current_exe()?.with_file_name(format!("umbrage{}", std::env::consts::EXE_SUFFIX));
    ensure!(
        program.exists(),
        "there is no {}: build it with `cargo build --release -p umbrage-cli`, or name another with --program",
        program.display()
    );
    Ok(program)
}

fn columns<'a>(scene: &str, build: &str, times: impl Iterator<Item = (&'a String, Cell)>) -> Row {
    let mut row = row![("scene", scene), ("build", build)];
    row.extend(times.map(|(name, cell)| (name.clone(), cell)));
    row
}

/// Medians of each stage, over the frames of all runs except the first of each.
fn medians(runs: &[Run]) -> Times {
    let frames = || runs.iter().flat_map(|run| run.frames.iter().skip(1));
    let Some(first) = frames().next() else { return Times::new() };
    let mut times = vec![("open".to_owned(), median(runs.iter().map(|run| run.open_milliseconds)))];
    for Stage { name, .. } in &first.stages {
        let of_stage = frames().flat_map(|frame| frame.stages.iter().filter(|stage| stage.name == *name));
        times.push((name.clone(), median(of_stage.map(|stage| stage.milliseconds))));
    }
    let rest =
        |frame: &Frame| frame.render_milliseconds - frame.stages.iter().map(|stage| stage.milliseconds).sum::<f64>();
    times.push(("rest".to_owned(), median(frames().map(rest))));
    times.push(("render".to_owned(), median(frames().map(|frame| frame.render_milliseconds))));
    times.push(("write".to_owned(), median(frames().map(|frame| frame.write_milliseconds))));
    times
}
