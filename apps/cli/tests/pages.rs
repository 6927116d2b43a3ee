//! `umbrage info`, and what the command says about itself.

mod support;

use std::fs;

use support::Workplace;

#[test]
fn info_shows_what_is_in_a_scene() {
    let place = Workplace::new();
    let (stdout, _) = place.succeed(&["info", "scene.gltf"]);
    for part in [
        "scene.gltf: glTF scene",
        "triangles    1\n",
        "bounds       (-1, -1, 0) to (1, 1, 0)",
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
    assert_eq!(place.fail(2, &["info", "none.obj"]).lines().count(), 2);
}

#[test]
fn help_version_pages_and_completions_are_there() {
    let place = Workplace::new();
    for page in [&["--help"][..], &["render", "--help"], &["-h"]] {
        let (stdout, _) = place.succeed(page);
        assert!(stdout.contains("Examples:") && stdout.contains("Exit codes:"), "{stdout}");
    }
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
