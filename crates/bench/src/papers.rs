//! Repeats the papers' experiments: writes each table to a file of its own, with its command and machine, and reports
//! changes since the last time.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread::available_parallelism;

use anyhow::{Context, Result, bail, ensure};
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};

/// A table or figure of a paper that a command measures.
struct Experiment {
    /// Name of its file.
    name: &'static str,
    /// Name of its command.
    command: &'static str,
    title: &'static str,
    /// Paper and section.
    source: &'static str,
    flags: &'static [&'static str],
    /// Whether it takes `--files`.
    takes_files: bool,
    draws: bool,
    needs_statistics: bool,
}

impl Experiment {
    const fn new(name: &'static str, title: &'static str, source: &'static str) -> Self {
        Self {
            name,
            command: name,
            title,
            source,
            flags: &[],
            takes_files: false,
            draws: false,
            needs_statistics: false,
        }
    }

    /// With another command than the one of its name, or with flags.
    const fn by(self, command: &'static str, flags: &'static [&'static str]) -> Self {
        Self { command, flags, ..self }
    }

    const fn drawn(self) -> Self {
        Self { draws: true, ..self }
    }

    const fn counted(self) -> Self {
        Self { needs_statistics: true, ..self }
    }

    const fn with_files(self) -> Self {
        Self { takes_files: true, ..self }
    }
}

const LIGHT_TRIANGLES: [&str; 9] =
    ["demo:hall", "demo:statue", "demo:forest", "--slices", "1", "--triangles", "32,128,512,4096", "--frames", "3"];

const REORDER_ONE_THREAD: [&str; 12] = [
    "demo:glass",
    "demo:hall",
    "--bounces",
    "1,10",
    "--size",
    "512x512",
    "--frames",
    "3",
    "--rays",
    "16384",
    "--threads",
    "1",
];

/// In the papers' order.
const EXPERIMENTS: [Experiment; 36] = [
    Experiment::new("table1", "A frame, rebuilt and traced", "Guntury and Narayanan 2010, Table 1")
        .with_files()
        .drawn(),
    Experiment::new("two-lights", "A frame with two lights", "Guntury and Narayanan 2010, section 5")
        .by("table1", &["demo:forest", "--lights", "2"]),
    Experiment::new("breakdown", "Where a frame's time goes", "Guntury and Narayanan 2010, Figure 10")
        .with_files()
        .drawn(),
    Experiment::new("light-maps", "Light maps", "Guntury and Narayanan 2010, section 4.1").with_files().drawn(),
    Experiment::new("light-triangles", "Cells of many triangles, in blocks", "Guntury and Narayanan 2010, section 5")
        .by("light-maps", &LIGHT_TRIANGLES),
    Experiment::new("distance", "A light that moves away", "Guntury and Narayanan 2010, Figure 11")
        .by("distance", &["--frames", "3"])
        .drawn(),
    Experiment::new("mapping", "Indirect mapping", "Guntury and Narayanan 2010, section 3.2")
        .by("mapping", &["--all-blocks"])
        .drawn(),
    Experiment::new("cells", "Sizes of cells", "Guntury and Narayanan 2010, section 3").drawn(),
    Experiment::new("camera-triangles", "Tiles of many triangles, in parts", "Guntury and Narayanan 2010, section 5"),
    Experiment::new("growth", "Growth with triangles, pixels and lights", "Guntury and Narayanan 2010, section 5")
        .drawn(),
    // Single rays take seconds a frame.
    Experiment::new("packets", "Packets against single rays", "Wald et al. 2006, Table 3 and Figure 7")
        .by("packets", &["--frames", "2"])
        .drawn(),
    Experiment::new("culling", "What the mailbox and the frustum spare", "Wald et al. 2006, Tables 1 and 4")
        .by("culling", &["--frames", "1"])
        .counted(),
    Experiment::new("density", "Cells for each triangle", "Wald et al. 2006, Figure 6").drawn(),
    Experiment::new("resolution", "More pixels", "Wald et al. 2006, section 4.2"),
    Experiment::new("grid-options", "Macrocells, insertion, splits", "Wald et al. 2006, sections 2.4, 3 and 4.6"),
    Experiment::new("nested", "Grids in cells", "Wald et al. 2006, section 2.4"),
    Experiment::new("models", "Moving models with shading and shadows", "Wald et al. 2006, Figures 8 and 9")
        .with_files(),
    Experiment::new("kd-traversals", "Traversals of the kd-tree", "Horn et al. 2007, Table 2"),
    Experiment::new("kd-bounces", "Mirror bounces", "Horn et al. 2007, Figure 2").drawn(),
    Experiment::new("triangles", "Ray-triangle tests", "Rahikainen 2013, section 2.1"),
    Experiment::new("light-buffer", "The light buffer", "Rahikainen 2013, section 2.3")
        .by("light-buffer", &["--size", "512x512", "--frames", "3"]),
    Experiment::new("queues", "Queues of work", "Parker et al. 1999")
        .by("queues", &["--size", "512x512", "--frames", "3"]),
    Experiment::new("on-demand", "Geometry on demand", "Rahikainen 2013, section 3.1")
        .by("on-demand", &["--size", "256x256", "--frames", "1"]),
    Experiment::new("bounce", "Incoherent rays", "Rahikainen 2013, section 3.2"),
    Experiment::new("reorder", "Re-ordering of secondary rays", "Rahikainen 2013, sections 3.2 to 3.4")
        .by("reorder", &["--size", "512x512", "--frames", "3", "--rays", "16384"]),
    Experiment::new("reorder-one-thread", "Re-ordering on one thread", "Rahikainen 2013, sections 3.2 to 3.4")
        .by("reorder", &REORDER_ONE_THREAD),
    Experiment::new("reorder-tests", "Tests of boxes by re-ordered rays", "Rahikainen 2013, sections 3.2 to 3.4")
        .by("reorder", &["--size", "512x512", "--rays", "16384", "--show", "tests"]),
    Experiment::new("reorder-used", "Lanes that re-ordered rays use", "Rahikainen 2013, sections 3.2 to 3.4")
        .by("reorder", &["--size", "512x512", "--rays", "16384", "--show", "used"]),
    Experiment::new("reorder-triangles", "Triangles of re-ordered rays", "Rahikainen 2013, sections 3.2 to 3.4")
        .by("reorder", &["--size", "512x512", "--rays", "16384", "--show", "triangles"]),
    Experiment::new("kd-entries", "Entry points and culling", "Rahikainen 2013, sections 3.3 and 5"),
    Experiment::new("kd-builders", "Builders of kd-trees", "Rahikainen 2013, section 4"),
    Experiment::new("kd-scaling", "Parallel builds on more threads", "Rahikainen 2013, section 4.2").drawn(),
    Experiment::new("kd-ablations", "The surface area heuristic, part by part", "Rahikainen 2013, section 4.1"),
    Experiment::new("kd-frames", "kd-trees for moving scenes", "Rahikainen 2013, section 4.2"),
    // About one triangle in sixty is seen.
    Experiment::new("kd-seen", "kd-trees of which little is seen", "Hunt, Mark and Fussell 2007")
        .by("kd-frames", &["demo:shatter", "demo:statue", "--zoom", "16", "--rounds", "3"]),
    Experiment::new("kd-moving", "kd-trees that outlive a frame", "Rahikainen 2013, section 4.2")
        .by("kd-moving", &["--rounds", "4", "--poses", "24"])
        .with_files(),
];

#[derive(Args, Debug)]
pub(crate) struct PaperFlags {
    /// Experiments, by the names of their files, such as table1
    #[arg(required = true, value_parser = names())]
    names: Vec<String>,
    #[command(flatten)]
    common: PapersFlags,
}

#[derive(Args, Debug)]
pub(crate) struct PapersFlags {
    /// Folder of the real scenes, for the experiments that take them
    #[arg(long, value_name = "DIR")]
    files: Option<PathBuf>,
    /// The folder that the tables are written to, a file each; charts go to `images` beside it
    #[arg(long, value_name = "DIR", default_value = "crates/papers/docs/tables")]
    docs: PathBuf,
}

fn names() -> clap::builder::PossibleValuesParser {
    clap::builder::PossibleValuesParser::new(EXPERIMENTS.iter().map(|experiment| experiment.name))
}

impl PaperFlags {
    pub(crate) fn run(&self) -> Result<()> {
        self.common.measure(|name| self.names.iter().any(|wanted| wanted == name))
    }
}

impl PapersFlags {
    pub(crate) fn run(&self) -> Result<()> {
        self.measure(|_| true)
    }

    fn measure(&self, is_wanted: impl Fn(&str) -> bool) -> Result<()> {
        let wanted: Vec<_> = EXPERIMENTS.iter().filter(|experiment| is_wanted(experiment.name)).collect();
        fs::create_dir_all(&self.docs).with_context(|| format!("could not make {}", self.docs.display()))?;
        let progress = ProgressBar::new(wanted.len() as u64);
        progress.set_style(ProgressStyle::with_template("{bar:22} {pos} of {len}: {msg}, {elapsed}")?);
        for experiment in wanted {
            progress.set_message(experiment.name);
            progress.tick();
            let said = self.measure_one(experiment).with_context(|| format!("experiment {}", experiment.name))?;
            progress.suspend(|| println!("{}: {said}", experiment.name));
            progress.inc(1);
        }
        progress.finish_and_clear();
        Ok(())
    }

    /// Writes an experiment's file, and returns a description of its changes.
    fn measure_one(&self, experiment: &Experiment) -> Result<String> {
        if experiment.needs_statistics && !cfg!(feature = "statistics") {
            return Ok("left as it is; build with --features statistics to have it counted".to_owned());
        }
        let path = self.docs.join(experiment.name).with_extension("md");
        let stored = fs::read_to_string(&path).unwrap_or_default();
        let document = self.document(experiment)?;
        fs::write(&path, &document).with_context(|| format!("could not write {}", path.display()))?;
        Ok(if stored.is_empty() { "new".to_owned() } else { differences(&stored, &document).to_string() })
    }

    fn document(&self, experiment: &Experiment) -> Result<String> {
        let Experiment { name, command, title, source, .. } = experiment;
        let mut arguments: Vec<String> = vec![(*command).to_owned()];
        arguments.extend(experiment.flags.iter().map(|&flag| flag.to_owned()));
        let mut shown = arguments.clone();
        if let (true, Some(files)) = (experiment.takes_files, &self.files) {
            arguments.extend(["--files".to_owned(), path_text(files)?]);
            shown.extend(["--files", "SCENES"].map(str::to_owned));
        }
        if experiment.draws {
            let images = self.docs.parent().unwrap_or(Path::new(".")).join("images");
            fs::create_dir_all(&images).with_context(|| format!("could not make {}", images.display()))?;
            arguments.extend(["--plot".to_owned(), path_text(&images.join(name).with_extension("svg"))?]);
        }
        arguments.extend(["--form", "markdown"].map(str::to_owned));
        // Each in a process of its own, so that none finds the memory of another.
        let program = std::env::current_exe().context("this program isn't found")?;
        let output = Command::new(program).args(&arguments).stderr(Stdio::inherit()).output()?;
        ensure!(output.status.success(), "`umbrage-bench {}` failed", arguments.join(" "));
        let table = String::from_utf8(output.stdout).context("its table is no text")?;
        let mut text = format!("# {title}\n\n{source}. `umbrage-bench {}`, commit {}, ", shown.join(" "), commit());
        let cores = available_parallelism().map_or(1, usize::from);
        let _ = write!(
            text,
            "{}, {cores} {}.\n\n{}",
            processor(),
            if cores == 1 { "core" } else { "cores" },
            table.trim_end()
        );
        if experiment.draws {
            let _ = write!(text, "\n\n![{title}](../images/{name}.svg)");
        }
        Ok(text + "\n")
    }
}

fn path_text(path: &Path) -> Result<String> {
    match path.to_str() {
        Some(text) => Ok(text.to_owned()),
        None => bail!("{} is no text", path.display()),
    }
}

/// The commit of the working directory, and whether the directory has changed since.
fn commit() -> String {
    let git = |arguments: &[&str]| {
        let output = Command::new("git").args(arguments).stderr(Stdio::null()).output().ok()?;
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    let Some(commit) = git(&["rev-parse", "--short=10", "HEAD"]) else { return "unknown".to_owned() };
    let is_changed =
        git(&["status", "--porcelain", "--", "*.rs", "*.wgsl", "*.toml"]).is_none_or(|text| !text.is_empty());
    if is_changed { format!("{commit} and changes") } else { commit }
}

/// Name of the processor, if the system tells it.
fn processor() -> String {
    let text = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = text.lines().find_map(|line| line.strip_prefix("model name")?.split_once(": "));
    name.map_or_else(|| std::env::consts::ARCH.to_owned(), |(_, name)| name.trim().to_owned())
}

/// How two tables differ.
#[derive(Debug, Default, PartialEq)]
struct Differences {
    /// Ratios of new numbers to old ones, with their rows and columns, the farthest from one first.
    ratios: Vec<(f64, String)>,
    /// Whether there are other rows or columns.
    is_other_table: bool,
}

/// How a document's table differs from that of a stored one.
fn differences(stored: &str, document: &str) -> Differences {
    let [stored, new] = [stored, document].map(cells);
    let Some((titles, rows)) = new.split_first() else { return Differences::default() };
    let mut differences = Differences { is_other_table: stored.first() != Some(titles), ..Differences::default() };
    if differences.is_other_table {
        return differences;
    }
    differences.is_other_table = stored.len() != new.len();
    for (old, new) in stored[1..].iter().zip(rows) {
        for ((title, old), value) in titles.iter().zip(old).zip(new) {
            match (old.parse::<f64>(), value.parse::<f64>()) {
                (Ok(old), Ok(value)) if old > 0.0 && value > 0.0 => {
                    differences.ratios.push((value / old, format!("{} {title}", new[0])));
                }
                (Ok(_), Ok(_)) => {}
                _ => differences.is_other_table |= old != value,
            }
        }
    }
    let distance = |ratio: &(f64, String)| ratio.0.ln().abs();
    differences.ratios.sort_by(|a, b| distance(b).total_cmp(&distance(a)));
    differences
}

/// The cells of a Markdown table, row by row, its titles first.
fn cells(document: &str) -> Vec<Vec<&str>> {
    let rows = document.lines().filter_map(|line| line.strip_prefix("| ")?.strip_suffix(" |"));
    rows.map(|row| row.split(" | ").map(str::trim).collect())
        .filter(|row: &Vec<&str>| !row[0].starts_with("--"))
        .collect()
}

impl std::fmt::Display for Differences {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        /// Ratio by which two runs of the same program may differ.
        const NOISE: f64 = 1.3;
        if self.is_other_table {
            f.write_str("other rows, columns or words than in the stored table; ")?;
        }
        let far = |ratio: f64| !(1.0 / NOISE..=NOISE).contains(&ratio);
        let count = self.ratios.iter().filter(|(ratio, _)| far(*ratio)).count();
        write!(f, "{count} of {} numbers differ by more than {NOISE} times", self.ratios.len())?;
        for (ratio, what) in self.ratios.iter().take_while(|(ratio, _)| far(*ratio)).take(5) {
            write!(f, "\n    {what}: {ratio:.2} of what it was")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use clap::Parser;

    use super::*;
    use crate::{Flags, table};

    const STORED: &str =
        "# Title\n\n| scene | n | ms |\n| --- | --- | --- |\n| cloth | 4 | 2.0 |\n| hall | 5 | 0.0 |\n";

    #[test]
    fn what_differs_is_said() {
        assert_eq!(differences(STORED, STORED).to_string(), "0 of 3 numbers differ by more than 1.3 times");
        let slower = STORED.replace("2.0", "3.0");
        let said = differences(STORED, &slower).to_string();
        assert!(said.starts_with("1 of 3") && said.ends_with("cloth ms: 1.50 of what it was"), "{said}");
        for other in
            [STORED.replace("cloth", "clothes"), STORED.replace("| ms", "| s"), STORED.replace("| hall", "hall")]
        {
            assert!(differences(STORED, &other).is_other_table, "{other}");
        }
    }

    #[test]
    fn experiments_are_commands() {
        let command = <Flags as clap::CommandFactory>::command();
        for experiment in EXPERIMENTS {
            let command = command.find_subcommand(experiment.command).unwrap();
            let takes = |flag: &str| command.get_arguments().any(|argument| argument.get_id() == flag);
            assert!(takes("form"), "{}", experiment.name);
            assert!(takes("files") || !experiment.takes_files, "{}", experiment.name);
            assert!(takes("plot") || !experiment.draws, "{}", experiment.name);
        }
    }

    /// Flags with which a command measures little.
    fn little(command: &str) -> &'static str {
        match command {
            "table1 --lights" => "2 demo:shatter?triangles=500 --size 64x64 --frames 1",
            "distance" => "demo:shatter?triangles=500 --distances 0.5,4 --rays 16 --size 64x64 --frames 1",
            "growth" => "demo:shatter --triangles 300,600 --sides 16,32 --lights 1,2 --frames 1",
            "camera-triangles" => "demo:shatter?triangles=500 --triangles 32 --sides 64 --frames 1",
            "resolution" => "demo:shatter?triangles=500 --sides 32,64 --frames 1",
            "nested" => "demo:shatter?triangles=500 --single --size 64x64 --frames 1",
            "light-buffer" => "demo:shatter?triangles=500 --cells 8 --size 64x64 --frames 1",
            "queues" => "demo:shatter?triangles=500 --rays 16 --size 64x64 --frames 1",
            "reorder" => "demo:glass?triangles=500 --bounces 0,1 --rays 512 --size 64x64 --frames 1",
            "on-demand" => {
                "demo:hall?triangles=500 --part 4KiB --cached-part 8KiB --shares 1,4 --size 32x32 --frames 1"
            }
            "kd-bounces" => "demo:hall?triangles=500 --bounces 2 --size 64x64 --rounds 1",
            "kd-entries" => "demo:shatter?triangles=500 --size 128x128 --rounds 1",
            "kd-moving" => "demo:marbles?triangles=500 --poses 2 --size 64x64 --rounds 1",
            "kd-gpu" => "demo:shatter?triangles=500 --bounces 1 --size 32x32 --rounds 1",
            "triangles" => "demo:shatter?triangles=500 --size 64x64 --rounds 1",
            name if name.starts_with("kd-") || name.starts_with("bounce") => {
                "demo:shatter?triangles=500 --size 32x32 --rounds 1"
            }
            _ => "demo:shatter?triangles=500 --size 64x64 --frames 1",
        }
    }

    /// Commands of the table of techniques, and those that write tables of results.
    fn commands() -> BTreeSet<String> {
        let document = Path::new(env!("CARGO_MANIFEST_DIR")).join("../papers/docs/README.md");
        let document = fs::read_to_string(document).unwrap();
        let rows = document.lines().filter(|line| line.starts_with('|'));
        let words = rows.flat_map(|row| row.split('`').skip(1).step_by(2));
        let of_techniques = words.filter_map(|word| word.strip_prefix("umbrage-bench "));
        of_techniques.chain(EXPERIMENTS.iter().map(|experiment| experiment.command)).map(str::to_owned).collect()
    }

    /// Runs a command on little input; it must write a table with rows.
    fn measures(command: &str) -> Result<()> {
        let words = ["umbrage-bench"].into_iter().chain(command.split(' ')).chain(little(command).split(' '));
        let command = Flags::try_parse_from(words.chain(["--form", "csv"]))?.command;
        table::WRITTEN.take();
        crate::run(command)?;
        let lines = table::WRITTEN.take();
        ensure!(lines.len() > 1, "no rows: {lines:?}");
        Ok(())
    }

    /// Whether a command reports that this program, or this machine, has no part that it needs.
    fn is_lacking(command: &str, error: &anyhow::Error) -> bool {
        let counts_nothing = command == "culling" && !cfg!(feature = "statistics");
        counts_nothing || matches!(error.downcast_ref(), Some(umbrage_peers::Error::NotFound { .. }))
    }

    #[test]
    fn every_command_of_the_papers_runs() {
        let commands = commands();
        assert!(commands.len() > 30, "{commands:?}");
        for command in commands.iter().filter(|command| *command != "kd-gpu") {
            match measures(command) {
                Ok(()) => {}
                Err(error) if is_lacking(command, &error) => println!("{command}: not run: {error}"),
                Err(error) => panic!("{command}: {error:?}"),
            }
        }
    }

    mod long {
        use umbrage_gpu::Adapter;

        #[test]
        fn the_command_of_the_papers_that_needs_a_gpu_runs() {
            assert!(super::commands().contains("kd-gpu"));
            match Adapter::find("") {
                Ok(_) => super::measures("kd-gpu").unwrap(),
                Err(error) => eprintln!("not run: {error}"),
            }
        }
    }
}
