//! The `umbrage render` line that makes the picture on the screen.

use std::fmt::Write;

use glam::Vec3;
use umbrage::rays::{Choice, LightSource};
use umbrage::scene::{Clip, Light, OpenOptions};
use umbrage::{EngineKind, OptionValues, Structure, ToneMap};

use crate::app::{App, CameraChoice};
use crate::choices::{Choices, EngineChoice, SurroundingsChoice};
use crate::light_list::INNER;

/// The line, for a shell.
///
/// # Errors
/// Where the line can't say what is shown.
pub(crate) fn line(app: &App) -> Result<String, String> {
    let (Some(open), Some(shown)) = (&app.open, &app.shown) else {
        return Err("There is no picture yet.".to_owned());
    };
    let picture = &shown.picture;
    let mut line = format!("umbrage render {}", quoted(&open.address.to_string_lossy()));
    opening(&mut line, &open.options);
    if picture.seconds != 0.0 {
        flag(&mut line, "time", &picture.seconds.to_string());
    }
    flag(&mut line, "size", &format!("{}x{}", picture.view.width, picture.view.height));
    match &app.camera {
        CameraChoice::Default => {}
        CameraChoice::OfScene(number) => flag(&mut line, "camera", &number.to_string()),
        CameraChoice::Free(free) => {
            let camera = format!("{}:{}:{}", vector(free.position), vector(free.target), free.fov_degrees);
            flag(&mut line, "camera", &camera);
        }
    }
    if let Some(lights) = app.lights.chosen() {
        if lights.is_empty() {
            return Err("The command has no way to render without any light.".to_owned());
        }
        for light in &lights {
            flag(&mut line, "light", &light_text(light)?);
        }
    }
    chosen(&mut line, &app.kept.choices);
    Ok(line)
}

fn opening(line: &mut String, options: &OpenOptions) {
    match &options.clip {
        Clip::Auto => {}
        Clip::All => flag(line, "animation", "all"),
        Clip::Rest => flag(line, "animation", "none"),
        Clip::Named(name) => flag(line, "animation", name),
    }
    if options.sequence_fps != OpenOptions::default().sequence_fps {
        flag(line, "sequence-fps", &options.sequence_fps.to_string());
    }
}

fn chosen(line: &mut String, choices: &Choices) {
    if choices.samples != 1 {
        flag(line, "samples", &choices.samples.to_string());
    }
    match &choices.engine {
        EngineChoice::Cpu => {
            structure(line, choices.structures.chosen());
            if choices.bounces > 0 {
                flag(line, "bounces", &choices.bounces.to_string());
            }
        }
        EngineChoice::Gpu(name) => {
            flag(line, "engine", EngineKind::Gpu.name());
            if !name.is_empty() {
                flag(line, "device", name);
            }
        }
    }
    if choices.culls_back_faces {
        line.push_str(" --cull-back-faces");
    }
    if choices.exposure_stops != 0.0 {
        flag(line, "exposure", &choices.exposure_stops.to_string());
    }
    if choices.tone_map != ToneMap::default() {
        flag(line, "tone-map", choices.tone_map.name());
    }
    if let SurroundingsChoice::Color(color) = choices.surroundings {
        flag(line, "background", &vector(color.into()));
    }
}

fn structure(line: &mut String, structure: Structure) {
    if structure.name() != Structure::default().name() {
        flag(line, "structure", structure.name());
    }
    for (option, value) in structure.changed_options() {
        match option.values {
            OptionValues::Switch => line.extend([" --", option.name]),
            _ => flag(line, option.name, &value),
        }
    }
}

/// A light as `--light` takes it.
fn light_text(light: &Light) -> Result<String, String> {
    let source = match light.source {
        LightSource::Point { position } => format!("point:{}", vector(position)),
        LightSource::Directional { direction } => format!("sun:{}", vector(direction)),
        LightSource::Spot { position, direction, inner_radians, outer_radians } => {
            if (inner_radians - INNER * outer_radians).abs() > 1e-3 * outer_radians {
                return Err("The command has no way to say how soft this scene's spot lights are.".to_owned());
            }
            let degrees = 2.0 * outer_radians.to_degrees();
            format!("spot:{}:{}:{degrees}", vector(position), vector(position + direction))
        }
    };
    if light.range.is_some() {
        return Err("The command has no way to say how far this scene's lights reach.".to_owned());
    }
    let shadow = if light.casts_shadow { "" } else { ":noshadow" };
    Ok(format!("{source}:{}:{}{shadow}", light.intensity, vector(light.color)))
}

fn vector(vector: Vec3) -> String {
    format!("{},{},{}", vector.x, vector.y, vector.z)
}

fn flag(line: &mut String, name: &str, value: &str) {
    // Nothing is wrong with writing to a string.
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

    #[test]
    fn lights_are_said_to_the_last_bit() {
        let light = Light {
            name: "".into(),
            source: LightSource::Point { position: Vec3::new(0.1, -2.0, 1e-7) },
            color: Vec3::new(1.0, 0.5, 0.25),
            intensity: 12.3,
            range: None,
            casts_shadow: true,
        };
        assert_eq!(light_text(&light).expect("a light"), "point:0.1,-2,0.0000001:12.3:1,0.5,0.25");
        let hidden = Light { casts_shadow: false, ..light.clone() };
        assert!(light_text(&hidden).expect("a light").ends_with(":noshadow"));
        assert!(light_text(&Light { range: Some(3.0), ..light }).is_err());
    }
}
