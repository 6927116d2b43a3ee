//! Memory: bytes a triangle, allocations a frame, and whether it grows.

use anyhow::{Context, Result};
use rayon::ThreadPoolBuilder;
use umbrage::{Renderer, Settings};

use super::rays::number;
use super::surfaces::choices;
use super::{Effort, Finding};

pub(super) fn bytes(effort: &Effort) -> Result<Finding> {
    /// Maximum bytes of a structure for each triangle.
    const GOAL: f64 = 70.0;
    let counts = [20_000, 1_000_000].map(|count| effort.of(count).max(1000));
    let [few, many] = counts;
    let mut text = format!(
        "Bytes that structures hold for each triangle, at 1024×1024 pixels: where there are few, the cells of a camera and \
         of lights weigh most. The goal is {GOAL}.\n\n| structure | {} triangles | {} triangles |\n|---|---|---|\n",
        number(few),
        number(many)
    );
    let mut above = Vec::new();
    for (name, structure) in choices() {
        let mut line = format!("| {name} |");
        for count in counts {
            let frame = umbrage::open(format!("demo:statue?triangles={count}"))?.at(0.0)?;
            let side = effort.side(1024, 32);
            let settings = Settings { width: side, height: side, structure: structure.clone(), ..Settings::default() };
            let mut renderer = Renderer::default();
            renderer.render_frame(&frame, &settings)?;
            let bytes = renderer.stats().structure_bytes as f64 / frame.triangles().len() as f64;
            line += &format!(" {bytes:.0} |");
            if bytes > GOAL && count == many {
                above.push(name);
            }
        }
        text += &(line + "\n");
    }
    if !above.is_empty() {
        text += &format!("\nAbove the goal at {} triangles: {}.", number(many), above.join(", "));
    }
    Ok(Finding::new(above.is_empty(), text.trim_end()))
}

pub(super) fn allocations(_: &Effort) -> Result<Finding> {
    let frame = umbrage::open("demo:cloth?triangles=20000")?.at(0.5)?;
    let pool = ThreadPoolBuilder::new().num_threads(1).build()?;
    let (mut holds, mut found) = (true, Vec::new());
    for (name, structure) in choices() {
        let [one, four] = [1, 4].map(|samples| {
            let settings =
                Settings { width: 256, height: 256, structure: structure.clone(), samples, ..Settings::default() };
            pool.install(|| -> Result<usize> {
                let mut renderer = Renderer::default();
                // Patches of connected triangles are made in the second frame.
                renderer.render_frame(&frame, &settings)?;
                renderer.render_frame(&frame, &settings)?;
                let before = allocations::on_this_thread();
                renderer.render_frame(&frame, &settings)?;
                Ok(allocations::on_this_thread() - before)
            })
        });
        let (one, four) = (one?, four?);
        let builds_anew = matches!(name, "kdtree" | "bvh");
        holds &= one == four && (builds_anew || one == 0);
        found.push(format!("{name} {one}"));
    }
    let text = format!(
        "Times that a steady frame asks for memory, with its shading: {}. Further samples ask for none, so what \
         trees ask for is their building.",
        found.join(", ")
    );
    Ok(Finding::new(holds, text))
}

pub(super) fn soak(effort: &Effort) -> Result<Finding> {
    let scene = umbrage::open("demo:shatter?triangles=500")?;
    let (frames, duration) = (effort.of(100_000), scene.duration_seconds());
    let mut renderers: Vec<(Settings, Renderer)> = choices()
        .map(|(_, structure)| {
            (Settings { width: 24, height: 24, structure, ..Settings::default() }, Renderer::default())
        })
        .collect();
    let mut early = None;
    for number in 0..frames {
        let (settings, renderer) = &mut renderers[number as usize % choices().count()];
        renderer.render(&scene, duration * number as f64 / 997.0, settings)?;
        if number == frames / 10 {
            early = resident_bytes();
        }
    }
    let Some((early, late)) = early.zip(resident_bytes()) else {
        return Ok(Finding::new(
            true,
            format!("{} frames; this system doesn't say how much memory is held.", number(frames)),
        ));
    };
    let growth = (late as f64 - early as f64) / (0.9 * frames as f64);
    let text = format!(
        "After a tenth of {} frames, through all structures in turn, the program held {:.1} MB, and at the end {:.1} MB: \
         {growth:.1} bytes a frame.",
        number(frames),
        early as f64 * 1e-6,
        late as f64 * 1e-6
    );
    // An allocator's own waste isn't a leak; a leak is at least one word in each frame.
    Ok(Finding::new(late < early + 8 * frames + 4_000_000, text))
}

/// Bytes of the program in memory, if the system tells it.
fn resident_bytes() -> Option<u64> {
    const PAGE: u64 = 4096;
    let status = std::fs::read_to_string("/proc/self/statm").ok()?;
    let pages = status.split_whitespace().nth(1).context("pages").ok()?;
    Some(pages.parse::<u64>().ok()? * PAGE)
}
