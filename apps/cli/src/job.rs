use std::collections::HashSet;
use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

use bytesize::ByteSize;
use umbrage::output::{
    BitDepth, FloatDepth, Format, FrameRate, JpegQuality, NumberedPath, Options, Target, extensions,
};
use umbrage::rays::Choice;
use umbrage::spec::{BackgroundSpec, Length, LightSpec};
use umbrage::{Background, EngineKind, Layers, Scene, Settings, gallery};

use crate::failure::Failure;
use crate::feature::Feature;
use crate::flags::{OpeningFlags, RenderFlags};
use crate::values::ExposureFlag;

/// A validated render: only the scene or the system can still make it fail.
#[derive(Debug)]
pub(crate) struct Job {
    /// The flags as given; camera, lights and shares of the scene's size are resolved once the scene is open.
    pub(crate) flags: RenderFlags,
    pub(crate) scene: PathBuf,
    pub(crate) moments: Moments,
    pub(crate) target: Target,
    pub(crate) format: Format,
    pub(crate) output_options: Options,
    pub(crate) settings: Settings,
}

/// The moments to render.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Moments {
    /// One, in seconds; `None` for the one that shows the scene best.
    Single(Option<f64>),
    /// Frame k at second k / rate.
    Frames(Range<u32>),
    /// The whole animation.
    All,
}

impl Moments {
    pub(crate) fn are_several(&self) -> bool {
        !matches!(self, Self::Single(_))
    }
}

impl Job {
    pub(crate) fn new(flags: RenderFlags) -> Result<Self, Failure> {
        let structure = flags.structure.clone();
        let scene = flags.scene.address();
        let (target, format) = target(flags.output.clone(), flags.format, flags.frames.is_some())?;
        let moments = match (&flags.frames, flags.time) {
            (Some(frames), _) => Moments::Frames(frames.0.clone()),
            (None, None) if format.is_animation() || is_numbered(&target)? => Moments::All,
            (None, seconds) => Moments::Single(seconds),
        };
        let quality = Quality::new(&flags, !moments.are_several())?;
        engine(&flags)?;
        let are_numbered = moments.are_several() && !format.is_animation() && is_numbered(&target)?;
        for_numbered_frames(&flags, are_numbered)?;
        let (bit_depth, float_depth) = bit_depths(format, flags.bit_depth)?;
        let settings = Settings {
            width: flags.size.width,
            height: flags.size.height,
            samples: quality.samples,
            noise: flags.noise,
            shutter_seconds: flags.shutter,
            sky_shadows: flags.sky_shadows,
            structure,
            sides: flags.sides,
            smooth_terminator: flags.smooth_terminator,
            bounces: quality.bounces,
            least_contribution: flags.least_contribution,
            gloss: flags.gloss,
            point_size: flags.point_size,
            line_width: flags.line_width,
            background: background(&flags.background, flags.scene.opening.options().max_memory)?,
            exposure_stops: match flags.exposure {
                Some(ExposureFlag::Stops(stops)) => stops,
                Some(ExposureFlag::Auto) | None => 0.0,
            },
            tone_map: flags.tone_map,
            layers: layers(&flags, format)?,
            motion_seconds: flags.fps.seconds(1),
            ..Settings::default()
        };
        let settings = with_lengths(settings, &flags, 0.0);
        check_memory(&settings, &flags.scene.opening)?;
        let (rate, compression, chroma) = (flags.fps, flags.png_compression, flags.chroma);
        let jpeg_quality = jpeg_quality(format, flags.quality)?;
        let output_options = Options { rate, bit_depth, compression, float_depth, jpeg_quality, chroma };
        let mut job = Self { flags, scene, moments, target, format, output_options, settings };
        // Exposure is measured on a film of its own where there are several frames.
        let measures_film = job.measures_exposure() && !job.moments.are_several();
        job.settings.first_hits = job.format == Format::Exr || job.flags.show.is_some() || measures_film;
        Ok(job)
    }

    /// Whether frames are made of their films, rather than developed at once.
    pub(crate) fn looks_at_film(&self) -> bool {
        self.settings.first_hits
    }

    /// Advice on the number of samples for soft effects, where they have fewer.
    pub(crate) fn advice(&self) -> Option<String> {
        let (flags, samples) = (&self.flags, self.settings.samples);
        let has_soft_shadows =
            flags.light_radius.is_positive() || flags.sky_shadows || flags.lights.iter().any(LightSpec::is_wide);
        let (effect, copies) = match () {
            () if has_soft_shadows => ("soft shadows", "edges"),
            () if flags.aperture.is_positive() => ("blurred outlines", "copies"),
            () if flags.shutter > 0.0 => ("streaks", "copies"),
            () => return None,
        };
        let wanted = Quality::SPREAD;
        let said = || format!("{effect} with {samples} samples show {samples} {copies}; {wanted} or more look smooth");
        (samples < wanted && flags.noise == 0.0).then(said)
    }

    /// The background's file, where it has one.
    pub(crate) fn background_file(&self) -> Option<&Path> {
        match &self.flags.background {
            BackgroundSpec::File(path) => Some(path),
            _ => None,
        }
    }

    /// Whether the exposure is to be measured. Views in place of light, and radiance in files, have none.
    pub(crate) fn measures_exposure(&self) -> bool {
        let is_file = !self.scene.to_string_lossy().starts_with(gallery::PREFIX);
        let is_wanted = match self.flags.exposure {
            Some(flag) => flag == ExposureFlag::Auto,
            None => is_file,
        };
        is_wanted && self.flags.show.is_none() && self.format != Format::Exr
    }

    /// The frames of an animation of `duration_seconds`, whose still is at `still_seconds`.
    pub(crate) fn schedule(&self, duration_seconds: f64, still_seconds: f64) -> Schedule {
        let rate: FrameRate = self.output_options.rate;
        let (frames, single) = match &self.moments {
            Moments::Single(seconds) => (0..1, Some(seconds.unwrap_or(still_seconds))),
            Moments::Frames(frames) => (frames.clone(), None),
            Moments::All => (0..rate.frames_within(duration_seconds), None),
        };
        let share = self.flags.shard.map_or_else(|| frames.clone(), |shard| shard.share(&frames));
        Schedule { frames, share, single, rate, duration_seconds }
    }
}

/// The frames of a job, and the moment of each.
#[derive(Clone, Debug)]
pub(crate) struct Schedule {
    /// Numbers of all frames, including other machines'.
    pub(crate) frames: Range<u32>,
    /// Numbers of the frames to render here.
    pub(crate) share: Range<u32>,
    single: Option<f64>,
    rate: FrameRate,
    duration_seconds: f64,
}

impl Schedule {
    /// The second that a frame shows.
    pub(crate) fn seconds(&self, frame: u32) -> f64 {
        self.single.unwrap_or_else(|| self.rate.seconds(frame))
    }

    /// Angle of orbiting lights in a frame, in turns.
    pub(crate) fn turn(&self, frame: u32) -> f64 {
        if self.frames.len() > 1 {
            f64::from(frame - self.frames.start) / self.frames.len() as f64
        } else if self.duration_seconds > 0.0 {
            // The part of the circle that the whole animation takes up to this moment.
            self.seconds(frame) / self.duration_seconds
        } else {
            0.0
        }
    }
}

/// The settings with the lengths of the flags, in a scene of this size.
pub(crate) fn with_lengths(settings: Settings, flags: &RenderFlags, scene_size: f32) -> Settings {
    let length = |length: Length| length.in_scene(scene_size);
    Settings {
        aperture: length(flags.aperture),
        focus: flags.focus.map(length),
        light_radius: length(flags.light_radius),
        ambient_occlusion: length(flags.ambient_occlusion),
        ..settings
    }
}

/// Checks that flags for numbered frames are used with these only.
fn for_numbered_frames(flags: &RenderFlags, are_numbered: bool) -> Result<(), Failure> {
    let asked = [("--shard", flags.shard.is_some()), ("--resume", flags.resume)];
    match asked.into_iter().find(|(_, is_asked)| *is_asked) {
        Some((flag, _)) if !are_numbered => {
            let message = format!("{flag}: this writes a single file, which is rendered as a whole");
            Err(Failure::input(message, "write numbered frames, such as --frames 0..100 -o frame_%04d.png"))
        }
        _ => Ok(()),
    }
}

/// Checks that the engine supports the flags.
fn engine(flags: &RenderFlags) -> Result<(), Failure> {
    match flags.engine {
        EngineKind::Gpu if flags.smooth_terminator => {
            Err(Failure::input("smooth terminators are the CPU's alone", "leave out --engine or --smooth-terminator"))
        }
        EngineKind::Gpu | EngineKind::Auto if flags.texture_memory.is_some() => {
            Err(Failure::input("a GPU has all textures in its own memory", "leave out --engine or --texture-memory"))
        }
        EngineKind::Gpu if flags.simd.is_some() => {
            Err(Failure::input("a GPU has no choice of SIMD level", "leave out --engine or --simd"))
        }
        EngineKind::Gpu => {
            let checked = flags.structure.check_on_gpu();
            checked.map_err(|error| Failure::input(error.to_string(), "leave it out, or --engine"))?;
            Feature::Gpu.check()
        }
        EngineKind::Cpu if flags.device.is_some() => {
            Feature::Gpu.check()?;
            Err(Failure::gpu_named_for_cpu())
        }
        _ => Ok(()),
    }
}

/// Samples and bounces of a picture.
#[derive(Clone, Copy)]
struct Quality {
    samples: u32,
    bounces: u32,
}

impl Quality {
    /// Default maximum of samples with a noise target.
    const MOST_FOR_NOISE: u32 = 1024;
    /// Default number of samples with soft effects.
    const SPREAD: u32 = 64;

    /// The quality of the flags; by default a still is smooth and shows mirrors, and frames are fast.
    fn new(flags: &RenderFlags, is_still: bool) -> Result<Self, Failure> {
        let spread = [
            ("--aperture", flags.aperture.is_positive()),
            ("--shutter", flags.shutter > 0.0),
            ("--light-radius", flags.light_radius.is_positive()),
            ("--sky-shadows", flags.sky_shadows),
            ("--gloss", flags.gloss),
            ("--ambient-occlusion", flags.ambient_occlusion.is_positive()),
            ("--light with a size", flags.lights.iter().any(LightSpec::is_wide)),
        ];
        let spread = spread.into_iter().find(|(_, is_asked)| *is_asked).map(|(what, _)| what);
        let samples = flags.samples.unwrap_or(match spread {
            _ if flags.noise > 0.0 => Self::MOST_FOR_NOISE,
            Some(_) => Self::SPREAD,
            None if is_still => Settings::STILL_SAMPLES,
            None => 1,
        });
        let follows = flags.gloss || is_still;
        let bounces = flags.bounces.unwrap_or(if follows { Settings::STILL_BOUNCES } else { 0 });
        if flags.noise > 0.0 && samples <= 16 {
            let message = "--noise: fewer samples than 16 say little of it";
            return Err(Failure::input(message, "leave out --samples, or say how many there may be, such as 1024"));
        }
        match spread {
            Some(what) if samples == 1 => {
                let message = format!("{what}: a single sample has everything sharp");
                Err(Failure::input(message, "leave out --samples, or give more, such as --samples 64"))
            }
            _ if flags.gloss && bounces == 0 => {
                let hint = "leave out --bounces, or say how many in a row, such as --bounces 2";
                Err(Failure::input("--gloss: no mirrors are followed", hint))
            }
            _ => Ok(Self { samples, bounces }),
        }
    }
}

/// Refuses pictures that take more memory than the limit.
pub(crate) fn check_memory(settings: &Settings, opening: &OpeningFlags) -> Result<(), Failure> {
    let [takes, most] = [settings.picture_bytes(), opening.options().max_memory];
    if takes <= most {
        return Ok(());
    }
    let (Settings { width, height, .. }, [takes, most]) = (settings, [takes, most].map(ByteSize::b));
    let message = format!("a picture of {width}x{height} takes about {takes} of memory, more than {most}");
    Err(Failure::input(message, "make it smaller (--size), or allow more (--max-memory)"))
}

/// Refuses to write over a file that the scene or its background is read from.
pub(crate) fn check_inputs_stay(
    outputs: impl IntoIterator<Item = PathBuf>,
    scene: &Scene,
    background: Option<&Path>,
) -> Result<(), Failure> {
    let is_read: HashSet<PathBuf> = scene
        .files()
        .iter()
        .map(PathBuf::as_path)
        .chain(background)
        .filter_map(|path| fs::canonicalize(path).ok())
        .collect();
    let same = outputs.into_iter().find(|path| fs::canonicalize(path).is_ok_and(|path| is_read.contains(&path)));
    same.map_or(Ok(()), |path| {
        let message = format!("{}: it would be overwritten, and is read for this picture", path.display());
        Err(Failure::input(message, "write to another file (--output)"))
    })
}

fn target(output: Option<PathBuf>, format: Option<Format>, several_frames: bool) -> Result<(Target, Format), Failure> {
    let Some(path) = output else {
        let format = format.unwrap_or(Format::Png);
        let number = if several_frames && !format.is_animation() { "_%04d" } else { "" };
        return Ok((Target::Path(format!("umbrage{number}.{}", format.name()).into()), format));
    };
    if path == Path::new("-") {
        return match format {
            Some(Format::Y4m) => Ok((Target::Stdout, Format::Y4m)),
            _ => Err(Failure::input("only raw video goes to standard output", "add `--format y4m`")),
        };
    }
    match format.or_else(|| Format::of_path(&path)) {
        Some(format) => Ok((Target::Path(path), format)),
        None => Err(Failure::input(
            format!("{}: the name doesn't tell the format", path.display()),
            format!("use {}, or add `--format FORMAT`", extensions(|_| true)),
        )),
    }
}

fn is_numbered(target: &Target) -> Result<bool, Failure> {
    match target {
        Target::Path(path) => Ok(NumberedPath::parse(path)?.is_some()),
        Target::Stdout => Ok(false),
    }
}

fn bit_depths(format: Format, bits: Option<u8>) -> Result<(BitDepth, FloatDepth), Failure> {
    let (levels, floats) = (BitDepth::default(), FloatDepth::default());
    let wrong = |bits: u8| {
        let message = format!("--bit-depth {bits}: {} files don't come with that", format.name());
        Failure::input(message, "PNG and APNG have 8 or 16 bits a channel, EXR 16 or 32, the others 8")
    };
    match (format, bits) {
        (Format::Exr, Some(16)) => Ok((levels, FloatDepth::Half)),
        (Format::Exr, Some(32)) => Ok((levels, FloatDepth::Full)),
        (Format::Png | Format::Apng, Some(16)) => Ok((BitDepth::Sixteen, floats)),
        (Format::Exr, Some(8)) => Err(wrong(8)),
        (_, None | Some(8)) => Ok((levels, floats)),
        (_, Some(bits)) => Err(wrong(bits)),
    }
}

fn jpeg_quality(format: Format, quality: Option<u8>) -> Result<JpegQuality, Failure> {
    match quality {
        Some(quality) if format != Format::Jpeg => {
            let message = format!("--quality {quality}: {} files have none", format.name());
            Err(Failure::input(message, "write a .jpg, or leave it out"))
        }
        _ => Ok(quality.and_then(JpegQuality::new).unwrap_or_default()),
    }
}

/// The layers beside the picture, if the format holds them.
fn layers(flags: &RenderFlags, format: Format) -> Result<Layers, Failure> {
    match flags.layers {
        Some(layers) if format != Format::Exr => {
            let message = format!("--layers {layers}: {} files have no layers", format.name());
            Err(Failure::input(message, "write an .exr file, such as -o picture.exr, or several, -o frame_%04d.exr"))
        }
        layers => Ok(layers.unwrap_or_default()),
    }
}

fn background(spec: &BackgroundSpec, max_memory: u64) -> Result<Background, Failure> {
    spec.open_within(max_memory).map_err(|error| {
        let hint =
            "a background is `sky`, `none`, a colour's name, `#rrggbb`, linear `r,g,b` or a latitude-longitude image";
        Failure::input(format!("--background: {error}"), hint)
    })
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::flags::{Command, Flags};

    fn job(arguments: &[&str]) -> Result<Job, Failure> {
        let flags = Flags::try_parse_from([&["umbrage", "render"], arguments].concat()).unwrap();
        let Command::Render(flags) = flags.command else { panic!("not a render") };
        Job::new(*flags)
    }

    fn path(job: &Job) -> &Path {
        match &job.target {
            Target::Path(path) => path,
            Target::Stdout => panic!("standard output"),
        }
    }

    #[test]
    fn nothing_said_is_the_cloth() {
        let job = job(&[]).unwrap();
        assert_eq!((job.scene.as_path(), path(&job)), (Path::new("demo:cloth"), Path::new("umbrage.png")));
        assert_eq!(job.moments, Moments::Single(None));
    }

    #[test]
    fn the_output_decides_what_is_shown() {
        let moments = |arguments: &[&str]| job(arguments).unwrap().moments;
        assert_eq!(moments(&["a.obj"]), Moments::Single(None));
        assert_eq!(moments(&["a.obj", "-o", "a.gif"]), Moments::All);
        assert_eq!(moments(&["a.obj", "-o", "a_%03d.png"]), Moments::All);
        assert_eq!(moments(&["a.obj", "-o", "a.gif", "--time", "2"]), Moments::Single(Some(2.0)));
        assert_eq!(moments(&["a.obj", "--frames", "3..=4"]), Moments::Frames(3..5));
        assert_eq!(path(&job(&["a.obj", "--frames", "3..=4"]).unwrap()), Path::new("umbrage_%04d.png"));
        assert_eq!(path(&job(&["--format", "gif"]).unwrap()), Path::new("umbrage.gif"));
        assert_eq!(job(&["-o", "a.bin", "--format", "exr"]).unwrap().format, Format::Exr);
    }

    #[test]
    fn frames_are_shown_at_their_rate() {
        let job = job(&["a.obj", "--frames", "12..14", "--fps", "24"]).unwrap();
        let schedule = job.schedule(0.0, 0.0);
        assert_eq!((schedule.frames.clone(), schedule.share.clone()), (12..14, 12..14));
        assert_eq!(schedule.seconds(12), 0.5);
    }

    #[test]
    fn a_single_picture_shows_the_scene_at_its_best() {
        let seconds = |arguments: &[&str]| job(arguments).unwrap().schedule(6.0, 2.5).seconds(0);
        assert_eq!((seconds(&[]), seconds(&["--time", "0"])), (2.5, 0.0));
        assert_eq!(seconds(&["--frames", "0..2"]), 0.0);
    }

    #[test]
    fn only_numbered_frames_are_shared_and_resumed() {
        for flag in [&["--resume"][..], &["--shard", "1/2"]] {
            for rest in
                [&[][..], &["-o", "a.gif"], &["--frames", "0..9", "-o", "a.apng"], &["--time", "1", "-o", "%d.png"]]
            {
                let Failure::Input { message, hint } = job(&[flag, rest].concat()).unwrap_err() else { panic!() };
                assert!(message.contains(flag[0]) && hint.unwrap().contains("%04d"), "{message}");
            }
            job(&[flag, &["--frames", "0..9"]].concat()).unwrap();
            job(&[flag, &["-o", "%d.exr"]].concat()).unwrap();
        }
        let shared = job(&["--frames", "2..12", "--shard", "2/3", "--orbit-light"]).unwrap().schedule(0.0, 0.0);
        assert_eq!((shared.share.clone(), shared.turn(7)), (5..8, 0.5), "as in a render of all frames");
    }

    #[test]
    fn one_sample_is_not_spread() {
        for flags in [
            &["--aperture", "0.1"][..],
            &["--shutter", "0.02"],
            &["--light-radius", "0.5"],
            &["--sky-shadows"],
            &["--gloss", "--bounces", "1"],
            &["--ambient-occlusion", "1"],
            &["--light", "point:0,2,0:radius=0.1"],
            &["--light", "rect:0,2,0:0,0,0:0.1x0"],
        ] {
            let Failure::Input { message, hint } = job(&[flags, &["--samples", "1"]].concat()).unwrap_err() else {
                panic!()
            };
            assert!(message.contains(flags[0]) && hint.unwrap().contains("--samples 64"), "{message}");
            assert_eq!(job(flags).unwrap().settings.samples, 64);
            assert_eq!(job(&[flags, &["--samples", "2"]].concat()).unwrap().settings.samples, 2);
        }
    }

    #[test]
    fn soft_effects_say_how_many_samples_they_want() {
        let advice = |arguments: &[&str]| job(arguments).unwrap().advice();
        let soft = "soft shadows with 16 samples show 16 edges; 64 or more look smooth";
        for flag in [&["--sky-shadows"][..], &["--light-radius", "2%"], &["--light", "disk:0,2,0:0,0,0:1"]] {
            assert_eq!(advice(&[flag, &["--samples", "16"]].concat()).as_deref(), Some(soft), "{flag:?}");
            assert_eq!(advice(flag), None);
        }
        assert!(
            advice(&["--aperture", "2%", "--samples", "4"]).unwrap().starts_with("blurred outlines with 4 samples")
        );
        assert!(advice(&["--shutter", "0.1", "--samples", "63"]).unwrap().starts_with("streaks with 63"));
        // Each pixel has directions of its own.
        assert_eq!(advice(&["--ambient-occlusion", "1", "--samples", "4"]), None);
        assert_eq!(advice(&["--sky-shadows", "--noise", "1", "--samples", "32"]), None);
    }

    #[test]
    fn stills_are_smooth_and_frames_are_fast() {
        let quality = |arguments: &[&str]| {
            let Settings { samples, bounces, .. } = job(arguments).unwrap().settings;
            [samples, bounces]
        };
        assert_eq!(quality(&[]), [4, 2]);
        assert_eq!(quality(&["--time", "3", "-o", "a_%d.png"]), [4, 2]);
        for frames in [&["--frames", "0..2"][..], &["-o", "a.gif"], &["-o", "a_%d.png"]] {
            assert_eq!(quality(frames), [1, 0]);
            assert_eq!(quality(&[frames, &["--samples", "8", "--bounces", "1"]].concat()), [8, 1]);
            assert_eq!(quality(&[frames, &["--gloss"]].concat()), [64, 2]);
        }
        for engine in ["cpu", "auto"].into_iter().chain(Feature::Gpu.is_there().then_some("gpu")) {
            assert_eq!(quality(&["--engine", engine]), [4, 2]);
        }
        assert!(job(&["--gloss", "--bounces", "0"]).is_err());
        assert_eq!(quality(&["--noise", "2"]), [1024, 2]);
        assert!(job(&["--noise", "2", "--samples", "16"]).is_err());
    }

    #[test]
    fn films_have_first_hits_for_those_who_look_at_them() {
        let has = |arguments: &[&str]| job(arguments).unwrap().settings.first_hits;
        assert!(has(&["-o", "a.exr"]) && has(&["-o", "a.png", "--show", "depth"]));
        assert!(has(&["-o", "a.png", "--exposure", "auto"]) && !has(&["-o", "a.png", "--exposure", "0"]));
        // The exposure of several frames is measured once, on another film.
        assert!(!has(&["-o", "a_%d.png", "--exposure", "auto"]) && !has(&["-o", "a.gif"]));
    }

    #[test]
    fn layers_belong_to_exr_files() {
        let layers = |arguments: &[&str]| job(arguments).map(|job| job.settings.layers);
        assert_eq!(layers(&["-o", "a.exr", "--layers", "all"]).unwrap(), Layers::all());
        let some = job(&["-o", "a_%d.exr", "--layers", "ids,motion", "--fps", "50"]).unwrap().settings;
        assert_eq!((some.layers.to_string().as_str(), some.motion_seconds), ("motion,ids", 0.02));
        assert_eq!(layers(&["-o", "a.exr"]).unwrap(), Layers::NONE);
        let refused = |arguments: &[&str]| match layers(arguments).unwrap_err() {
            Failure::Input { message, hint } => format!("{message}: {}", hint.unwrap_or_default()),
            other => panic!("{other:?}"),
        };
        assert!(refused(&["-o", "a.png", "--layers", "ids"]).contains("-o picture.exr"));
        assert!(refused(&["-o", "a.gif", "--layers", "all"]).contains("gif files have no layers"));
        let unknown = ["umbrage", "render", "--layers", "ids,depth"];
        assert!(Flags::try_parse_from(unknown).unwrap_err().to_string().contains("`depth`"));
    }

    #[test]
    fn depths_belong_to_formats() {
        let depths = |arguments: &[&str]| {
            job(arguments).map(|job| (job.output_options.bit_depth, job.output_options.float_depth))
        };
        assert_eq!(depths(&["--bit-depth", "16"]).unwrap().0, BitDepth::Sixteen);
        assert_eq!(depths(&["--bit-depth", "32", "-o", "a.exr"]).unwrap().1, FloatDepth::Full);
        assert!(depths(&["--bit-depth", "8", "-o", "a.exr"]).is_err());
        assert!(depths(&["--bit-depth", "16", "-o", "a.gif"]).is_err());
        assert!(depths(&["--bit-depth", "9"]).is_err());
    }

    #[test]
    fn qualities_belong_to_jpegs() {
        let quality = |arguments: &[&str]| job(arguments).map(|job| job.output_options.jpeg_quality.get());
        assert_eq!(quality(&["-o", "a.jpeg"]).unwrap(), 92);
        assert_eq!(quality(&["-o", "a.jpg", "--quality", "70"]).unwrap(), 70);
        let Failure::Input { message, hint } = quality(&["-o", "a.webp", "--quality", "70"]).unwrap_err() else {
            panic!()
        };
        assert!(message.contains("--quality 70: webp") && hint.unwrap().contains(".jpg"), "{message}");
    }
}
