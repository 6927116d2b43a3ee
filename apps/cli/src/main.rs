//! The `umbrage` command: flags → a validated job → the library → an exit code.
#![forbid(unsafe_code)]
// `print!` and `eprint!` panic where their stream is closed.
#![deny(clippy::print_stdout, clippy::print_stderr)]

mod choices;
mod engine;
mod failure;
mod feature;
mod flags;
mod heatmap;
mod info;
mod job;
mod pages;
mod progress;
mod records;
mod render;
mod report;
mod shorthand;
mod signals;
mod staging;
mod structures;
mod threads;
mod values;
mod view;
mod words;
mod written;

use std::env;
use std::process::ExitCode;

use failure::Failure;
use flags::{Command, Flags};
use words::Asked;

fn main() -> ExitCode {
    signals::clean_up_when_told_to_end();
    let done = match Asked::of(shorthand::written_out(env::args_os())) {
        Asked::Flags(flags) => run(*flags),
        Asked::Wrong(failure) => Err(failure),
        // Includes help and the version, which go to standard output.
        Asked::Said(said) => match said.print() {
            Err(unheard) if !said.use_stderr() => Err(unheard.into()),
            _ => return ExitCode::from(said.exit_code() as u8),
        },
    };
    done.map_or_else(Failure::report, |()| ExitCode::SUCCESS)
}

fn run(flags: Flags) -> Result<(), Failure> {
    match flags.command {
        Command::Render(flags) => render::run(&job::Job::new(*flags)?),
        Command::View(flags) => view::run(*flags),
        Command::Heatmap(flags) => heatmap::run(&flags),
        Command::Info(flags) => info::run(&flags),
        Command::Structures { name } => structures::run(name.as_ref()),
        Command::Completions { shell } => pages::completions(shell),
        Command::Man { folder } => pages::man(folder.as_deref()),
    }
}
