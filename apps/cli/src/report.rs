use std::fmt::Write as _;
use std::path::Path;

use indicatif::HumanCount;
use serde::Serialize;
use umbrage::scene::TextureTraffic;
use umbrage::{Settings, Settled, Stage, Stats};

/// The cost of a render, frame by frame.
#[derive(Debug, Serialize)]
pub(crate) struct Report {
    pub(crate) scene: String,
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) samples: u32,
    pub(crate) threads: usize,
    /// The engine that rendered.
    pub(crate) engine: String,
    /// Wall time of reading or making the scene.
    pub(crate) open_milliseconds: f64,
    /// Number of frames that were there already.
    pub(crate) already_there: usize,
    /// The median of all frames.
    pub(crate) median: Costs,
    pub(crate) frames: Vec<FrameReport>,
}

/// The cost of one frame.
#[derive(Debug, Serialize)]
pub(crate) struct FrameReport {
    pub(crate) frame: u32,
    pub(crate) seconds: f64,
    /// Wall time of the render, without writing.
    pub(crate) render_milliseconds: f64,
    /// Wall time of encoding and writing, beside the next frame's render.
    pub(crate) write_milliseconds: f64,
    #[serde(flatten)]
    pub(crate) stats: Stats,
}

/// Times in milliseconds.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Costs {
    pub(crate) stages: Vec<Stage>,
    pub(crate) render_milliseconds: f64,
    pub(crate) write_milliseconds: f64,
}

impl Report {
    pub(crate) fn new(scene: &Path, settings: &Settings) -> Self {
        Self {
            scene: scene.display().to_string(),
            width: settings.width,
            height: settings.height,
            samples: settings.samples,
            threads: rayon::current_num_threads(),
            engine: String::new(),
            open_milliseconds: 0.0,
            already_there: 0,
            median: Costs::default(),
            frames: Vec::new(),
        }
    }

    /// Computes the medians over all frames.
    pub(crate) fn complete(&mut self) {
        let median_of = |cost: &dyn Fn(&FrameReport) -> Option<f64>| median(self.frames.iter().filter_map(cost));
        // The stages of the frame that has most of them, in its order.
        let fullest = self.frames.iter().map(|frame| &frame.stats.stages).max_by_key(|stages| stages.len());
        let stages = fullest.into_iter().flatten().map(|Stage { name, .. }| {
            let milliseconds = median_of(&|frame| {
                frame.stats.stages.iter().find(|stage| stage.name == *name).map(|stage| stage.milliseconds)
            });
            Stage { name, milliseconds }
        });
        let stages = stages.collect();
        self.median = Costs {
            stages,
            render_milliseconds: median_of(&|frame| Some(frame.render_milliseconds)),
            write_milliseconds: median_of(&|frame| Some(frame.write_milliseconds)),
        };
    }

    /// The report as text.
    pub(crate) fn text(&self) -> String {
        let mut text = format!(
            "{}: {} x {} pixels, {} a pixel, {}, {}, {}\n",
            self.scene,
            self.width,
            self.height,
            count(u64::from(self.samples), "sample"),
            count(self.frames.len() as u64, "frame"),
            count(self.threads as u64, "thread"),
            self.engine,
        );
        let title = if self.frames.len() == 1 { "milliseconds" } else { "milliseconds (median of the frames)" };
        let mut line = |name: &str, value: String| {
            // Writing to a string can't fail.
            let _ = writeln!(text, "  {name:<22} {value:>14}");
        };
        line(title, String::new());
        line("open, once", format!("{:.3}", self.open_milliseconds));
        for stage in &self.median.stages {
            line(stage.name, format!("{:.3}", stage.milliseconds));
        }
        line("render in all", format!("{:.3}", self.median.render_milliseconds));
        line("write", format!("{:.3}", self.median.write_milliseconds));
        let Some(FrameReport { stats, .. }) = self.frames.last() else { return text };
        line(if self.frames.len() == 1 { "counts" } else { "counts (last frame)" }, String::new());
        line("triangles", thousands(stats.triangles as u64));
        line("vertices", thousands(stats.vertices as u64));
        if stats.marks > 0 {
            line("points and lines", thousands(stats.marks as u64));
        }
        line("lights", thousands(stats.lights as u64));
        line("samples a pixel", thousands(u64::from(stats.samples)));
        line("camera rays", thousands(stats.camera_rays));
        line("shadow rays", thousands(stats.shadow_rays));
        let settled = [("camera", stats.settled_camera_rays), ("lights", stats.settled_shadow_rays)];
        if settled.iter().any(|(_, settled)| settled.is_some()) {
            line("settled by the predicate", String::new());
        }
        for (name, settled) in settled.into_iter().filter_map(|(name, settled)| Some((name, settled?))) {
            line(name, of_rays(settled));
        }
        line("bytes", String::new());
        line("structure", per(stats.structure_bytes, stats.triangles, "triangle"));
        if stats.point_bytes > 0 {
            line("light grid", per(stats.point_bytes, self.width as usize * self.height as usize, "pixel"));
        }
        line("frame", per(stats.frame_bytes, stats.triangles, "triangle"));
        line("pixels", per(stats.pixel_bytes, self.width as usize * self.height as usize, "pixel"));
        if let Some(TextureTraffic { found, loaded, resident_bytes, file_bytes }) = stats.textures {
            line("textures on demand", String::new());
            line("tiles loaded", thousands(loaded));
            line("tiles found in memory", thousands(found));
            line("bytes in memory", thousands(resident_bytes));
            line("bytes in the file", thousands(file_bytes));
        }
        if stats.omitted_marks > 0 {
            let _ = writeln!(text, "  left out: {} points and lines", thousands(stats.omitted_marks as u64));
        }
        for omitted in &stats.omitted {
            let _ = writeln!(
                text,
                "  left out: {} ({}; first ids {:?})",
                count(u64::from(omitted.count), "triangle"),
                omitted.reason,
                omitted.first_ids
            );
        }
        text
    }
}

/// The middle value, or the mean of the two in the middle; zero for none.
fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    match values.len() {
        0 => 0.0,
        odd if odd % 2 == 1 => values[odd / 2],
        even => 0.5 * (values[even / 2 - 1] + values[even / 2]),
    }
}

/// A number with its noun, in the plural but for one.
pub(crate) fn count(number: u64, noun: &str) -> String {
    format!("{} {noun}{}", thousands(number), if number == 1 { "" } else { "s" })
}

/// A number with commas between its thousands.
pub(crate) fn thousands(number: u64) -> String {
    HumanCount(number).to_string()
}

/// The number of rays that needed the predicate, or else of tests, and of all rays.
fn of_rays(Settled { tests, rays, of_rays }: Settled) -> String {
    let of_rays = count(of_rays, "ray");
    rays.map_or_else(
        || format!("{} for {of_rays}", count(tests, "test")),
        |rays| format!("{} of {of_rays}", thousands(rays)),
    )
}

fn per(bytes: usize, things: usize, noun: &str) -> String {
    if things == 0 {
        return thousands(bytes as u64);
    }
    format!("{} ({:.1} a {noun})", thousands(bytes as u64), bytes as f64 / things as f64)
}

#[cfg(test)]
mod tests {
    use umbrage::OmittedTriangles;

    use super::*;

    fn frame(frame: u32, see: f64, shadow: f64) -> FrameReport {
        let stage = |name, milliseconds| Stage { name, milliseconds };
        let stats = Stats {
            stages: vec![stage("see", see), stage("shadow", shadow)],
            triangles: 1_234_567,
            settled_camera_rays: Some(Settled { tests: 9_000, rays: Some(4_321), of_rays: 50_000 }),
            settled_shadow_rays: Some(Settled { tests: 1, rays: None, of_rays: 76_543 }),
            omitted: vec![OmittedTriangles { reason: "zero area", count: 2, first_ids: vec![3, 9] }],
            ..Stats::default()
        };
        FrameReport { frame, seconds: 0.0, render_milliseconds: see + shadow, write_milliseconds: 1.0, stats }
    }

    #[test]
    fn medians_are_by_stage() {
        let mut report = Report::new(Path::new("demo:x"), &Settings::default());
        for (number, see) in [5.0, 1.0, 2.0].into_iter().enumerate() {
            report.frames.push(frame(number as u32, see, 1.5));
        }
        report.complete();
        let stages: Vec<(&str, f64)> =
            report.median.stages.iter().map(|stage| (stage.name, stage.milliseconds)).collect();
        assert_eq!(stages, [("see", 2.0), ("shadow", 1.5)]);
        assert_eq!(report.median.render_milliseconds, 3.5);
        let text = report.text();
        for part in ["3 frames", "1,234,567", "2 triangles (zero area; first ids [3, 9])", "1.500"] {
            assert!(text.contains(part), "{part} in {text}");
        }
        let settled: Vec<_> = text.lines().skip_while(|line| !line.contains("settled")).take(3).map(words).collect();
        assert_eq!(
            settled,
            ["settled by the predicate", "camera 4,321 of 50,000 rays", "lights 1 test for 76,543 rays"]
        );
        // Without counts, the text has no line for them.
        let stats = &mut report.frames[2].stats;
        (stats.settled_camera_rays, stats.settled_shadow_rays) = (None, None);
        assert!(!report.text().contains("settled"));
    }

    fn words(line: &str) -> String {
        line.split_whitespace().collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn medians_of_few() {
        assert_eq!(median([].into_iter()), 0.0);
        assert_eq!(median([4.0, 1.0].into_iter()), 2.5);
        assert_eq!(count(1, "frame"), "1 frame");
    }
}
