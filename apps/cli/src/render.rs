use std::io::{self, Write};
use std::path::Path;
use std::time::Instant;

use umbrage::Scene;
use umbrage::output::{Target, Writer};

use crate::engine;
use crate::failure::{Failure, say};
use crate::flags::StatsFlag;
use crate::job::{Job, use_threads};
use crate::progress::Progress;
use crate::report::{self, FrameReport, Report};
use crate::staging::Staging;

pub(crate) fn run(job: &Job) -> Result<(), Failure> {
    use_threads(job.flags.scene.threads)?;
    let scene = umbrage::open_with(&job.scene, &job.flags.open_options())?;
    if !job.flags.quiet {
        for warning in scene.warnings() {
            say(format_args!("warning: {warning}"));
        }
    }
    let mut report = Report::new(&job.scene, &job.settings);
    let started = Instant::now();
    render_frames(job, &scene, &mut report)?;
    if !job.flags.quiet {
        say(summary(job, &report, started.elapsed().as_secs_f64()));
    }
    report_costs(job, &mut report)
}

fn render_frames(job: &Job, scene: &Scene, report: &mut Report) -> Result<(), Failure> {
    let duration_seconds = scene.duration_seconds();
    let (frames, second_of) = job.frames(duration_seconds);
    let mut writer = Writer::create(&job.target, job.format, &frames, &job.settings, &job.output_options)?;
    let mut staging = Staging::new(job, scene, second_of(frames.start))?;
    let (mut renderer, engine) = engine::renderer(job)?;
    report.engine = engine;
    let in_steps = (job.settings.samples > 1).then(|| renderer.progress());
    let progress = Progress::start(frames.end - frames.start, in_steps, job.flags.quiet);
    for frame in frames.clone() {
        let seconds = second_of(frame);
        let turn = if frames.len() > 1 {
            f64::from(frame - frames.start) / frames.len() as f64
        } else {
            // One moment of the circle that the whole animation would show.
            if duration_seconds > 0.0 { seconds / duration_seconds } else { 0.0 }
        };
        let settings = staging.settings(scene, seconds, turn)?;
        let started = Instant::now();
        let film = renderer.render(scene, seconds, &settings)?;
        let rendered = Instant::now();
        writer.write(frame, film, &settings)?;
        report.push(FrameReport {
            frame,
            seconds,
            render_milliseconds: 1e3 * rendered.duration_since(started).as_secs_f64(),
            write_milliseconds: 1e3 * rendered.elapsed().as_secs_f64(),
            stats: renderer.stats().clone(),
        });
        progress.step();
    }
    drop(progress);
    Ok(writer.finish()?)
}

/// One line that says what was written where.
fn summary(job: &Job, report: &Report, elapsed_seconds: f64) -> String {
    let target = match &job.target {
        Target::Path(path) => path.as_path(),
        Target::Stdout => Path::new("standard output"),
    };
    let (width, height) = (job.settings.width, job.settings.height);
    let triangles = report.frames.last().map_or(0, |frame| frame.stats.triangles);
    let shown = match &report.frames[..] {
        [single] => format!("second {:.3}", single.seconds),
        frames => report::count(frames.len() as u64, "frame"),
    };
    format!(
        "{}: {shown} of {} ({}) at {width}x{height} in {elapsed_seconds:.2} s",
        target.display(),
        job.scene.display(),
        report::count(triangles as u64, "triangle"),
    )
}

fn report_costs(job: &Job, report: &mut Report) -> Result<(), Failure> {
    let Some(form) = job.flags.stats else { return Ok(()) };
    report.complete();
    match form {
        StatsFlag::Text => say(report.text().trim_end()),
        StatsFlag::Json => {
            let json = serde_json::to_string_pretty(report).map_err(|error| Failure::Work(error.to_string()))?;
            match job.target {
                // The video has standard output to itself.
                Target::Stdout => say(json),
                Target::Path(_) => writeln!(io::stdout(), "{json}")?,
            }
        }
    }
    Ok(())
}
