//! `--shard` and `--resume`: parts of a render, which may end at any time and go on.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::fs;
use std::process::Stdio;

use crate::support::Workplace;

const RENDER: [&str; 7] = ["render", "scene.gltf", "--size", "16x12", "-o", "f_%02d.png", "--resume"];

/// Runs the render with further flags, and returns its reported numbers of rendered and of found frames.
fn render(place: &Workplace, flags: &[&str]) -> [usize; 2] {
    let (stdout, _) = place.succeed(&[&RENDER[..], &["--stats", "json"], flags].concat());
    let json: serde_json::Value = serde_json::from_str(&stdout).unwrap();
    [json["frames"].as_array().unwrap().len(), json["already_there"].as_u64().unwrap() as usize]
}

/// All pictures, with their names.
fn pictures(place: &Workplace) -> Vec<(String, Vec<u8>)> {
    let names = place.names().into_iter().filter(|name| name.starts_with("f_"));
    names.map(|name| (name.clone(), fs::read(place.path(&name)).unwrap())).collect()
}

fn replace(place: &Workplace, name: &str, from: &str, to: &str) {
    let text = fs::read_to_string(place.path(name)).unwrap();
    assert!(text.contains(from), "{from} in {text}");
    fs::write(place.path(name), text.replace(from, to)).unwrap();
}

#[test]
fn frames_that_are_there_are_left_out() {
    let place = Workplace::new();
    assert_eq!(render(&place, &["--frames", "0..4"]), [4, 0]);
    assert_eq!(place.names(), [".umbrage", "f_00.png", "f_01.png", "f_02.png", "f_03.png"]);
    let before = pictures(&place);
    let frames = ["--frames", "0..5"];
    assert_eq!(render(&place, &frames), [1, 4], "of another range, and yet the same frames");
    let (_, stderr) = place.succeed(&[&RENDER[..], &frames].concat());
    assert!(stderr.contains("f_%02d.png: 5 of 5 frames were there already"), "{stderr}");
    fs::remove_file(place.path("f_02.png")).unwrap();
    let (_, stderr) = place.succeed(&[&RENDER[..], &frames].concat());
    assert!(stderr.contains("second 0.083 of scene.gltf") && stderr.contains("; 4 of 5 frames were there"), "{stderr}");
    assert_eq!(pictures(&place)[..4], before);
    // Flags that change no picture don't make frames render again.
    for flags in [&["--threads", "1"][..], &["--simd", "sse2"], &["--structure", "bvh"], &["--max-memory", "1GB"]] {
        assert_eq!(render(&place, &[&frames, flags].concat()), [0, 5], "{flags:?}");
    }
}

#[test]
fn what_is_not_as_it_would_be_is_rendered_again() {
    let place = Workplace::new();
    let frames = ["--frames", "0..3", "--background", "around.png"];
    place.succeed(&["render", "scene.gltf", "--size", "8x4", "-o", "around.png"]);
    assert_eq!(render(&place, &frames), [3, 0]);
    let before = pictures(&place);
    let again = |change: &dyn Fn(), flags: &[&str], expected| {
        change();
        assert_eq!(render(&place, &[&frames, flags].concat()), expected, "{flags:?}");
    };
    let one = [1, 2];
    let picture = || place.path("f_01.png");
    let flipped = || {
        let mut bytes = fs::read(picture()).unwrap();
        let middle = bytes.len() / 2;
        bytes[middle] ^= 1;
        fs::write(picture(), bytes).unwrap();
    };
    again(&flipped, &[], one);
    again(&|| fs::File::options().write(true).open(picture()).unwrap().set_len(40).unwrap(), &[], one);
    again(&|| fs::write(picture(), &before[0].1).unwrap(), &[], one);
    let record = ".umbrage/f_01.png.json";
    again(&|| fs::remove_file(place.path(record)).unwrap(), &[], one);
    again(&|| fs::write(place.path(record), "{}").unwrap(), &[], one);
    let other = fs::read(place.path(".umbrage/f_00.png.json")).unwrap();
    again(&|| fs::write(place.path(record), &other).unwrap(), &[], one);
    again(&|| replace(&place, record, env!("CARGO_PKG_VERSION"), "0.0.9"), &[], one);
    assert_eq!(pictures(&place), before);

    let all = [3, 0];
    for flags in [
        &["--samples", "2"][..],
        &["--fps", "12"],
        &["--camera", "far"],
        &["--light", "sun:-1,-2,-1"],
        &["--animation", "none"],
        &["--bit-depth", "16"],
        &["--tone-map", "clip"],
        &["--orbit-light"],
        &["--ground", "matte"],
    ] {
        again(&|| (), flags, all);
        again(&|| (), flags, [0, 3]);
    }
    assert_eq!(render(&place, &["--frames", "0..3", "--background", "sky"]), all);
    again(&|| (), &[], all);
    again(&|| replace(&place, "scene.gltf", "0.8, 0.2", "0.2, 0.8"), &[], all);
    again(&|| replace(&place, "scene.gltf", "0.2, 0.8", "0.8, 0.2"), &[], all);
    assert_eq!(pictures(&place), before);
    let buffer = fs::read(place.path("scene.bin")).unwrap();
    let moved = buffer.iter().enumerate().map(|(index, byte)| if index == 3 { byte ^ 0x80 } else { *byte });
    again(&|| fs::write(place.path("scene.bin"), moved.clone().collect::<Vec<u8>>()).unwrap(), &[], all);
    let other = || drop(place.succeed(&["render", "scene.gltf", "--size", "8x4", "--time", "0.4", "-o", "around.png"]));
    again(&other, &[], all);
}

#[test]
fn a_plain_render_is_not_taken_for_what_it_replaced() {
    let place = Workplace::new();
    assert_eq!(render(&place, &["--frames", "0..2"]), [2, 0]);
    let before = pictures(&place);
    place.succeed(&[&RENDER[..6], &["--frames", "0..2", "--exposure", "1"]].concat());
    assert_eq!(render(&place, &["--frames", "0..2"]), [2, 0]);
    assert_eq!(pictures(&place), before);
}

#[test]
fn shards_at_once_are_one_render() {
    for name in ["f_%02d.png", "f_%02d.exr"] {
        let [whole, parts] = [Workplace::new(), Workplace::new()];
        let flags = ["render", "scene.gltf", "--size", "64x48", "--orbit-light", "--frames", "3..26", "-o", name];
        whole.succeed(&flags);
        let shard = |number: &str| {
            let mut command = parts.command(&[&flags[..], &["--resume", "--quiet", "--shard", number]].concat());
            command.spawn().unwrap()
        };
        // The second of them twice.
        let mut shards = ["1/2", "2/2", "2/2"].map(shard);
        assert!(shards.iter_mut().all(|shard| shard.wait().unwrap().success()));
        assert_eq!(pictures(&whole).len(), 23);
        assert!(pictures(&parts) == pictures(&whole), "{name}");
        let (_, stderr) = parts.succeed(&[&flags[..], &["--resume"]].concat());
        assert!(stderr.contains("23 of 23 frames were there already"), "{stderr}");
    }
}

#[test]
fn there_may_be_more_shards_than_frames() {
    let place = Workplace::new();
    let shard = |number: &str| place.succeed(&[&RENDER[..6], &["--frames", "0..2", "--shard", number]].concat()).1;
    assert!(shard("1/3").contains("no frame is left for shard 1/3"));
    assert!(shard("2/3").contains("second 0.000") && shard("3/3").contains("second 0.042"));
    assert_eq!(place.names(), ["f_00.png", "f_01.png"]);
}

#[test]
fn a_killed_render_goes_on_where_it_ended() {
    let [whole, place] = [Workplace::new(), Workplace::new()];
    let flags = ["--size", "160x120", "--frames", "0..40"];
    whole.succeed(&[&RENDER[..6], &flags].concat());
    let mut found = 0;
    for _ in 0..5 {
        let all = [&RENDER[..], &flags].concat();
        let mut child = place.command(&all).stderr(Stdio::null()).spawn().unwrap();
        let start = pictures(&place).len();
        while pictures(&place).len() < (start + 5).min(40) && child.try_wait().unwrap().is_none() {}
        child.kill().unwrap();
        child.wait().unwrap();
        found = pictures(&place).len();
    }
    fs::write(place.path(".umbrage/.f_07.png.json.partial-x"), b"{").unwrap();
    let [rendered, there] = render(&place, &flags);
    // The kill may have come between a picture and its record.
    assert!(rendered + there == 40 && there > 10 && there + 5 >= found.min(40), "{rendered} {there} {found}");
    assert!(pictures(&place) == pictures(&whole));
    let partial = |name: &str| {
        fs::read_dir(place.path(name))
            .unwrap()
            .any(|entry| entry.unwrap().file_name().to_string_lossy().contains(".partial-"))
    };
    assert!(!partial("") && !partial(".umbrage"));
}

#[test]
fn files_of_a_sequence_and_what_they_name_count() {
    let place = Workplace::new();
    fs::create_dir(place.path("s")).unwrap();
    for number in [1, 2] {
        let corner = f64::from(number) * 0.5;
        let object = format!("mtllib a_{number}.mtl\nv 0 0 0\nv 1 0 0\nv 0 {corner} 0\nusemtl m\nf 1 2 3\n");
        fs::write(place.path(&format!("s/a_{number}.obj")), object).unwrap();
        fs::write(place.path(&format!("s/a_{number}.mtl")), "newmtl m\nKd 0.1 0.2 0.3\n").unwrap();
    }
    let render = |expected: &str| {
        let flags = ["render", "s", "--size", "16x12", "--frames", "0..2", "-o", "f_%d.png", "--resume"];
        let (_, stderr) = place.succeed(&flags);
        assert!(stderr.contains(expected), "{expected} in {stderr}");
    };
    render(", 2 frames rendered in ");
    for (name, from, to) in
        [("s/a_2.obj", "v 1 0 0", "v 2 0 0"), ("s/a_1.mtl", "0.1", "0.7"), ("s/a_2.mtl", "0.1", "0.7")]
    {
        render("2 of 2 frames were there already");
        replace(&place, name, from, to);
        render(", 2 frames rendered in ");
    }
}
