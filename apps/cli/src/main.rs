//! The `umbrage` command: flags → a validated job → the library → an exit code.
#![forbid(unsafe_code)]

mod choices;
mod engine;
mod failure;
mod flags;
mod heatmap;
mod info;
mod job;
mod pages;
mod progress;
mod render;
mod report;
mod staging;
mod values;
mod view;

use std::process::ExitCode;

use clap::Parser;

use failure::Failure;
use flags::{Command, Flags};

fn main() -> ExitCode {
    match run(Flags::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}

fn run(flags: Flags) -> Result<(), Failure> {
    match flags.command {
        Command::Render(flags) => render::run(&job::Job::new(*flags)?),
        Command::View(flags) => view::run(*flags),
        Command::Heatmap(flags) => heatmap::run(&flags),
        Command::Info(flags) => info::run(flags),
        Command::Completions { shell } => pages::completions(shell),
        Command::Man { folder } => pages::man(folder.as_deref()),
    }
}
