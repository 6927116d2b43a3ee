//! Figures of trust, each beside published results of others, and a list of everything that nobody has judged.

mod cost;
mod figures;
mod input;
mod outside;
mod pairs;
mod rays;
mod repeat;
mod surfaces;
mod unsafe_code;

use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;
use std::thread::available_parallelism;

use anyhow::{Context, Result, ensure};
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use umbrage::rays::SimdLevel;
use umbrage_verify::Random;

use figures::FIGURES;

#[derive(Args, Debug)]
pub(crate) struct TrustFlags {
    /// Only these figures, by number
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    only: Vec<usize>,
    /// How much of what docs/trust.md was made with: 0.01 for a quick look
    #[arg(long, value_name = "SHARE", default_value_t = 1.0)]
    effort: f64,
    /// Which random numbers
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Write the document to a file
    #[arg(long, value_name = "FILE.md")]
    write: Option<PathBuf>,
}

/// A question to answer before trusting a ray tracer.
pub(crate) struct Figure {
    title: &'static str,
    /// Published results of others, with sources.
    elsewhere: &'static str,
    find: fn(&Effort) -> Result<Finding>,
}

/// Our result for a figure.
pub(crate) struct Finding {
    /// Whether it is as it should be.
    holds: bool,
    text: String,
}

impl Finding {
    fn new(holds: bool, text: impl Into<String>) -> Self {
        Self { holds, text: text.into() }
    }
}

/// Number of trials relative to the document's, and their random seed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Effort {
    share: f64,
    seed: u64,
}

impl Effort {
    /// This share of `all`, at least 1.
    fn of(&self, all: u64) -> u64 {
        ((self.share * all as f64) as u64).max(1)
    }

    /// The side of a square, or of a mesh, of a share of the area.
    fn side(&self, all: u32, least: u32) -> u32 {
        ((f64::from(all) * self.share.sqrt()) as u32).clamp(least, all.max(least))
    }

    fn random(&self) -> Random {
        Random::new(self.seed)
    }
}

pub(crate) fn run(flags: &TrustFlags) -> Result<ExitCode> {
    ensure!(flags.effort > 0.0 && flags.effort <= 1000.0, "--effort is a number above 0, and at most 1000");
    if let Some(number) = flags.only.iter().find(|&&number| !(1..=FIGURES.len()).contains(&number)) {
        anyhow::bail!("there is no figure {number}: they are 1 to {}", FIGURES.len());
    }
    let effort = Effort { share: flags.effort, seed: flags.seed };
    let mut document = beginning(effort);
    let progress = ProgressBar::new(FIGURES.len() as u64).with_style(ProgressStyle::with_template("{bar:22} {msg}")?);
    let (mut short, mut asked) = (Vec::new(), 0);
    for (number, figure) in (1..).zip(FIGURES) {
        progress.set_position(number as u64 - 1);
        if !flags.only.is_empty() && !flags.only.contains(&number) {
            continue;
        }
        progress.set_message(format!("{number}. {}", figure.title));
        let finding = (figure.find)(&effort).with_context(|| format!("figure {number}, {}", figure.title))?;
        asked += 1;
        if !finding.holds {
            short.push(number);
        }
        let section = section(number, figure, &finding);
        progress.suspend(|| print!("{section}"));
        document += &section;
    }
    progress.finish_and_clear();
    let summary = if short.is_empty() {
        format!("All {asked} figures are as they should be.")
    } else {
        format!("{} of {asked} figures fall short: {short:?}.", short.len())
    };
    println!("\n{summary}");
    if let Some(path) = &flags.write {
        let _ = write!(document, "\n{summary}\n\n{NOT_JUDGED}");
        std::fs::write(path, document).with_context(|| format!("could not write {}", path.display()))?;
    }
    Ok(if short.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn beginning(Effort { share, seed }: Effort) -> String {
    let levels = SimdLevel::available().iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
    let threads = available_parallelism().map_or(1, usize::from);
    format!(
        "# What can be trusted\n\n\
         {} figures that anyone can reproduce, each beside what others publish. This page is written by\n\n\
         ```sh\n\
         cargo build --release -p umbrage-verify -p umbrage-cli\n\
         cargo run --release -p umbrage-bench -- trust --write docs/trust.md\n\
         ```\n\n\
         which takes half an hour; `--effort 0.01` takes a quick look, and `--only 3,14` asks for some of them. Shown here: \
         effort {share}, seed {seed}, {threads} threads, {} {}, instruction sets {levels}. Times are of this machine and \
         are only there to be compared with one another.\n",
        FIGURES.len(),
        std::env::consts::OS,
        std::env::consts::ARCH,
    )
}

/// The end of the document.
const NOT_JUDGED: &str = "\
## Not judged

- **Looks.** All figures are about triangles, light and shadow. Materials, textures and tone map have tests, and \
[small scenes beside Mitsuba](effects.md), but no figure here.
- **Processors.** The figures are of the processor that is named above. The page's tests compare a \
few pictures of browsers with the processor's ([docs/web.md](web.md)); nothing here is of ARM.
- **GPUs.** No figure here is of one. Tests of their code run on any adapter, Mesa's lavapipe too ([docs/gpu.md](gpu.md)).
- **Numbers below 1e-37** that aren't zero, and scenes beyond the accepted numbers ([ARCHITECTURE.md](../ARCHITECTURE.md)).
- **Fuzzing by coverage.** Mutants come from a corpus and from random numbers; nothing leads them to code that no other has \
reached, and no sanitizer watches the libraries below.
- **Folders that change.** A link that somebody exchanges between its check and its opening is followed, and hard links and \
mounted folders count as inside.
- **Time.** Small files may ask for long work, as millions of instances of a mesh. The fuzzer's 20 s are the only limit that is \
judged.
- **Three options that must meet.** Pairs are complete; of larger combinations there are random ones.
- **The libraries below**, the compiler and Rust's own library: the last figure counts their unsafe code and says no more.
";

fn section(number: usize, figure: &Figure, finding: &Finding) -> String {
    let falls_short = if finding.holds { "" } else { "**Falls short.** " };
    let Figure { title, elsewhere, .. } = figure;
    format!("\n## {number}. {title}\n\n{falls_short}{}\n\n*Elsewhere:* {elsewhere}\n", finding.text)
}

/// A test that takes long, which `cargo run -p ci` runs with `--all` alone.
#[cfg(test)]
mod long {
    use super::*;

    /// Tests the document's claims with a small part of the effort.
    #[test]
    fn every_figure_is_as_it_should_be() {
        let effort = Effort { share: 2e-4, seed: 3 };
        for (number, figure) in (1..).zip(FIGURES) {
            let finding = (figure.find)(&effort).unwrap_or_else(|error| panic!("figure {number}: {error:?}"));
            assert!(finding.holds || figures::NOT_TESTED.contains(&number), "{}", section(number, figure, &finding));
        }
    }
}
