use anyhow::Result;
use clap::Args;
use umbrage_papers::{Clipping, KdLayout, KdMailbox, KdPacketOptions, KdTreeOptions, SahCosts};

use super::builders::{Trial, TrialRays};
use super::measure::{KdFlags, frame};
use crate::shot::name;

#[derive(Args, Debug)]
pub(crate) struct KdAblationsFlags {
    /// Files, sequences or demo:NAME
    #[arg(default_values = ["demo:cloth", "demo:hall", "demo:forest"])]
    scenes: Vec<String>,
    #[command(flatten)]
    common: KdFlags,
}

impl KdAblationsFlags {
    pub(crate) fn run(&self) -> Result<()> {
        let mut table = self.common.start_without_chart()?;
        for address in &self.scenes {
            let frame = frame(address)?;
            let rays = TrialRays::new(&frame, address, self.common.size)?;
            let trial = |options| Trial::new(&frame, options, &rays, self.common.rounds);
            let whole = trial(KdTreeOptions::DEFAULT)?;
            let mut push =
                |of: &Trial, tree| table.push(of.row(name(address), frame.triangles().len(), tree, Some(&whole)));
            push(&whole, ("tree", "exact"))?;
            for (what, options) in ablations() {
                push(&trial(options)?, ("tree", what))?;
            }
        }
        table.finish(&[
            "Columns as of kd-builders; ratios over the tree above: exact, with all of what the others lack.",
            "The thesis, chapter 4: split clipping is 9 % of the traversal and 140 % of the build, a bonus of 20 % for empty space",
            "5 % (Hurley et al. 2002), mailboxes in costs 30 % of the tests and few per cent of the time (Hunt 2008), a ring of",
            "eight triangles that packets remember 9.7 to 23.4 % (Shevtsov et al. 2007). Section 2.2: subtrees in cache lines take",
            "1/1.25 to 1/1.39 of the time of nodes anywhere.",
        ])?;
        Ok(())
    }
}

/// The exact builder's options, each without one feature or with another in its place.
fn ablations() -> [(&'static str, KdTreeOptions); 10] {
    let whole = KdTreeOptions::DEFAULT;
    let charged = |costs| KdTreeOptions { costs, ..whole };
    let remembers =
        |mailbox| KdTreeOptions { packets: KdPacketOptions { mailbox, ..KdPacketOptions::DEFAULT }, ..whole };
    [
        ("boxes cut, not clipped", KdTreeOptions { clipping: Clipping::Boxes, ..whole }),
        ("no bonus for empty space", charged(SahCosts { empty: 1.0, ..whole.costs })),
        ("two tests charged", charged(SahCosts { mailbox: false, ..whole.costs })),
        ("no plane may fail", charged(SahCosts { failures: 0, ..whole.costs })),
        ("all planes may fail", charged(SahCosts { failures: SahCosts::MOST_FAILURES, ..whole.costs })),
        ("a test costs a step", charged(SahCosts { test: 1.0, ..whole.costs })),
        ("packets remember nothing", remembers(KdMailbox::None)),
        ("packets remember eight", remembers(KdMailbox::Ring)),
        ("lines hold subtrees", KdTreeOptions { layout: KdLayout::Subtrees, ..whole }),
        ("nodes anywhere", KdTreeOptions { layout: KdLayout::Scattered, ..whole }),
    ]
}
