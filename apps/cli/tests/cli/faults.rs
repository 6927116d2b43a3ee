//! Faults of the system, and signals that end the command: no panic, nothing half-written under a final name, and no
//! hidden file that stays.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::fs::{self, File};
use std::os::unix::process::ExitStatusExt;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::support::{Workplace, decode_png, text};

/// Longer than any machine takes to start rendering.
const PATIENCE: Duration = Duration::from_secs(30);

fn is_partial(name: &str) -> bool {
    name.contains(".partial-")
}

/// Starts a render, and waits until a hidden file is there.
fn started(place: &Workplace, flags: &[&str]) -> Child {
    waited_for(place, &mut place.command(flags))
}

fn waited_for(place: &Workplace, command: &mut Command) -> Child {
    let mut child = command.stderr(Stdio::null()).spawn().unwrap();
    let deadline = Instant::now() + PATIENCE;
    while !place.names().iter().any(|name| is_partial(name)) {
        assert!(Instant::now() < deadline, "{:?}", place.names());
        assert!(child.try_wait().unwrap().is_none(), "it ended before it was seen to write");
        sleep(Duration::from_millis(2));
    }
    child
}

/// Runs a shell line, in which `umbrage` is the command.
fn shell(place: &Workplace, line: &str) -> (ExitStatus, String) {
    let line = line.replace("umbrage", env!("CARGO_BIN_EXE_umbrage"));
    let mut shell = Command::new("sh");
    let output = shell.args(["-c", &line]).current_dir(place.path("")).stdin(Stdio::null()).output().unwrap();
    (output.status, text(&output.stderr))
}

#[cfg(target_os = "linux")]
#[test]
fn nobody_has_to_hear_what_is_said() {
    let place = Workplace::new();
    let render = "umbrage render scene.gltf --size 8x8 -o a.png";
    for (line, code) in [
        (&format!("{render} --stats text 2>/dev/full")[..], 0),
        (&format!("{render} --stats text 2>&-"), 0),
        (&format!("{render} --camera none 2>/dev/full"), 2),
        ("umbrage render --no-such-flag 2>/dev/full", 2),
        (&format!("{render} --stats json >/dev/full"), 1),
        ("umbrage info scene.gltf >/dev/full", 1),
        ("umbrage info scene.gltf --json >/dev/full", 1),
        ("umbrage --help >/dev/full", 1),
        ("umbrage man >/dev/full", 1),
        ("umbrage completions bash >/dev/full", 1),
        (&format!("{render} --format y4m -o - >/dev/full"), 1),
    ] {
        let (status, stderr) = shell(&place, line);
        assert_eq!(status.code(), Some(code), "{line}: {stderr}");
        assert!(code != 1 || stderr.contains("error: "), "{line}: {stderr}");
    }
}

#[test]
fn signals_leave_nothing_behind() {
    for (name, number) in [("INT", 2), ("TERM", 15)] {
        let place = Workplace::new();
        fs::write(place.path("a.gif"), b"before").unwrap();
        let flags = ["render", "scene.gltf", "--size", "200x150", "-o", "a.gif", "--frames", "0..100000"];
        let mut child = started(&place, &flags);
        assert!(shell(&place, &format!("kill -{name} {}", child.id())).0.success());
        let status = child.wait().unwrap();
        // A shell adds 128 and says 130 or 143.
        assert_eq!(status.signal(), Some(number), "{status}");
        assert_eq!(place.names(), ["a.gif"]);
        assert_eq!(fs::read(place.path("a.gif")).unwrap(), b"before");
    }
}

#[test]
fn signals_end_the_encoder_before_it_writes() {
    let place = Workplace::new();
    place.stand_in_for_ffmpeg("sleep 0.4; cat > $to");
    let flags = ["render", "scene.gltf", "--size", "16x12", "-o", "a.mp4", "--frames", "0..100000"];
    let mut command = place.command(&flags);
    let mut child = waited_for(&place, command.env("PATH", place.path_with_stand_in()));
    assert!(shell(&place, &format!("kill -INT {}", child.id())).0.success());
    assert_eq!(child.wait().unwrap().signal(), Some(2));
    sleep(Duration::from_millis(600));
    assert_eq!(place.names(), ["bin"]);
}

#[test]
fn kills_leave_whole_frames_and_the_next_render_sweeps() {
    let place = Workplace::new();
    let render = ["render", "scene.gltf", "--size", "200x150", "-o", "f_%06d.png", "--quiet", "--frames"];
    // More than can be written before the kill, however slowly this process polls.
    let endless = [&render[..], &["0..1000000"]].concat();
    let mut leftovers = 0;
    for turn in 0..12_u64 {
        let mut child = started(&place, &endless);
        // Anywhere in a frame, and now and then in between.
        sleep(Duration::from_micros(turn * 7919 % 5000));
        child.kill().unwrap();
        child.wait().unwrap();
        let names = place.names();
        leftovers += names.iter().filter(|name| is_partial(name)).count();
        for name in names.iter().filter(|name| !is_partial(name)) {
            assert_eq!(decode_png(&place.path(name)).len(), 200 * 150, "{name}");
        }
    }
    // Each command removes the leftovers of the last one, so that they don't add up.
    assert!(place.names().iter().filter(|name| is_partial(name)).count() <= 1, "{leftovers}: {:?}", place.names());
    place.succeed(&[&render[..], &["0..40"]].concat());
    let names = place.names();
    assert!(names.len() >= 40 && !names.iter().any(|name| is_partial(name)), "{names:?}");
}

#[test]
fn the_last_of_two_writers_wins() {
    let place = Workplace::new();
    for _ in 0..4 {
        let mut writers: Vec<Child> = ["96x64", "64x96"]
            .iter()
            .map(|size| {
                let flags = ["render", "scene.gltf", "--size", size, "-o", "a.png", "--frames", "0..1", "--quiet"];
                place.command(&flags).spawn().unwrap()
            })
            .collect();
        assert!(writers.iter_mut().all(|writer| writer.wait().unwrap().success()));
        assert_eq!(decode_png(&place.path("a.png")).len(), 96 * 64);
        assert_eq!(place.names(), ["a.png"]);
    }
}

#[test]
fn folders_that_cannot_be_written_are_failures() {
    use std::os::unix::fs::PermissionsExt;
    use std::os::unix::process::CommandExt;

    const NOBODY: u32 = 65_534;
    let place = Workplace::new();
    let permit = |name: &str, mode| fs::set_permissions(place.path(name), fs::Permissions::from_mode(mode)).unwrap();
    fs::create_dir(place.path("closed")).unwrap();
    permit("", 0o755);
    permit("closed", 0o555);
    // Root may write everywhere, so it becomes another user.
    let is_root = File::create(place.path("closed/probe")).is_ok();
    for name in ["closed/a.png", "closed/a.gif"] {
        let mut command = place.command(&["render", "scene.gltf", "--size", "8x8", "-o", name]);
        if is_root {
            command.uid(NOBODY);
        }
        let Ok(output) = command.output() else {
            eprintln!("skipped: the command may not be run by nobody");
            return;
        };
        let stderr = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{stderr}");
        assert!(stderr.contains(&format!("error: {name}: can't be written")), "{stderr}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_disk_that_fills_up_keeps_what_was_whole() {
    let place = Workplace::new();
    let folder = place.path("small");
    fs::create_dir(&folder).unwrap();
    if !shell(&place, "mount -t tmpfs -o size=128k none small 2>/dev/null").0.success() {
        eprintln!("skipped: this user may not mount a small disk");
        return;
    }
    let flags = ["--size", "200x150", "--frames", "0..2000", "-o"];
    let stderr = place.fail(1, &[&["render", "scene.gltf", "--quiet"], &flags[..], &["small/f_%04d.png"]].concat());
    let mut whole = 0;
    for entry in fs::read_dir(&folder).unwrap() {
        let path = entry.unwrap().path();
        assert_eq!(decode_png(&path).len(), 200 * 150, "{}", path.display());
        whole += 1;
    }
    fs::write(folder.join("a.gif"), b"before").unwrap_or_default();
    let animation = place.fail(1, &[&["render", "scene.gltf", "--quiet"], &flags[..], &["small/a.gif"]].concat());
    let left: Vec<String> =
        fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    assert!(shell(&place, "umount small").0.success());
    assert!(stderr.contains("can't be written") && animation.contains("small/a.gif: can't be written"), "{stderr}");
    assert!(whole > 0 && !left.iter().any(|name| is_partial(name)), "{left:?}");
}

/// Writes `textured.gltf`, and beside it the image of zeros that it names.
fn write_textured(place: &Workplace, side: u32) {
    let scene = fs::read_to_string(place.path("scene.gltf")).unwrap();
    let textured = scene
        .replace(r#""baseColorFactor""#, r#""baseColorTexture": {"index": 0}, "baseColorFactor""#)
        .replace(r#""scene": 0,"#, r#""scene": 0, "images": [{"uri": "i.png"}], "textures": [{"source": 0}],"#);
    fs::write(place.path("textured.gltf"), textured).unwrap();
    let mut encoder = png::Encoder::new(File::create(place.path("i.png")).unwrap(), side, side);
    encoder.set_compression(png::Compression::Fastest);
    encoder.write_header().unwrap().write_image_data(&vec![0; (side * side) as usize]).unwrap();
}

#[cfg(target_os = "linux")]
#[test]
fn textures_need_room_for_their_file() {
    let place = Workplace::new();
    write_textured(&place, 256);
    let render = "umbrage render textured.gltf --size 8x8 --quiet -o a.png --texture-memory 64KiB";
    let (status, stderr) = shell(&place, &format!("TMPDIR=none {render}"));
    assert_eq!(status.code(), Some(1), "{stderr}");
    assert!(stderr.contains("it is in none: free some room there, name another folder (TMPDIR)"), "{stderr}");
    fs::create_dir(place.path("small")).unwrap();
    if !shell(&place, "mount -t tmpfs -o size=128k none small 2>/dev/null").0.success() {
        eprintln!("skipped: this user may not mount a small disk");
        return;
    }
    let (status, stderr) = shell(&place, &format!("TMPDIR=small {render}"));
    let left = fs::read_dir(place.path("small")).unwrap().count();
    assert!(shell(&place, "umount small").0.success());
    assert_eq!((status.code(), left), (Some(1), 0), "{stderr}");
    assert!(stderr.contains("No space left on device") && stderr.contains("(TMPDIR)"), "{stderr}");
    assert!(!place.path("a.png").exists());
}

#[cfg(target_os = "linux")]
#[test]
fn what_the_system_has_no_memory_for_is_said() {
    let place = Workplace::new();
    write_textured(&place, 4096);
    File::create(place.path("long.ply")).unwrap().set_len(3 << 30).unwrap();
    let limited = "ulimit -v 1500000; umbrage render --threads 1 --quiet -o a.png";
    for (line, code, part) in [
        (
            &format!("{limited} --size 4096x4096 --max-memory 8GB scene.gltf")[..],
            1,
            "no memory for a picture of 4096x4096",
        ),
        (&format!("{limited} --size 4096x4096 scene.gltf"), 2, "of memory, more than 732.4 MiB"),
        (&format!("{limited} --size 8x8 long.ply"), 2, "long.ply"),
        (&format!("{limited} --size 8x8 --max-memory 64MiB textured.gltf"), 2, "an image of 4096x4096 texels"),
        (&format!("{limited} --size 8x8 textured.gltf"), 0, ""),
        (
            "ulimit -v 1500000; umbrage heatmap --threads 1 --size 4096x4096 --max-memory 8GB scene.gltf",
            1,
            "no memory for a",
        ),
        (
            "ulimit -v 1000000; umbrage render --threads 1000 --size 1024x1024 -o a.png scene.gltf",
            1,
            "--threads 1000: no memory for their stacks; fewer may do",
        ),
        ("umbrage heatmap --size 4096x4096 --max-memory 1GB scene.gltf", 2, "--max-memory"),
    ] {
        let (status, stderr) = shell(&place, line);
        assert_eq!(status.code(), Some(code), "{line}: {stderr}");
        assert!(stderr.contains(part) && stderr.lines().count() <= 2, "{line}: {stderr}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn files_that_may_not_grow_are_an_error() {
    let place = Workplace::new();
    // Blocks of 512 bytes.
    let (status, stderr) = shell(&place, "ulimit -f 8; umbrage render scene.gltf --size 300x200 -o a.exr");
    assert_eq!(status.code(), Some(1), "{stderr}");
    assert!(stderr.contains("a.exr: can't be written: File too large"), "{stderr}");
    assert!(!place.names().iter().any(|name| name == "a.exr" || is_partial(name)), "{:?}", place.names());
}

#[test]
fn files_that_are_read_are_not_written_over() {
    let place = Workplace::new();
    write_textured(&place, 16);
    let before = fs::read(place.path("i.png")).unwrap();
    for flags in [
        &["render", "textured.gltf", "--size", "8x8", "-o", "i.png"][..],
        &["heatmap", "textured.gltf", "--size", "8x8", "-o", "./i.png"],
    ] {
        let stderr = place.fail(2, flags);
        assert!(stderr.contains("i.png: it would be overwritten") && stderr.contains("--output"), "{stderr}");
    }
    let numbered = ["render", "textured.gltf", "--size", "8x8", "--frames", "0..3", "-o"];
    fs::copy(place.path("i.png"), place.path("i_2.png")).unwrap();
    let sky = [&numbered[..], &["i_%d.png", "--background", "i_2.png"]].concat();
    assert!(place.fail(2, &sky).contains("i_2.png: it would be overwritten"));
    assert!(fs::read(place.path("i.png")).unwrap() == before);
    place.succeed(&["render", "textured.gltf", "--size", "8x8", "-o", "j.png"]);
}

#[test]
fn more_threads_than_a_picture_has_work_for_are_not_started() {
    let place = Workplace::new();
    let (_, stderr) = place.succeed(&["render", "scene.gltf", "--size", "16x16", "--threads", "1000", "-o", "a.png"]);
    assert!(stderr.contains("note: --threads 1000: ") && stderr.contains("the picture is too small"), "{stderr}");
}

#[test]
fn scenes_as_large_as_numbers_go_are_shown() {
    let place = Workplace::new();
    fs::write(place.path("huge.obj"), "v 3.4e38 0 0\nv -3.4e38 1 0\nv 0 3.4e38 1\nf 1 2 3\n").unwrap();
    place.succeed(&["render", "huge.obj", "--size", "32x32", "-o", "a.png"]);
    let colors: std::collections::HashSet<_> = decode_png(&place.path("a.png")).into_iter().collect();
    assert!(colors.len() > 20, "{} colours are no triangle before a sky", colors.len());
}
