//! `umbrage view`: the window, where the command was built with it.

use crate::failure::Failure;
#[cfg(not(feature = "view"))]
use crate::feature::Feature;
use crate::flags::ViewFlags;

#[cfg(not(feature = "view"))]
pub(crate) fn run(_: ViewFlags) -> Result<(), Failure> {
    Err(Failure::without(Feature::View))
}

#[cfg(feature = "view")]
pub(crate) fn run(flags: ViewFlags) -> Result<(), Failure> {
    use umbrage::EngineKind;
    use umbrage::gpu::Adapter;
    use umbrage_viewer::{EngineChoice, Start, view};

    let device = flags.device.unwrap_or_default();
    let wanted = device.to_lowercase();
    let has_gpu =
        || Adapter::all().iter().any(|found| !found.is_software && found.name.to_lowercase().contains(&wanted));
    let engine = match flags.engine {
        Some(EngineKind::Cpu) if !device.is_empty() => return Err(Failure::gpu_named_for_cpu()),
        None if device.is_empty() => None,
        Some(EngineKind::Cpu) => Some(EngineChoice::Cpu),
        Some(EngineKind::Auto) if !has_gpu() => Some(EngineChoice::Cpu),
        None | Some(EngineKind::Auto | EngineKind::Gpu) => Some(EngineChoice::Gpu(device)),
    };
    crate::threads::use_threads(flags.scene.threads, None)?;
    let start = Start {
        scene: Some(flags.scene.address()),
        options: flags.scene.opening.options_for_pictures(),
        watches: flags.watch,
        engine,
        size: flags.size.map(|size| [size.width, size.height]),
        samples: flags.samples,
        lights: None,
        forgets: flags.forget,
    };
    view(start).map_err(|error| {
        let remedy = remedy(has_display(), !Adapter::all().is_empty());
        Failure::Work(format!("{error}; {remedy}; `umbrage render` needs no window"))
    })
}

/// Whether the environment names a display; other systems than those of X11 and Wayland always have one.
#[cfg(feature = "view")]
fn has_display() -> bool {
    let is_set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    cfg!(any(windows, target_os = "macos")) || ["DISPLAY", "WAYLAND_DISPLAY"].into_iter().any(is_set)
}

/// The remedy, where no window could be opened.
#[cfg(feature = "view")]
fn remedy(has_display: bool, has_adapter: bool) -> &'static str {
    match (has_display, has_adapter) {
        (false, _) => "there is no display: run it on a desktop, or over `ssh -X`, or set DISPLAY or WAYLAND_DISPLAY",
        (true, false) => "nothing can draw it: `umbrage info --devices` names the driver that may be missing",
        (true, true) => {
            "the display that DISPLAY or WAYLAND_DISPLAY names may be gone, or no driver draws on it: \
             `umbrage info --devices` lists these"
        }
    }
}

#[cfg(all(test, feature = "view"))]
mod tests {
    use std::path::Path;

    use clap::Parser;
    use glam::{DVec3, Vec3};
    use umbrage::rays::{Choice, LightSource};
    use umbrage::scene::{Clip, Ground, GroundChoice, OpenOptions};
    use umbrage::spec::{BackgroundSpec, CameraSpec, LightSpec, WorldLookAt};
    use umbrage::{EngineKind, OptionValues, Settings, ToneMap};
    use umbrage_viewer::{CommandLine, EngineChoice};

    use crate::flags::{Command, Flags};
    use crate::job::{Job, Moments};

    #[test]
    fn a_missing_window_has_a_remedy() {
        for (has_display, has_adapter, words) in [
            (false, true, "set DISPLAY"),
            (false, false, "set DISPLAY"),
            (true, false, "umbrage info --devices"),
            (true, true, "umbrage info --devices"),
        ] {
            let remedy = super::remedy(has_display, has_adapter);
            assert!(remedy.contains(words), "{remedy}");
        }
    }

    const ORIGIN: [f64; 3] = [0.0; 3];

    /// Splits a line as a POSIX shell does, into the arguments that `umbrage` gets.
    fn words(line: &str) -> Vec<String> {
        let mut words = vec![String::new()];
        let (mut is_quoted, mut is_escaped) = (false, false);
        for letter in line.chars() {
            match letter {
                '\\' if !is_quoted && !is_escaped => is_escaped = true,
                '\'' if !is_escaped => is_quoted = !is_quoted,
                ' ' if !is_quoted => words.push(String::new()),
                letter => {
                    words.last_mut().expect("a word").push(letter);
                    is_escaped = false;
                }
            }
        }
        words
    }

    fn job(command: &CommandLine<'_>) -> Job {
        let line = command.text().expect("a line");
        let flags = Flags::try_parse_from(words(&line)).unwrap_or_else(|error| panic!("{line}: {error}"));
        let Command::Render(flags) = flags.command else { panic!("{line}") };
        Job::new(*flags).unwrap_or_else(|failure| panic!("{line}: {failure:?}"))
    }

    /// Asserts that the line of `settings` renders them, on an engine.
    fn assert_copied(settings: &Settings, engine: &EngineChoice) {
        let (scene, options) = (Path::new("demo:cloth?triangles=9"), &OpenOptions::default());
        let background = &BackgroundSpec::Sky;
        let job = job(&CommandLine {
            scene,
            options,
            seconds: 0.0,
            camera: None,
            background,
            settings,
            show: None,
            engine,
            origin: ORIGIN,
        });
        assert_eq!(job.settings, *settings);
        let expected = match engine {
            EngineChoice::Cpu => (EngineKind::Cpu, None),
            EngineChoice::Gpu(name) => (EngineKind::Gpu, Some(name.clone()).filter(|name| !name.is_empty())),
        };
        assert_eq!((job.flags.engine, job.flags.device), expected);
    }

    #[test]
    fn every_choice_of_every_option_is_copied_as_it_is_shown() {
        let on_cpu = |settings: Settings| assert_copied(&settings, &EngineChoice::Cpu);
        for structure in crate::choices::structures().iter() {
            on_cpu(Settings { structure: structure.clone(), ..Settings::default() });
            for option in structure.options() {
                let values: Vec<String> = match &option.values {
                    OptionValues::Names(names) => names().iter().map(|(name, _)| (*name).to_owned()).collect(),
                    OptionValues::Whole(range) => vec![range.start().to_string(), range.end().to_string()],
                    OptionValues::WholeOrAuto(range) => vec![range.start().to_string(), "auto".to_owned()],
                    OptionValues::Rectangle => vec!["auto".to_owned(), "-30:30:-20:20.5".to_owned()],
                    OptionValues::Positive => vec!["0.1".to_owned(), "33.3".to_owned()],
                    OptionValues::Share => vec!["0".to_owned(), "0.3".to_owned()],
                    OptionValues::Switch => vec!["true".to_owned(), "false".to_owned()],
                };
                for value in values {
                    let mut structure = structure.clone();
                    if option.name == "tracing-tiles" {
                        structure.set_option("sorting-tile", "8").unwrap();
                    }
                    structure.set_option(option.name, &value).unwrap();
                    on_cpu(Settings { structure, ..Settings::default() });
                }
            }
        }
        for tone_map in ToneMap::all() {
            on_cpu(Settings { tone_map, ..Settings::default() });
        }
        on_cpu(Settings { width: 7, height: 5, samples: 9, exposure_stops: -0.3, ..Settings::default() });
        let spread =
            Settings { samples: 2, aperture: 0.1, shutter_seconds: 0.3, sky_shadows: true, ..Settings::default() };
        for focus in [None, Some(1.2)] {
            on_cpu(Settings { focus, light_radius: 0.7, ..spread.clone() });
        }
        for gloss in [false, true] {
            let (ambient_occlusion, least_contribution) = (0.3, 0.01);
            let drawn = Settings { gloss, ambient_occlusion, least_contribution, bounces: 2, ..Settings::default() };
            on_cpu(Settings { samples: 20, noise: 1.5, ..drawn });
        }
        for sides in umbrage::Sides::all() {
            on_cpu(Settings { sides, bounces: 3, ..Settings::default() });
        }
        on_cpu(Settings { smooth_terminator: true, point_size: 3.5, line_width: 0.5, ..Settings::default() });
        for name in ["", "it's a GPU"] {
            assert_copied(&Settings::default(), &EngineChoice::Gpu(name.to_owned()));
        }
    }

    #[test]
    fn views_of_pixels_are_copied() {
        let (scene, options) = (Path::new("demo:cloth"), &OpenOptions::default());
        let (background, settings, engine) = (&BackgroundSpec::Sky, &Settings::default(), &EngineChoice::Cpu);
        for show in std::iter::once(None).chain(umbrage::PixelView::all().map(Some)) {
            let command = CommandLine {
                scene,
                options,
                seconds: 0.0,
                camera: None,
                background,
                settings,
                show,
                engine,
                origin: ORIGIN,
            };
            assert_eq!(job(&command).flags.show, show);
        }
    }

    #[test]
    fn backgrounds_are_copied() {
        let folder = tempfile::tempdir().unwrap();
        let image = folder.path().join("it's a sky.png");
        let mut encoder = png::Encoder::new(std::fs::File::create(&image).unwrap(), 4, 2);
        encoder.set_color(png::ColorType::Rgb);
        encoder.write_header().unwrap().write_image_data(&[10, 200, 30].repeat(8)).unwrap();
        let (scene, options) = (Path::new("demo:cloth"), &OpenOptions::default());
        let (settings, engine) = (&Settings::default(), &EngineChoice::Cpu);
        let color = BackgroundSpec::Color(Vec3::new(0.1, 0.25, 3.0));
        for background in [&BackgroundSpec::Sky, &BackgroundSpec::Transparent, &color, &BackgroundSpec::File(image)] {
            let (seconds, camera, show) = (0.0, None, None);
            let job = job(&CommandLine {
                scene,
                options,
                seconds,
                camera,
                background,
                settings,
                show,
                engine,
                origin: ORIGIN,
            });
            assert_eq!(job.settings.background, background.open().unwrap());
        }
    }

    #[test]
    fn scenes_cameras_and_lights_are_copied_as_they_are_shown() {
        let light = |text: &str| text.parse::<LightSpec>().unwrap().light(Vec3::ZERO, 1.0);
        let lights = vec![
            light("point:0.1,2,0:radius=0.3"),
            light("sun:0,-1,0:5:1,0.5,0:noshadow"),
            light("spot:0,3,0:0,0,0:60"),
            light("rect:0,3,0:0,0,0:2x0.5"),
        ];
        let settings = Settings { lights: Some(lights.clone()), samples: 2, ..Settings::default() };
        let (position, target) = (DVec3::new(-1.5, 0.1, 9.0), DVec3::ONE);
        let look_at = WorldLookAt { position, target, fov_degrees: 33.3 };
        for camera in [None, Some(CameraSpec::Listed("2".to_owned())), Some(CameraSpec::LookAt(look_at))] {
            for clip in [Clip::Auto, Clip::All, Clip::Rest, Clip::Named("walk 'n' run".to_owned())] {
                let options = &OpenOptions {
                    clip,
                    variant: Some("midnight blue".to_owned()),
                    hidden: vec!["the roof".to_owned(), "wall*".to_owned()],
                    sequence_fps: 12.5,
                    allow_outside: true,
                    max_memory: 1 << 30,
                    crease_degrees: 12.5,
                    ground: GroundChoice::Own(Ground { height: Some(-0.5), ..Ground::default() }),
                    ..OpenOptions::default()
                };
                let (scene, seconds) = (Path::new("it's a scene.glb"), 1.25);
                let (background, settings, engine) = (&BackgroundSpec::Sky, &settings, &EngineChoice::Cpu);
                let job = job(&CommandLine {
                    scene,
                    options,
                    seconds,
                    camera: camera.clone(),
                    background,
                    settings,
                    show: None,
                    engine,
                    origin: ORIGIN,
                });
                assert_eq!((job.scene.as_path(), job.moments), (scene, Moments::Single(Some(seconds))));
                assert_eq!(format!("{:?}", job.flags.scene.opening.options()), format!("{options:?}"));
                assert_eq!(job.flags.camera, camera);
                for (spec, light) in job.flags.lights.iter().zip(&lights) {
                    let said = spec.light(Vec3::ZERO, 1.0);
                    // A spot's direction and cone may differ in their last bits.
                    let is_spot = matches!(light.source, LightSource::Spot { .. });
                    assert_eq!((said.intensity, said.color), (light.intensity, light.color));
                    assert!(
                        said == *light || is_spot && said.casts_shadow == light.casts_shadow,
                        "{said:?}, {light:?}"
                    );
                }
                assert_eq!(job.flags.lights.len(), lights.len());
            }
        }
    }
}
