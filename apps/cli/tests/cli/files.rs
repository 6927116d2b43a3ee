//! Messages about files that aren't read, or aren't drawn as a whole.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::fs;

use crate::support::Workplace;

#[test]
fn formats_that_are_not_read_name_the_tool_that_converts_them() {
    let place = Workplace::new();
    for (name, tool) in
        [("a.usdz", "Blender"), ("b.fbx", "Blender"), ("c.blend", "Blender"), ("d.dae", "assimp export")]
    {
        fs::write(place.path(name), b"anything").unwrap();
        for command in ["render", "info"] {
            let error = place.fail(2, &[command, name]);
            assert!(error.contains(name) && error.contains("is not supported") && error.contains(tool), "{error}");
        }
    }
}

#[test]
fn a_file_of_points_and_lines_is_drawn_and_counted() {
    let place = Workplace::new();
    fs::write(place.path("wire.obj"), "v 0 0 0\nv 2 0 0\nv 0 1 0\nl 1 2 3\np 1 3 2 2\n").unwrap();
    let (text, _) = place.succeed(&["info", "wire.obj"]);
    for part in ["points       4\n", "lines        2\n", "bounds       (0, 0, 0) to (2, 1, 0)"] {
        assert!(text.contains(part), "{part} in {text}");
    }
    let (json, _) = place.succeed(&["info", "wire.obj", "--json"]);
    assert!(json.contains("\"points\": 4") && json.contains("\"lines\": 2"), "{json}");
    let render = |size: &str| {
        let flags = ["render", "wire.obj", "--size", "32x32", "--point-size", size, "--line-width", size];
        let (_, stderr) = place.succeed(&[&flags[..], &["--stats", "text", "-o", "wire.png"]].concat());
        assert!(!stderr.contains("warning"), "{stderr}");
        fs::read(place.path("wire.png")).unwrap()
    };
    assert_ne!(render("1"), render("8"));
}

#[test]
fn what_is_not_drawn_is_said_once() {
    let place = Workplace::new();
    let warnings = |name: &str, content: &[u8], flags: &[&str]| {
        fs::write(place.path(name), content).unwrap();
        let all = [&["render", name, "--size", "8x8"], flags].concat();
        let (_, stderr) = place.succeed(&all);
        let (_, quiet) = place.succeed(&[&all[..], &["--quiet"]].concat());
        assert_eq!(quiet, "", "{name}");
        stderr.lines().filter_map(|line| line.strip_prefix("warning: ")).map(str::to_owned).collect::<Vec<_>>()
    };
    let none = warnings("none.gltf", br#"{"asset": {"version": "2.0"}, "scenes": [{"nodes": []}]}"#, &[]);
    assert_eq!(none, ["the file has no triangles in the scene that is shown"]);
    let random: Vec<u8> = (0..4000_u32).map(|byte| (byte.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    let random = warnings("random.obj", &random, &[]);
    assert!(random.iter().any(|warning| warning == "the file has no faces"), "{random:?}");
    assert!(random.iter().any(|warning| warning.contains("unknown statements")), "{random:?}");
    let broken = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv nan 0 0\nf 1 2 3\nf 1 2 4\nf 1 1 2\n";
    let left_out = [
        "frame 0: left out 1 triangle: a coordinate is not finite",
        "frame 0: left out 1 triangle: two corners are in the same place",
    ];
    assert_eq!(warnings("broken.obj", broken, &[]), left_out);
    assert_eq!(warnings("broken.obj", broken, &["--frames", "0..3", "-o", "%d.png"]), left_out);
}

#[test]
fn point_caches_are_called_what_they_are() {
    let place = Workplace::new();
    fs::write(place.path("flag.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let head = [1_i32.to_be_bytes(), 3_i32.to_be_bytes(), 0_f32.to_be_bytes()].concat();
    fs::write(place.path("flag.mdd"), [head, vec![0; 36]].concat()).unwrap();
    let (text, _) = place.succeed(&["info", "flag.mdd"]);
    assert!(text.starts_with("flag.mdd: MDD point cache over an OBJ file\n"), "{text}");
    let (text, _) = place.succeed(&["info", "flag.obj"]);
    assert!(text.starts_with("flag.obj: OBJ model\n"), "{text}");
}

/// A scene with a triangle that has two variants, and more animations than fit in a line.
fn many() -> String {
    let animation = |number: usize| {
        format!(
            r#"{{"name": "clip {number}", "samplers": [{{"input": 1, "output": 2}}],
                 "channels": [{{"sampler": 0, "target": {{"node": 0, "path": "translation"}}}}]}}"#
        )
    };
    let animations: Vec<_> = (0..20).map(animation).collect();
    let scene = fs::read_to_string(Workplace::new().path("scene.gltf")).unwrap();
    let (before, behind) = scene.split_once("\"animations\": [{").unwrap();
    let (_, behind) = behind.split_once("}],\n  \"buffers\"").unwrap();
    let variants = r#""KHR_materials_variants": {"variants": [{"name": "dusk"}, {"name": "dawn"}]}"#;
    let before =
        before.replace("\"extensions\": {\"KHR_lights", &format!("\"extensions\": {{{variants}, \"KHR_lights"));
    format!("{before}\"animations\": [{}],\n  \"buffers\"{behind}", animations.join(","))
}

#[test]
fn all_animations_and_variants_are_listed() {
    let place = Workplace::new();
    fs::write(place.path("many.gltf"), many()).unwrap();
    let (text, _) = place.succeed(&["info", "many.gltf"]);
    assert!((0..20).all(|number| text.contains(&format!("`clip {number}` 0.500 s"))), "{text}");
    assert!(text.contains("variants     2: `dusk`, `dawn`"), "{text}");
    let (json, _) = place.succeed(&["info", "many.gltf", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["animations"].as_array().unwrap().len(), 20);
    assert_eq!(json["variants"], serde_json::json!(["dusk", "dawn"]));
    place.succeed(&["render", "many.gltf", "--size", "8x8", "--variant", "dawn"]);
    let unknown = place.fail(2, &["render", "many.gltf", "--variant", "noon"]);
    assert!(unknown.contains("there is no variant `noon`; the file has `dusk`, `dawn`"), "{unknown}");
    for scene in ["scene.gltf", "demo:cloth"] {
        let none = place.fail(2, &["render", scene, "--variant", "noon"]);
        assert!(none.contains("there is no variant `noon`"), "{none}");
    }
}
