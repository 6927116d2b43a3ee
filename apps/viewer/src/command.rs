//! The `umbrage render` line that makes the picture on the screen.

use std::fmt::Write;
use std::path::Path;

use umbrage::rays::Choice;
use umbrage::scene::{Clip, GroundChoice, Light, OpenOptions};
use umbrage::spec::{BackgroundSpec, CameraSpec, LightSpec};
use umbrage::{EngineKind, PixelView, Settings, Structure, gallery};

use crate::app::{App, CameraChoice};
use crate::choices::EngineChoice;

/// A picture that a command can render.
#[derive(Debug)]
pub struct CommandLine<'a> {
    /// The scene's address.
    pub scene: &'a Path,
    /// The options for opening it.
    pub options: &'a OpenOptions,
    /// The moment.
    pub seconds: f64,
    /// The camera; `None` for the scene's first.
    pub camera: Option<CameraSpec>,
    /// The background.
    pub background: &'a BackgroundSpec,
    /// The other settings; their camera and background are ignored.
    pub settings: &'a Settings,
    /// The view that is shown in place of light.
    pub show: Option<PixelView>,
    /// The engine.
    pub engine: &'a EngineChoice,
    /// The point of the world that the settings' lights count from.
    pub origin: [f64; 3],
}

/// The line, for a shell.
///
/// # Errors
/// Where no line makes the picture that is shown.
pub(crate) fn line(app: &App) -> Result<String, String> {
    let (Some(open), Some(shown)) = (&app.open, &app.shown) else {
        return Err("There is no picture yet.".to_owned());
    };
    let (choices, origin) = (&app.kept.choices, open.scene.origin());
    let ([width, height], lights) = (shown.whole, app.lights.chosen());
    let command = CommandLine {
        scene: &open.address,
        options: &open.options,
        seconds: shown.picture.seconds,
        camera: match &app.camera {
            CameraChoice::Default => None,
            CameraChoice::OfScene(number) => Some(CameraSpec::Listed(number.to_string())),
            CameraChoice::Free(free) => Some(CameraSpec::LookAt(free.in_world(origin))),
        },
        background: &choices.surroundings,
        settings: &Settings { width, height, lights, ..choices.settings([width, height]) },
        show: app.show.view(),
        engine: &choices.engine,
        origin,
    };
    command.text()
}

impl CommandLine<'_> {
    /// The line, for a POSIX shell.
    ///
    /// # Errors
    /// Where the command has no flag for a part of the picture; the message names it.
    pub fn text(&self) -> Result<String, String> {
        let Self { settings, .. } = self;
        let default = Settings::default();
        let mut line = format!("umbrage render {}", quoted(&self.scene.to_string_lossy()));
        opening(&mut line, self.options);
        flag(&mut line, "time", &self.seconds.to_string());
        flag(&mut line, "size", &format!("{}x{}", settings.width, settings.height));
        if let Some(camera) = &self.camera {
            flag(&mut line, "camera", &camera.to_string());
        }
        if settings.lights.as_ref().is_some_and(Vec::is_empty) {
            return Err("The command has no way to render without any light.".to_owned());
        }
        // With one sample, everything is sharp.
        let is_spread = settings.samples > 1;
        for light in settings.lights.iter().flatten() {
            let shape = if is_spread { light.shape } else { light.shape.narrowed() };
            let light = &Light { shape, ..light.clone() };
            let light = LightSpec::try_from(light).map_err(|why| format!("The command can't say this: {why}."))?;
            flag(&mut line, "light", &light.in_world(self.origin).to_string());
        }
        // The command's defaults for stills have more samples and mirrors than `Settings`.
        if settings.samples != Settings::STILL_SAMPLES || is_drawn(settings) {
            flag(&mut line, "samples", &settings.samples.to_string());
        }
        if settings.noise != default.noise {
            flag(&mut line, "noise", &settings.noise.to_string());
        }
        if is_spread {
            spread(&mut line, settings);
        }
        match self.engine {
            EngineChoice::Cpu => structure(&mut line, &settings.structure),
            EngineChoice::Gpu(name) => {
                flag(&mut line, "engine", EngineKind::Gpu.name());
                if !name.is_empty() {
                    flag(&mut line, "device", name);
                }
            }
        }
        if settings.bounces != Settings::STILL_BOUNCES {
            flag(&mut line, "bounces", &settings.bounces.to_string());
        }
        if settings.least_contribution != default.least_contribution {
            flag(&mut line, "least-contribution", &settings.least_contribution.to_string());
        }
        if settings.sides != default.sides {
            flag(&mut line, "sides", settings.sides.name());
        }
        for (name, size, own) in [
            ("point-size", settings.point_size, default.point_size),
            ("line-width", settings.line_width, default.line_width),
        ] {
            if size != own {
                flag(&mut line, name, &size.to_string());
            }
        }
        if settings.smooth_terminator {
            line.push_str(" --smooth-terminator");
        }
        // By default, the command measures the exposure of files.
        if settings.exposure_stops != default.exposure_stops
            || !self.scene.to_string_lossy().starts_with(gallery::PREFIX)
        {
            flag(&mut line, "exposure", &settings.exposure_stops.to_string());
        }
        if settings.tone_map != default.tone_map {
            flag(&mut line, "tone-map", settings.tone_map.name());
        }
        if let Some(show) = self.show {
            flag(&mut line, "show", show.name());
        }
        if *self.background != BackgroundSpec::default() {
            flag(&mut line, "background", &self.background.to_string());
        }
        Ok(line)
    }
}

/// Whether soft effects change the command's default number of samples.
fn is_drawn(settings: &Settings) -> bool {
    let lights_are_wide = settings.lights.iter().flatten().any(|light| light.shape.is_wide());
    let Settings { aperture, shutter_seconds, light_radius, ambient_occlusion, noise, .. } = *settings;
    let is_spread = aperture > 0.0 || shutter_seconds > 0.0 || light_radius > 0.0 || ambient_occlusion > 0.0;
    is_spread || lights_are_wide || settings.sky_shadows || settings.gloss || noise > 0.0
}

/// Appends the flags of effects that samples are spread over.
fn spread(line: &mut String, settings: &Settings) {
    let Settings { aperture, focus, shutter_seconds, light_radius, .. } = *settings;
    if aperture > 0.0 {
        flag(line, "aperture", &aperture.to_string());
        if let Some(focus) = focus {
            flag(line, "focus", &focus.to_string());
        }
    }
    if shutter_seconds > 0.0 {
        flag(line, "shutter", &shutter_seconds.to_string());
    }
    if light_radius > 0.0 {
        flag(line, "light-radius", &light_radius.to_string());
    }
    if settings.sky_shadows {
        line.push_str(" --sky-shadows");
    }
    if settings.ambient_occlusion > 0.0 {
        flag(line, "ambient-occlusion", &settings.ambient_occlusion.to_string());
    }
    if settings.gloss {
        line.push_str(" --gloss");
    }
}

fn opening(line: &mut String, options: &OpenOptions) {
    match &options.clip {
        Clip::Auto => {}
        Clip::All => flag(line, "animation", "all"),
        Clip::Rest => flag(line, "animation", "none"),
        Clip::Named(name) => flag(line, "animation", name),
    }
    if let Some(variant) = &options.variant {
        flag(line, "variant", variant);
    }
    for name in &options.hidden {
        flag(line, "hide", name);
    }
    if options.sequence_fps != OpenOptions::default().sequence_fps {
        flag(line, "sequence-fps", &options.sequence_fps.to_string());
    }
    if options.allow_outside {
        line.push_str(" --allow-outside");
    }
    if options.ground != GroundChoice::Auto {
        flag(line, "ground", &options.ground.to_string());
    }
    if options.crease_degrees != OpenOptions::default().crease_degrees {
        flag(line, "crease", &options.crease_degrees.to_string());
    }
    if options.max_memory != OpenOptions::default().max_memory {
        flag(line, "max-memory", &options.max_memory.to_string());
    }
}

fn structure(line: &mut String, structure: &Structure) {
    if *structure != Structure::default() {
        flag(line, "structure", &structure.to_string());
    }
}

fn flag(line: &mut String, name: &str, value: &str) {
    // Writing to a string can't fail.
    write!(line, " --{name} {}", quoted(value)).ok();
}

/// A word for a POSIX shell.
fn quoted(word: &str) -> String {
    let is_plain = |letter: char| letter.is_ascii_alphanumeric() || "-_./:,=+".contains(letter);
    if !word.is_empty() && word.chars().all(is_plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_survive_a_shell() {
        assert_eq!(quoted("demo:cloth"), "demo:cloth");
        assert_eq!(quoted("demo:cloth?triangles=9"), "'demo:cloth?triangles=9'");
        assert_eq!(quoted("it's"), r"'it'\''s'");
        assert_eq!(quoted(""), "''");
    }
}
