//! `umbrage info`, and the command's texts about itself.

use std::fs;

use crate::support::{self, Workplace};

#[test]
fn info_shows_what_is_in_a_scene() {
    let place = Workplace::new();
    let (stdout, _) = place.succeed(&["info", "scene.gltf"]);
    for part in [
        "scene.gltf: glTF scene",
        "triangles    1\n",
        "bounds       (-1, -1, 0) to (1, 1, 0)",
        "size         2.828427, the diagonal of the bounds; a length of 2% is 0.056568",
        "`paint`",
        "`lamp` point 60 candela",
        "2: `front` at (0, 0, 5), `far` at (0, 0, 25)",
        "`slide` 0.500 s, plays",
    ] {
        assert!(stdout.contains(part), "{part} in {stdout}");
    }
    let (stdout, _) = place.succeed(&["info", "scene.gltf", "--animation", "none"]);
    assert!(stdout.contains("`slide` 0.500 s\n"), "{stdout}");
}

#[test]
fn info_comes_as_json() {
    let place = Workplace::new();
    let (stdout, _) = place.succeed(&["info", "scene.gltf", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!(json["triangles"], 1);
    assert_eq!(json["duration_seconds"], 0.5);
    assert_eq!(json["animations"][0]["plays"], true);
    assert_eq!(json["lights"][0]["kind"], "point");
    assert_eq!(json["bounds"][1][1], 1.0);
    assert!((json["size"].as_f64().unwrap() - 8_f64.sqrt()).abs() < 1e-6);
    assert_eq!(place.fail(2, &["info", "none.obj"]).lines().count(), 2);
}

#[test]
fn help_version_pages_and_completions_are_there() {
    let place = Workplace::new();
    for page in [&["--help"][..], &["render", "--help"], &["-h"]] {
        let (stdout, _) = place.succeed(page);
        assert!(stdout.contains("Examples:") && stdout.contains("Exit codes:"), "{stdout}");
    }
    let (help, _) = place.succeed(&["render", "--help"]);
    assert!(help.lines().count() < 240, "{help}");
    assert!(help.contains("Width and height in pixels [default: 1280x720]\n"), "{help}");
    assert!(help.contains("PNG and APNG [possible values: fast, small] [default: fast]\n"), "{help}");
    let (stdout, _) = place.succeed(&["--version"]);
    assert_eq!(stdout.trim(), concat!("umbrage ", env!("CARGO_PKG_VERSION")));
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        assert!(place.succeed(&["completions", shell]).0.contains("orbit-light"), "{shell}");
    }
    let (stdout, _) = place.succeed(&["man"]);
    assert!(stdout.contains(".TH umbrage 1") && stdout.contains("Exit codes"), "{stdout}");
    fs::create_dir(place.path("man1")).unwrap();
    place.succeed(&["man", "--dir", "man1"]);
    assert!(fs::read_to_string(place.path("man1/umbrage-render.1")).unwrap().contains("orbit"));
    assert!(place.fail(1, &["man", "--dir", "none"]).contains("none: can't be written"));
}

#[test]
fn the_gallery_is_listed() {
    let place = Workplace::new();
    let (stdout, _) = place.succeed(&["info"]);
    assert!(stdout.contains("demo:cloth ") && stdout.contains("?triangles=N"), "{stdout}");
    let (stdout, _) = place.succeed(&["info", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&stdout).unwrap();
    for demo in json.as_array().unwrap() {
        assert!(demo["triangles"].as_u64().unwrap() > 0 && demo["scene"].as_str().unwrap().starts_with("demo:"));
    }
    let (stdout, _) = place.succeed(&["info", "demo:cloth?triangles=300"]);
    assert!(stdout.contains("demo:cloth?triangles=300: built-in scene"), "{stdout}");
}

/// The commands of the examples in `--help`, without the programs that they are piped into.
#[allow(clippy::unwrap_used, reason = "a test may panic")]
fn examples(help: &str) -> Vec<Vec<String>> {
    let (_, behind) = help.split_once("Examples:\n").unwrap();
    let (examples, _) = behind.split_once("\n\n").unwrap();
    let lines = examples.lines().filter_map(|line| line.strip_prefix("  umbrage "));
    let words = |line: &str| {
        let command = line.split('|').next().unwrap().trim();
        command.split_whitespace().map(|word| word.trim_matches('\'').to_owned()).collect()
    };
    lines.map(words).collect()
}

/// Tests that take long, which `cargo run -p ci` runs with `--all` alone.
mod long {
    use super::*;

    #[test]
    fn examples_of_the_help_work() {
        let place = Workplace::new();
        let (help, _) = place.succeed(&["--help"]);
        // Windows have a test of their own, `view`.
        let opens = |words: &Vec<String>| ["view", "model.glb"].contains(&words[0].as_str());
        let examples: Vec<_> = examples(&help).into_iter().filter(|words| !opens(words)).collect();
        assert!(examples.len() >= 11, "{help}");
        for mut words in examples {
            let example = words.join(" ");
            for word in &mut words {
                if let Some(demo) = word.strip_prefix("demo:") {
                    *word = format!("demo:{}?triangles=300", demo.split('?').next().unwrap());
                }
            }
            let mut arguments: Vec<&str> = words.iter().map(String::as_str).collect();
            if ["render", "heatmap"].contains(&arguments[0]) {
                arguments.extend(["--size", "16x9"]);
            }
            if words.contains(&"y4m".to_owned()) || words.contains(&"--frames".to_owned()) {
                // Of two values, the last one counts.
                arguments.extend(["--frames", "0..2"]);
            }
            let output = place.run(&arguments);
            assert!(output.status.success(), "{example}: {}", support::text(&output.stderr));
        }
        let names = place.names();
        for name in ["umbrage.png", "glass.png", "shatter.gif", "g_0000.png", "marbles.exr"] {
            assert!(names.iter().any(|found| found == name), "{name} in {names:?}");
        }
    }
}
