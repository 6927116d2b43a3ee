//! Failures: the message, the exit code, and nothing half-written.

use std::fs;
use std::io::Read;
use std::process::Stdio;

use crate::support::{Workplace, text};

#[test]
fn wrong_flags_name_what_is_right() {
    let place = Workplace::new();
    for (flags, part) in [
        (&["--size", "100000x2"][..], "16384 pixels a side"),
        (&["--size", "wide"], "such as 1280x720"),
        (&["--samples", "0"], "whole samples from 1 to 4096"),
        (&["--frames", "5..5"], "no frame in that range"),
        (&["--frames", "0..2", "--time", "1"], "cannot be used with"),
        (&["--time", "-1"], "seconds from 0"),
        (&["--fps", "0"], "30000/1001"),
        (&["--sequence-fps", "x"], "files a second"),
        (&["--light", "lamp"], "point:X,Y,Z"),
        (&["--camera", "0,0,0:0,0,0"], "where it looks at"),
        (&["--background", "#12"], "#rrggbb"),
        (&["--background", "none.hdr"], "none.hdr"),
        (&["--background", "."], "not a regular file"),
        (&["--point-size", "0"], "pixels from 0.5 to 100"),
        (&["--line-width", "wide"], "pixels from 0.5 to 100"),
        (&["--exposure", "nan"], "stops from -60 to 60"),
        (&["--threads", "0"], "1..=1024"),
        (&["--simd", "mmx"], "no SIMD level `mmx`"),
        (&["--bit-depth", "12"], "PNG and APNG have 8 or 16"),
        (&["--tone-map", "aces"], "neutral"),
        (&["-o", "a.bmp"], "use .png, .jpg, .webp, .exr, .gif, .apng, .mp4 or .y4m"),
        (&["-o", "-"], "--format y4m"),
        (&["-o", "none/a.png"], "there is no folder none"),
        (&["-o", "."], "format"),
        (&["-o", "a.png", "--frames", "0..2"], "a_%04d.png"),
        (&["-o", "%d_%d.png"], "only one number"),
        (&["-o", "a.gif", "--fps", "60"], "at most 50 frames"),
        (&["-o", "a.mp4", "--size", "15x12"], "16x12 in place of 15x12"),
        (&["-o", "a.jpg", "--quality", "0"], "1..=100"),
        (&["--max-memory", "much"], "--max-memory"),
        (&["--max-memory", "1kB"], "--max-memory"),
        (&["--max-memory", "1GB", "--size", "4096x4096"], "a picture of 4096x4096 takes about 1.9 GiB"),
        (&["--texture-memory", "much"], "--texture-memory"),
        (&["--texture-memory", "65535"], "give 64.0 KiB or more"),
        (&["--smooth-terminator", "--engine", "gpu"], "smooth terminators are the CPU's alone"),
        (&["--texture-memory", "1MB", "--engine", "gpu"], "a GPU has all textures in its own memory"),
        (&["--texture-memory", "1MB", "--engine", "auto"], "a GPU has all textures in its own memory"),
        (&["--shard", "0/8"], "counted from 1: 1/8 to 8/8"),
        (&["--shard", "9/8", "--frames", "0..9"], "the last is 8/8"),
        (&["--shard", "third"], "such as 3/8"),
        (&["--shard", "1/2"], "--shard: this writes a single file"),
        (&["--resume", "-o", "a.gif", "--frames", "0..2"], "--resume: this writes a single file"),
        (&["--resume", "-o", "none/%d.png", "--frames", "0..2"], "there is no folder none"),
        (&["--no-such-flag"], "--no-such-flag"),
    ] {
        let stderr = place.fail(2, &[&["render", "scene.gltf", "--size", "8x8"], flags].concat());
        assert!(stderr.contains(part), "{flags:?}: {part} in {stderr}");
        assert!(place.names().is_empty(), "{flags:?}: {:?}", place.names());
    }
}

#[test]
fn wrong_scenes_are_bad_input() {
    let place = Workplace::new();
    let missing = place.fail(2, &["render", "none.glb"]);
    assert!(missing.contains("none.glb") && missing.contains("hint: "), "{missing}");
    assert!(place.fail(2, &["render", "demo:no-such-demo"]).contains("no-such-demo"));
    let on_demand = place.fail(2, &["render", "demo:cloth", "--texture-memory", "1MB"]);
    assert!(on_demand.contains("make their few textures in memory"), "{on_demand}");
    let unknown = place.fail(2, &["render", "demo:cloth", "--animation", "nothing"]);
    assert!(unknown.contains("no animation `nothing`"), "{unknown}");
    fs::write(place.path("broken.glb"), b"glTF\x02").unwrap();
    assert!(place.fail(2, &["render", "broken.glb"]).contains("broken.glb"));
    fs::write(place.path("notes.txt"), b"hello").unwrap();
    assert!(place.fail(2, &["render", "notes.txt"]).contains("notes.txt"));
    fs::File::create(place.path("long.glb")).unwrap().set_len(1 << 40).unwrap();
    let long = place.fail(2, &["render", "long.glb"]);
    assert!(long.contains("long.glb would take 1.0 TiB") && long.contains("--max-memory"), "{long}");
    assert_eq!(place.names(), ["broken.glb", "long.glb", "notes.txt"]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_a_failure_to_write() {
    let place = Workplace::new();
    for format in ["png", "jpg", "webp", "exr", "gif", "apng", "y4m"] {
        let flags = ["render", "scene.gltf", "--size", "400x300", "-o", "/dev/full", "--format", format];
        let stderr = place.fail(1, &flags);
        assert!(stderr.contains("/dev/full: can't be written"), "{format}: {stderr}");
    }
}

#[test]
fn a_reader_that_leaves_ends_the_command_quietly() {
    let place = Workplace::new();
    let flags = ["render", "scene.gltf", "--size", "200x150", "--format", "y4m", "-o", "-", "--frames", "0..200"];
    let mut child = place.command(&flags).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut start = [0; 9];
    let mut stdout = child.stdout.take().unwrap();
    stdout.read_exact(&mut start).unwrap();
    assert_eq!(&start, b"YUV4MPEG2");
    drop(stdout);
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), text(&output.stderr).as_str()), (Some(0), ""));
}

#[test]
fn an_earlier_file_stays_when_the_render_fails() {
    let place = Workplace::new();
    fs::write(place.path("a.gif"), b"before").unwrap();
    place.fail(2, &["render", "scene.gltf", "-o", "a.gif", "--camera", "none", "--size", "8x8"]);
    assert_eq!(fs::read(place.path("a.gif")).unwrap(), b"before");
    assert_eq!(place.names(), ["a.gif"]);
}
