use anyhow::{Result, bail};
use clap::Args;
use umbrage::rays::{Counts, SeenPixels, Structure as _};
use umbrage::scene::Frame;
use umbrage_papers::{KdTree, KdTreeOptions, PacketSide, UniformOptions};

use super::measure::{Way, measure};
use crate::flags::ImageFlags;
use crate::shot::{Lights, Shot, moments, name};
use crate::table::{Cell, Row, row};

#[derive(Args, Debug)]
pub(crate) struct CullingFlags {
    /// Files, sequences or demo:NAME
    #[arg(default_values = ["demo:cloth", "demo:marbles", "demo:forest", "demo:hall", "demo:shatter", "demo:statue"])]
    scenes: Vec<String>,
    #[command(flatten)]
    common: ImageFlags,
}

impl CullingFlags {
    pub(crate) fn run(&self) -> Result<()> {
        if !cfg!(feature = "statistics") {
            bail!("this `umbrage-bench` counts nothing: build it with `--features statistics`");
        }
        // Neither of the paper's grids has macrocells here.
        let default = UniformOptions { macrocell: 1, ..UniformOptions::DEFAULT };
        let packets = [PacketSide::Four, PacketSide::Eight, PacketSide::ThirtyTwo];
        let forms = packets.map(|packet| (UniformOptions { packet, ..default }, Way::Packets));
        let forms: Vec<_> = [(default, Way::Single)].into_iter().chain(forms).collect();
        let titles = ["single".to_owned()].into_iter().chain(packets.map(super::packets::title));
        let titles: Vec<String> = titles.collect();
        let mut table = self.common.start_without_chart()?;
        for address in &self.scenes {
            let costs = measure(address, self.common.size, &forms, &self.common.animation)?;
            let sides = [1].into_iter().chain(packets.map(PacketSide::pixels));
            for ((title, side), costs) in titles.iter().zip(sides).zip(&costs) {
                table.push(row(name(address), title, u64::from(side * side), &costs.counts))?;
            }
            table.push(row(name(address), "kd-tree 4x4", 16, &self.kd_tree(address)?))?;
        }
        table.finish(&[
            "Millions: pairs of a packet and a cell (of the kd-tree: a leaf), and of a ray and a triangle that would be tested",
            "with neither mailbox nor culling, with the mailbox, with frustum culling too, and without what is behind all hits.",
            "ratio: neither by frustum. No macrocells. The kd-tree has neither mailbox nor frustum.",
            "Wald et al. 2006, Table 1: 8.5 (ben), 13.4 (hand), 14.0 (toys), 13.9 (conf), and the kd-tree 0.5 to 0.9 of the grid's",
            "tests. Table 4: 4x4 packets visit 10 to 21 times fewer cells than single rays, and test 0.2 to 0.5 of the pairs.",
            "settled: pairs of a ray and a triangle that went to the exact predicate, not in millions.",
        ])?;
        Ok(())
    }

    /// Counts of packets of 16 rays in a kd-tree, in the animation's last frame.
    fn kd_tree(&self, address: &str) -> Result<Counts> {
        let scene = umbrage::open(address)?;
        let mut frame = Frame::default();
        let last = moments(&scene, self.common.animation.frames).last();
        scene.pose(last.map_or(0.0, |moment| moment.0), &mut frame)?;
        let shot = Shot::new(&frame, address, self.common.size, 1, Lights::First);
        let mut tree = KdTree::with_level(self.common.animation.simd.unwrap_or_default());
        tree.set_options(KdTreeOptions::FAST)?;
        tree.build(frame.triangles());
        let opacities = shot.opacities();
        tree.see(&shot.question(&opacities, &shot.samples[0]), &mut SeenPixels::default())?;
        let counts = tree.take_visits();
        Ok(Counts { cells: counts.leaves, ..counts })
    }
}

fn row(name: &str, form: &str, rays: u64, counts: &Counts) -> Row {
    let Counts { cells, mailbox_hits, frustum_culls, depth_culls, tests, settled, .. } = *counts;
    let millions = |pairs: u64| (pairs * rays) as f64 / 1e6;
    let after_depth = tests;
    let after_frustum = after_depth + depth_culls;
    let after_mailbox = after_frustum + frustum_culls;
    let all = after_mailbox + mailbox_hits;
    row![
        ("scene", name),
        ("rays", Cell::Text(form.to_owned())),
        ("cells", cells as f64 / 1e6),
        ("neither", millions(all)),
        ("mailbox", millions(after_mailbox)),
        ("frustum", millions(after_frustum)),
        ("depth", millions(after_depth)),
        ("ratio", Cell::Number(all as f64 / after_frustum as f64, 1)),
        ("settled", settled),
    ]
}
