//! `umbrage-bench`: how fast is it?
#![forbid(unsafe_code)]

mod frame;
mod grids;
mod median;
mod peers;
mod shot;
mod work;

use clap::{Parser, Subcommand};

/// Measures frames side by side, in alternation, and prints medians.
#[derive(Debug, Parser)]
#[command(name = "umbrage-bench", version, after_help = EXAMPLES)]
struct Flags {
    #[command(subcommand)]
    command: Command,
}

const EXAMPLES: &str = "Examples:
  umbrage-bench frame
      Every stage of a frame, for the whole gallery, through the grids and through the hierarchy
  umbrage-bench frame demo:cloth model.glb --size 2048x2048 --form csv
      Some scenes only, larger, for a spreadsheet
  umbrage-bench peers --files scenes
      The gallery and the real scenes of a folder, side by side with Embree";

#[derive(Debug, Subcommand)]
enum Command {
    /// Time every stage of a frame, for each scene and structure
    Frame(frame::FrameFlags),
    /// Compare frames with those of Embree, which must be installed (Debian's package libembree-dev)
    Peers(peers::PeersFlags),
}

fn main() -> anyhow::Result<()> {
    match Flags::parse().command {
        Command::Frame(flags) => frame::run(&flags),
        Command::Peers(flags) => peers::run(&flags),
    }
}
