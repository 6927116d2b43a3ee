//! Figures 8 and 9: moving models through the uniform grid, without and with shading and shadows.

use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::Args;
use umbrage::{Renderer, Settings, Structure};
use umbrage_papers::Uniform;

use crate::flags::ImageFlags;
use crate::shot::{moments, name};
use crate::table::{Cell, row};

#[derive(Args, Debug)]
pub(crate) struct ModelsFlags {
    /// Files, sequences or demo:NAME [default: scenes of the kinds that the paper has, those of files where --files has them]
    scenes: Vec<String>,
    /// Folder of the real scenes
    #[arg(long, value_name = "DIR")]
    files: Option<PathBuf>,
    #[command(flatten)]
    common: ImageFlags,
}

/// The paper's results, in frames a second on two Xeons of 3.2 GHz.
struct OfPaper {
    model: &'static str,
    triangles: u32,
    /// Our scene of the same kind.
    like: &'static str,
    /// Rebuilt and traced.
    traced: &'static str,
    /// With shading, texturing and shadows.
    shaded: &'static str,
}

const fn paper(
    model: &'static str,
    triangles: u32,
    like: &'static str,
    traced: &'static str,
    shaded: &'static str,
) -> OfPaper {
    OfPaper { model, triangles, like, traced, shaded }
}

const PAPER: [OfPaper; 6] = [
    paper("wood-doll", 5_378, "robot_expressive.glb", "56.7", "30.1"),
    paper("hand", 15_855, "vintage_fan.glb", "29.3", "14.2"),
    paper("poser", 78_029, "elephant_gallop.glb", "13.1", "7.7"),
    paper("toys", 11_100, "robot_arm.glb", "20.0 to 34.1", "8.1 to 16.2"),
    paper("marbles", 8_800, "demo:marbles", "34.6 to 47.2", "18.3 to 25.2"),
    paper("fairy forest", 174_117, "demo:forest", "3.1 to 4.3", "1.6 to 2.2"),
];

/// Stages of the frames without shading, and those that shading and shadows add.
const STAGES: [&[&str]; 2] = [&["build", "see"], &["shadow", "shade"]];

impl ModelsFlags {
    pub(crate) fn run(&self) -> Result<()> {
        let mut table = self.common.start_without_chart()?;
        for address in self.addresses() {
            let (triangles, lights, frames) = self.measure(&address).with_context(|| format!("scene {address}"))?;
            let of_paper = PAPER.iter().find(|paper| paper.like == name(&address));
            let [traced, shaded] = [0, 1].map(|which| range(frames.iter().map(|times| times[..=which].iter().sum())));
            table.push(row![
                ("scene", name(&address)),
                ("triangles", triangles),
                ("lights", lights),
                ("traced_s", traced),
                ("shaded_s", shaded),
                ("paper_model", of_paper.map(|paper| paper.model)),
                ("paper_triangles", of_paper.map(|paper| paper.triangles)),
                ("paper_traced_s", of_paper.map(|paper| paper.traced)),
                ("paper_shaded_s", of_paper.map(|paper| paper.shaded)),
            ])?;
        }
        table.finish(&[
            "Frames a second of the slowest and of the fastest frame: traced by build + see, shaded with shadow and shade as well.",
            "The paper's are its Figures 8 and 9, on two Xeons of 3.2 GHz, by packets of 8x8 rays of its own scenes; ours beside",
            "them are of the same kind and about the same size, with all of their lights, by packets of 32x32 pixels.",
        ])?;
        Ok(())
    }

    fn addresses(&self) -> Vec<String> {
        if !self.scenes.is_empty() {
            return self.scenes.clone();
        }
        let of_paper = |paper: &OfPaper| {
            if paper.like.starts_with("demo:") {
                return Some(paper.like.to_owned());
            }
            let path = self.files.as_ref()?.join(paper.like);
            path.exists().then(|| path.to_string_lossy().into_owned())
        };
        PAPER.iter().filter_map(of_paper).collect()
    }

    /// Numbers of a scene's triangles and lights, and each frame's times in milliseconds, by the stages of [`STAGES`].
    fn measure(&self, address: &str) -> Result<(usize, usize, Vec<[f64; 2]>)> {
        let scene = umbrage::open(address)?;
        let [width, height] = self.common.size;
        let settings = Settings { width, height, structure: Structure::of::<Uniform>(), ..Settings::default() };
        let mut renderer = Renderer::with_simd_level(self.common.animation.simd.unwrap_or_default());
        let mut frames = Vec::new();
        for (seconds, is_counted) in moments(&scene, self.common.animation.frames) {
            renderer.render(&scene, seconds, &settings)?;
            let stages = &renderer.stats().stages;
            let sum = |names: &[&str]| -> f64 {
                stages.iter().filter(|stage| names.contains(&stage.name)).map(|stage| stage.milliseconds).sum()
            };
            if is_counted {
                frames.push(STAGES.map(sum));
            }
        }
        let stats = renderer.stats();
        Ok((stats.triangles, stats.lights, frames))
    }
}

/// The least and the most frames a second, from milliseconds.
fn range(milliseconds: impl Iterator<Item = f64> + Clone) -> Cell {
    let least = milliseconds.clone().fold(0.0, f64::max);
    let most = milliseconds.fold(f64::INFINITY, f64::min);
    Cell::Text(format!("{:.1} to {:.1}", 1e3 / least, 1e3 / most))
}
