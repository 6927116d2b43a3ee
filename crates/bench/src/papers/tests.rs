//! Whether tables are compared as documented, and whether each command of the papers' table runs.

use std::collections::BTreeSet;

use clap::Parser;

use super::*;
use crate::{Flags, table};

const STORED: &str = "# Title\n\n| scene | n | ms |\n| --- | --- | --- |\n| cloth | 4 | 2.0 |\n| hall | 5 | 0.0 |\n";

#[test]
fn what_differs_is_said() {
    assert_eq!(differences(STORED, STORED).to_string(), "0 of 3 numbers differ by more than 1.3 times");
    let slower = STORED.replace("2.0", "3.0");
    let said = differences(STORED, &slower).to_string();
    assert!(said.starts_with("1 of 3") && said.ends_with("cloth ms: 1.50 of what it was"), "{said}");
    for other in [STORED.replace("cloth", "clothes"), STORED.replace("| ms", "| s"), STORED.replace("| hall", "hall")] {
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
        "table1 --lights" => "2 demo:cloth?triangles=500 --size 64x64 --frames 1",
        "distance" => "demo:cloth?triangles=500 --distances 0.5,4 --rays 16 --size 64x64 --frames 1",
        "growth" => "demo:cloth --triangles 300,600 --sides 16,32 --lights 1,2 --frames 1",
        "camera-triangles" => "demo:cloth?triangles=500 --triangles 32 --sides 64 --frames 1",
        "resolution" => "demo:cloth?triangles=500 --sides 32,64 --frames 1",
        "nested" => "demo:cloth?triangles=500 --single --size 64x64 --frames 1",
        "light-buffer" => "demo:cloth?triangles=500 --cells 8 --size 64x64 --frames 1",
        "queues" => "demo:cloth?triangles=500 --rays 16 --size 64x64 --frames 1",
        "reorder" => "demo:glass?triangles=500 --bounces 0,1 --rays 512 --size 64x64 --frames 1",
        "on-demand" => "demo:hall?triangles=500 --part 4KiB --cached-part 8KiB --shares 1,4 --size 32x32 --frames 1",
        "kd-bounces" => "demo:hall?triangles=500 --bounces 2 --size 64x64 --rounds 1",
        "kd-entries" => "demo:cloth?triangles=500 --size 128x128 --rounds 1",
        "kd-moving" => "demo:marbles?triangles=500 --poses 2 --size 64x64 --rounds 1",
        "kd-gpu" => "demo:cloth?triangles=500 --bounces 1 --size 32x32 --rounds 1",
        "triangles" => "demo:cloth?triangles=500 --size 64x64 --rounds 1",
        name if name.starts_with("kd-") || name.starts_with("bounce") => {
            "demo:cloth?triangles=500 --size 32x32 --rounds 1"
        }
        _ => "demo:cloth?triangles=500 --size 64x64 --frames 1",
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
