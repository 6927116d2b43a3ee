use std::io::{self, Write};
use std::ops::Range;
use std::panic::resume_unwind;
use std::path::{Path, PathBuf};
use std::thread;
use std::time::Instant;

use umbrage::output::{Format, NumberedPath, Picture, Target, Writer};
use umbrage::{Film, OmittedTriangles, Scene, Settings, Stage, Stats};

use crate::engine;
use crate::failure::{Failure, say};
use crate::feature::Feature;
use crate::flags::StatsFlag;
use crate::job::{Job, check_inputs_stay};
use crate::progress::Progress;
use crate::records::Records;
use crate::report::{self, FrameReport, Report, thousands};
use crate::staging::Staging;
use crate::threads::use_threads;
use crate::written::{self, FrameWriter, Rendered};

pub(crate) fn run(job: &Job) -> Result<(), Failure> {
    use_threads(job.flags.scene.threads, Some([job.settings.width, job.settings.height]))?;
    let started = Instant::now();
    let opening = Progress::task("opening", &job.scene, job.flags.quiet);
    let scene = umbrage::open_with(&job.scene, &job.flags.open_options())?;
    drop(opening);
    if !job.flags.quiet {
        for warning in scene.warnings() {
            say(format_args!("warning: {warning}"));
        }
        Feature::hint_at_missing(scene.warnings());
    }
    let mut report = Report::new(&job.scene, &job.settings);
    report.open_milliseconds = 1e3 * started.elapsed().as_secs_f64();
    let started = Instant::now();
    if let (Some(advice), false) = (job.advice(), job.flags.quiet) {
        say(format_args!("note: {advice}"));
    }
    render_frames(job, &scene, &mut report)?;
    if !job.flags.quiet {
        say(summary(job, &report, started.elapsed().as_secs_f64()));
    }
    report_costs(job, &mut report)
}

fn render_frames(job: &Job, scene: &Scene, report: &mut Report) -> Result<(), Failure> {
    let schedule = job.schedule(scene.duration_seconds(), scene.still_seconds());
    let records = match &job.target {
        Target::Path(path) if job.flags.resume => Records::new(job, path, scene, &schedule)?,
        _ => None,
    };
    let share = schedule.share.clone();
    let frames = records.as_ref().map_or_else(|| share.clone().collect(), |records| records.missing(share.clone()));
    report.already_there = share.len() - frames.len();
    if frames.is_empty() && (job.flags.shard.is_some() || records.is_some()) {
        return Ok(());
    }
    check_inputs_stay(outputs(job, &share)?, scene, job.background_file())?;
    let writer = Writer::create(&job.target, job.format, &share, &job.settings, &job.output_options)?;
    if let Some(records) = &records {
        records.prepare()?;
    }
    let preparing = Progress::task("preparing", &job.scene, job.flags.quiet);
    let mut staging = Staging::new(job, scene, schedule.seconds(schedule.frames.start))?;
    let (mut renderer, engine) = engine::renderer(job, scene)?;
    report.engine = engine;
    let in_steps = (job.settings.samples > 1).then(|| renderer.progress());
    let measured = if job.measures_exposure() && job.moments.are_several() {
        // A frame of the whole animation, so that all shares have the same exposure.
        let seconds = scene.still_seconds();
        let settings = staging.settings(scene, seconds, 0.0)?;
        renderer.render(scene, seconds, &Settings::for_metering(&settings))?;
        Some(renderer.film().metered_stops(renderer.frame()))
    } else {
        None
    };
    drop(preparing);
    let progress = Progress::start(frames.len() as u32, in_steps, job.flags.quiet);
    let mut told = Vec::new();
    let form = writer.form();
    let mut film = Film::default();
    let mut render = |frame: u32, mut picture: Picture| -> Result<Rendered, Failure> {
        let seconds = schedule.seconds(frame);
        let mut settings = staging.settings(scene, seconds, schedule.turn(frame))?;
        let started = Instant::now();
        let mut developing = None;
        if job.looks_at_film() {
            renderer.render(scene, seconds, &settings)?;
            renderer.swap_film(&mut film);
            if job.measures_exposure() {
                settings.exposure_stops = film.metered_stops(renderer.frame());
            }
            if let Some(view) = job.flags.show {
                view.paint(&mut film, renderer.frame());
            }
            let started = Instant::now();
            form.develop(&mut film, &settings, &mut picture);
            developing = Some(1e3 * started.elapsed().as_secs_f64()).filter(|_| job.format != Format::Exr);
            renderer.swap_film(&mut film);
        } else {
            settings.exposure_stops = measured.unwrap_or(settings.exposure_stops);
            renderer.render_picture(scene, seconds, &settings, (form, &mut picture))?;
        }
        let mut stats = renderer.stats().clone();
        stats.stages.extend(developing.map(|milliseconds| Stage { name: "develop", milliseconds }));
        let render_milliseconds = 1e3 * started.elapsed().as_secs_f64();
        if !job.flags.quiet {
            warn_of_omitted(frame, &stats, &mut told);
        }
        let report = FrameReport { frame, seconds, render_milliseconds, write_milliseconds: 0.0, stats };
        Ok(Rendered { picture, report })
    };
    let writer = FrameWriter { writer, records: records.as_ref(), progress: &progress };
    let (to_writer, from_renderer) = written::way();
    let (rendered, written) = thread::scope(|scope| {
        let writing = scope.spawn(move || writer.write_all(from_renderer));
        let mut rendered = Ok(());
        for frame in frames {
            // If the writer has failed, it returns the reason.
            let goes_on = render(frame, to_writer.spare()).map(|frame| to_writer.send(frame));
            if !matches!(goes_on, Ok(true)) {
                rendered = goes_on.map(|_| ());
                break;
            }
        }
        drop(to_writer);
        (rendered, writing.join().unwrap_or_else(|panic| resume_unwind(panic)))
    });
    drop(progress);
    let (writer, frames) = written?;
    rendered?;
    report.frames = frames;
    Ok(writer.finish()?)
}

/// The files that will be written.
fn outputs(job: &Job, frames: &Range<u32>) -> Result<Vec<PathBuf>, Failure> {
    let Target::Path(path) = &job.target else { return Ok(Vec::new()) };
    Ok(match NumberedPath::parse(path)? {
        Some(numbered) => frames.clone().map(|frame| numbered.path(frame)).collect(),
        None => vec![path.clone()],
    })
}

/// Reports triangles, points and lines that are left out of a picture, once for each reason.
fn warn_of_omitted(frame: u32, stats: &Stats, told: &mut Vec<&'static str>) {
    const CPU_ALONE: &str = "only the CPU draws them";
    if stats.omitted_marks > 0 && !told.contains(&CPU_ALONE) {
        let marks = thousands(stats.omitted_marks as u64);
        say(format_args!("warning: frame {frame}: left out {marks} points and lines: {CPU_ALONE}"));
        told.push(CPU_ALONE);
    }
    for OmittedTriangles { reason, count, .. } in &stats.omitted {
        if !told.contains(reason) {
            let triangles = report::count(u64::from(*count), "triangle");
            say(format_args!("warning: frame {frame}: left out {triangles}: {reason}"));
            told.push(reason);
        }
    }
}

/// One line with the output's name, the times of opening and of rendering, and the contents.
fn summary(job: &Job, report: &Report, render_seconds: f64) -> String {
    let target = match &job.target {
        Target::Path(path) => path.as_path(),
        Target::Stdout => Path::new("standard output"),
    };
    let (width, height) = (job.settings.width, job.settings.height);
    let triangles = report.frames.last().map_or(0, |frame| frame.stats.triangles);
    let scene =
        format!("{} ({}) at {width}x{height}", job.scene.display(), report::count(triangles as u64, "triangle"));
    let opened = format!("opened in {:.2} s", 1e-3 * report.open_milliseconds);
    let rendered = match &report.frames[..] {
        [single] => format!("{opened}, rendered in {render_seconds:.2} s: second {:.3} of {scene}", single.seconds),
        frames => {
            let (count, rate) = (report::count(frames.len() as u64, "frame"), frames.len() as f64 / render_seconds);
            format!("{opened}, {count} rendered in {render_seconds:.2} s ({rate:.1} a second): {scene}")
        }
    };
    let there = report.already_there;
    let all = report::count((there + report.frames.len()) as u64, "frame");
    let there =
        format!("{} of {all} {} there already", thousands(there as u64), if there == 1 { "was" } else { "were" });
    let said = match (report.already_there, &report.frames[..], job.flags.shard) {
        (0, [], Some(shard)) => format!("no frame is left for shard {shard}"),
        (0, _, _) => rendered,
        (_, [], _) => there,
        _ => format!("{rendered}; {there}"),
    };
    format!("{}: {said}", target.display())
}

fn report_costs(job: &Job, report: &mut Report) -> Result<(), Failure> {
    let Some(form) = job.flags.stats else { return Ok(()) };
    report.complete();
    match form {
        StatsFlag::Text => say(report.text().trim_end()),
        StatsFlag::Json => {
            let json = serde_json::to_string_pretty(report).map_err(|error| Failure::Work(error.to_string()))?;
            match job.target {
                // Standard output is used by the video alone.
                Target::Stdout => say(json),
                Target::Path(_) => writeln!(io::stdout(), "{json}")?,
            }
        }
    }
    Ok(())
}
