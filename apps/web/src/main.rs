//! The page that renders in a browser: `cargo run -p web -- build` makes it, `serve` shows it on this machine.
#![forbid(unsafe_code)]

mod build;
mod proofs;
mod serve;

use std::net::IpAddr;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Makes the page that renders in a browser, and shows it.
#[derive(Debug, Parser)]
#[command(after_help = "Examples:
  cargo run --release -p web -- serve              make the page and show it at http://127.0.0.1:8080
  cargo run --release -p web -- build site         make it in the folder `site`, to copy to any web server")]
struct Flags {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Compiles the engine to WebAssembly and puts the page's files into a folder: all that a web server needs.
    Build {
        /// Where to; is made where it isn't there.
        #[arg(default_value = "target/web")]
        folder: PathBuf,
    },
    /// Makes the page as `build` does, then shows it until it is stopped.
    Serve {
        /// The port to listen at; 0 for any that is free.
        #[arg(long, default_value_t = 8080)]
        port: u16,
        /// The address to listen at: 0.0.0.0 for other machines, as a phone, to see it.
        #[arg(long, default_value = "127.0.0.1")]
        address: IpAddr,
        /// A folder that `build` made, as it is.
        #[arg(long, value_name = "FOLDER")]
        built: Option<PathBuf>,
    },
    /// Prints hashes of pictures that this machine renders, as JSON, for the page's tests to compare.
    Proofs,
}

fn main() -> ExitCode {
    match run(Flags::parse().command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run(command: Command) -> anyhow::Result<()> {
    match command {
        Command::Build { folder } => build::build(&folder),
        Command::Serve { port, address, built } => {
            let folder = match built {
                Some(folder) => folder,
                None => {
                    let folder = PathBuf::from("target/web");
                    build::build(&folder)?;
                    folder
                }
            };
            serve::serve(&folder, address, port)
        }
        Command::Proofs => proofs::print(),
    }
}
