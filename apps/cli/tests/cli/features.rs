//! Optional parts: messages of builds without them, and their presence in builds with them.

use std::fs;
use std::path::Path;

use crate::support::Workplace;

/// The hint of a command that was built without a part.
#[cfg(not(all(feature = "avif", feature = "gpu", feature = "papers", feature = "view")))]
fn brought_by(feature: &str) -> String {
    format!(
        "`cargo run --release --features {feature} -- …` or `cargo install --path apps/cli --features full` brings it"
    )
}

#[cfg(not(feature = "gpu"))]
#[test]
fn gpus_are_brought_by_a_feature() {
    let place = Workplace::new();
    let lines = format!("error: this `umbrage` was built without its GPU engine\nhint: {}\n", brought_by("gpu"));
    for arguments in [
        &["render", "--engine", "gpu"][..],
        &["render", "scene.gltf", "--device", "radeon"],
        &["render", "scene.gltf", "--engine", "gpu", "--device", "radeon"],
        &["info", "--devices"],
        &["info", "--devices", "--json"],
    ] {
        assert_eq!(place.fail(2, arguments), lines, "{arguments:?}");
    }
    assert!(place.names().is_empty(), "{:?}", place.names());
    let automatic = ["render", "scene.gltf", "--size", "8x8", "--engine", "auto"];
    let (_, stderr) = place.succeed(&automatic);
    let note = "note: rendering on the CPU: this `umbrage` was built without its GPU engine";
    assert!(stderr.contains(&format!("{note}; {}\n", brought_by("gpu"))), "{stderr}");
    let (_, quiet) = place.succeed(&[&automatic[..], &["--quiet"]].concat());
    assert_eq!(quiet, "");
    assert!(place.succeed(&["render", "--help"]).0.contains("in builds with `--features gpu`"));
}

#[cfg(feature = "gpu")]
#[test]
fn gpus_are_listed() {
    let place = Workplace::new();
    let (stdout, _) = place.succeed(&["info", "--devices", "--json"]);
    let devices: serde_json::Value = serde_json::from_str(&stdout).unwrap();
    assert!(devices.as_array().unwrap().iter().all(|device| device["name"].is_string()), "{stdout}");
    assert!(place.fail(2, &["render", "--device", "radeon"]).contains("add `--engine gpu`"));
}

#[cfg(not(feature = "papers"))]
#[test]
fn structures_of_the_papers_are_brought_by_a_feature() {
    let place = Workplace::new();
    for structure in ["kdtree", "listed:sorting-tile=8"] {
        let stderr = place.fail(2, &["render", "scene.gltf", "--structure", structure]);
        assert!(
            stderr.contains(&format!("built without its structures of the papers: {}", brought_by("papers"))),
            "{stderr}"
        );
    }
    assert!(place.succeed(&["structures"]).0.contains(&brought_by("papers")));
}

#[cfg(not(feature = "view"))]
#[test]
fn the_window_is_brought_by_a_feature() {
    let place = Workplace::new();
    let lack = "this `umbrage` was built without its window";
    for arguments in [&["view"][..], &["view", "scene.gltf", "--engine", "gpu"]] {
        let stderr = place.fail(2, arguments);
        assert_eq!(stderr, format!("error: {lack}\nhint: {}\n", brought_by("view")), "{arguments:?}");
    }
    let (_, stderr) = place.succeed(&["scene.gltf", "--size", "8x8"]);
    let note = format!("note: {lack}, so it writes a picture; {}\n", brought_by("view"));
    assert!(stderr.starts_with(&note) && stderr.contains("scene.umbrage.png"), "{stderr}");
}

#[test]
fn textures_in_avif_are_read_or_brought_by_a_feature() {
    let place = Workplace::new();
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../crates/verify/corpus");
    fs::copy(corpus.join("glb/avif.glb"), place.path("vase.glb")).unwrap();
    fs::copy(corpus.join("images/gray.avif"), place.path("gray.avif")).unwrap();
    fs::write(place.path("paint.mtl"), "newmtl paint\nmap_Kd gray.avif\n").unwrap();
    let corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n";
    fs::write(place.path("face.obj"), format!("mtllib paint.mtl\n{corners}usemtl paint\nf 1/1 2/2 3/3\n")).unwrap();
    let render = |scene| [&["render", "--size", "8x8"][..], &[scene]].concat();
    #[cfg(feature = "avif")]
    for scene in ["vase.glb", "face.obj"] {
        let (_, stderr) = place.succeed(&render(scene));
        assert!(!stderr.contains("warning"), "{stderr}");
    }
    #[cfg(not(feature = "avif"))]
    {
        let hint = format!("hint: {}\n", brought_by("avif"));
        // One file requires its texture, the other is shown without.
        for arguments in [&render("vase.glb")[..], &["info", "vase.glb"]] {
            let stderr = place.fail(2, arguments);
            assert!(stderr.contains("vase.glb: the glTF extension `EXT_texture_avif`"), "{stderr}");
            assert!(stderr.ends_with(&hint), "{stderr}");
        }
        let (_, stderr) = place.succeed(&render("face.obj"));
        assert!(stderr.contains("warning: ") && stderr.contains("gray.avif: AVIF textures need"), "{stderr}");
        assert!(stderr.contains(&hint), "{stderr}");
        let (stdout, stderr) = place.succeed(&["info", "face.obj", "--json"]);
        assert!(stdout.contains("gray.avif: AVIF textures need") && stderr == hint, "{stdout}{stderr}");
    }
}
