//! `umbrage render`: its files, and the effect of each option.

use std::fs;

use crate::support::{Workplace, decode_png, text};

/// The sum of all levels.
fn brightness(pixels: &[[u8; 3]]) -> u32 {
    pixels.as_flattened().iter().map(|&level| u32::from(level)).sum()
}

#[test]
fn a_still_is_a_picture_of_the_scene() {
    let place = Workplace::new();
    let (stdout, stderr) = place.succeed(&["render", "scene.gltf", "--time", "0", "--size", "16x12"]);
    assert_eq!(stdout, "");
    assert!(stderr.starts_with("umbrage.png: opened in ") && stderr.contains(" s, rendered in "), "{stderr}");
    assert!(stderr.ends_with(" s: second 0.000 of scene.gltf (1 triangle) at 16x12\n"), "{stderr}");
    assert_eq!(place.names(), ["umbrage.png"]);
    let pixels = decode_png(&place.path("umbrage.png"));
    let [red, green, _] = pixels[6 * 16 + 8];
    assert!(red > green + 60, "the painted triangle is in the middle: {red} {green}");
}

#[test]
fn every_format_is_written() {
    let place = Workplace::new();
    for (name, start) in [
        ("a.png", &b"\x89PNG"[..]),
        ("a.JPEG", b"\xff\xd8\xff\xe0\0\x10JFIF"),
        ("a.webp", b"RIFF"),
        ("a.EXR", b"\x76\x2f\x31\x01"),
        ("a.gif", b"GIF89a"),
        ("a.apng", b"\x89PNG"),
        ("a.y4m", b"YUV4MPEG2 W16 H12 F24:1 "),
    ] {
        place.succeed(&["render", "scene.gltf", "--size", "16x12", "--frames", "0..1", "-o", name]);
        assert!(fs::read(place.path(name)).unwrap().starts_with(start), "{name}");
    }
    place.succeed(&["render", "scene.gltf", "--size", "16x12", "--format", "exr", "-o", "b.bin"]);
    assert!(fs::read(place.path("b.bin")).unwrap().starts_with(b"\x76\x2f\x31\x01"));
    assert_eq!(place.names(), ["a.EXR", "a.JPEG", "a.apng", "a.gif", "a.png", "a.webp", "a.y4m", "b.bin"]);
}

#[cfg(unix)]
#[test]
fn mp4_files_are_made_by_ffmpeg_or_not_at_all() {
    let place = Workplace::new();
    let render = ["render", "scene.gltf", "--size", "16x12", "--frames", "0..3", "-o", "a.mp4"];
    place.stand_in_for_ffmpeg("cat > $to");
    let output = place.command(&render).env("PATH", place.path_with_stand_in()).output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    let video = fs::read(place.path("a.mp4")).unwrap();
    assert_eq!(video.windows(6).filter(|bytes| bytes == b"FRAME\n").count(), 3);
    fs::remove_file(place.path("a.mp4")).unwrap();
    place.stand_in_for_ffmpeg("echo 'Unknown encoder' >&2; exit 8");
    let failed = place.command(&render).env("PATH", place.path_with_stand_in()).output().unwrap();
    assert_eq!(
        (failed.status.code(), text(&failed.stderr).as_str()),
        (Some(1), "error: a.mp4: can't be written: ffmpeg failed: Unknown encoder\n")
    );
    let missing = place.command(&render).env("PATH", place.path("")).output().unwrap();
    let said = text(&missing.stderr);
    assert!(
        missing.status.code() == Some(2) && said.contains("install it") && said.contains("or write .y4m or .gif"),
        "{said}"
    );
    assert_eq!(place.names(), ["bin"]);
}

#[test]
fn bit_depths_change_the_file() {
    let place = Workplace::new();
    place.succeed(&["render", "scene.gltf", "--size", "16x12", "--bit-depth", "16", "-o", "a.png"]);
    let reader = png::Decoder::new(std::io::BufReader::new(fs::File::open(place.path("a.png")).unwrap()));
    assert_eq!(reader.read_info().unwrap().info().bit_depth, png::BitDepth::Sixteen);
    let contains = |name: &str, bits: &str| {
        place.succeed(&["render", "scene.gltf", "--size", "64x64", "--bit-depth", bits, "-o", name]);
        fs::metadata(place.path(name)).unwrap().len()
    };
    assert!(contains("half.exr", "16") < contains("full.exr", "32"));
}

#[test]
fn pixels_show_what_they_saw() {
    let place = Workplace::new();
    let shown = |more: &[&str]| {
        place.succeed(&[&["render", "demo:cloth?triangles=200", "--size", "32x24", "-o", "a.png"], more].concat());
        decode_png(&place.path("a.png"))
    };
    let mut pictures = vec![shown(&[])];
    for view in ["normals", "uv", "depth", "wireframe"] {
        let picture = shown(&["--show", view]);
        assert!(!pictures.contains(&picture), "{view}");
        assert!(shown(&["--show", view, "--exposure", "-3"]) == picture, "{view}");
        pictures.push(picture);
    }
    let hint = place.fail(2, &["render", "scene.gltf", "--show", "smell"]);
    assert!(hint.contains("smell") && hint.contains("wireframe"), "{hint}");
}

#[test]
fn layers_are_the_same_bytes_every_time() {
    let place = Workplace::new();
    let bytes = |name: &str, more: &[&str]| {
        place.succeed(&[&["render", "scene.gltf", "--size", "16x12", "-o", name], more].concat());
        fs::read(place.path(name)).unwrap()
    };
    let all = bytes("a.exr", &["--layers", "all"]);
    for name in ["b.exr", "c.exr"] {
        assert!(bytes(name, &["--layers", "all", "--threads", "1"]) == all, "{name}");
    }
    assert!(bytes("d.exr", &["--layers", "ids"]).len() < all.len());
    let hint = place.fail(2, &["render", "scene.gltf", "--layers", "ids", "-o", "a.png"]);
    assert!(hint.contains("--layers ids") && hint.contains(".exr"), "{hint}");
}

#[test]
fn frames_are_numbered_and_move() {
    let place = Workplace::new();
    let (_, said) = place.succeed(&["render", "scene.gltf", "--size", "16x12", "--frames", "2..5", "--fps", "12"]);
    assert!(said.starts_with("umbrage_%04d.png: opened in ") && said.contains(" s, 3 frames rendered in "), "{said}");
    assert!(said.ends_with(" a second): scene.gltf (1 triangle) at 16x12\n"), "{said}");
    assert_eq!(place.names(), ["umbrage_0002.png", "umbrage_0003.png", "umbrage_0004.png"]);
    let frame = decode_png(&place.path("umbrage_0003.png"));
    assert_ne!(frame, decode_png(&place.path("umbrage_0002.png")));
    assert_eq!(frame, place.picture(&["--time", "0.25", "--samples", "1"]), "frame 3 at 12 a second is second 0.25");
}

#[test]
fn an_animation_is_shown_whole() {
    let place = Workplace::new();
    place.succeed(&["render", "scene.gltf", "--size", "16x12", "--fps", "10", "-o", "a.gif"]);
    let mut decoder = gif::DecodeOptions::new().read_info(fs::File::open(place.path("a.gif")).unwrap()).unwrap();
    let mut frames = 0;
    while decoder.read_next_frame().unwrap().is_some_and(|frame| frame.delay == 10) {
        frames += 1;
    }
    assert_eq!(frames, 5);
}

#[test]
fn raw_video_goes_to_standard_output() {
    let place = Workplace::new();
    let arguments = ["render", "scene.gltf", "--size", "15x11", "--format", "y4m", "-o", "-", "--fps", "30000/1001"];
    let output = place.run(&[&arguments[..], &["--frames", "0..=1", "--stats", "json"]].concat());
    assert!(output.status.success());
    let header_end = output.stdout.iter().position(|&byte| byte == b'\n').unwrap();
    assert_eq!(
        text(&output.stdout[..header_end]),
        "YUV4MPEG2 W15 H11 F30000:1001 Ip A1:1 C420jpeg XCOLORRANGE=LIMITED"
    );
    let frame = b"FRAME\n".len() + 15 * 11 + 2 * 8 * 6;
    assert_eq!(output.stdout.len(), header_end + 1 + 2 * frame);
    assert!(output.stdout[header_end + 1 + frame..].starts_with(b"FRAME\n"));
    assert!(text(&output.stderr).contains("\"frames\": ["), "the statistics make way for the video");
    assert!(place.names().is_empty());
    let full = place.run(&[&arguments[..], &["--frames", "0..1", "--chroma", "444"]].concat());
    let header_end = full.stdout.iter().position(|&byte| byte == b'\n').unwrap();
    assert!(text(&full.stdout[..header_end]).contains(" C444 "));
    assert_eq!(full.stdout.len(), header_end + 1 + 6 + 3 * 15 * 11);
}

#[test]
fn cameras_are_chosen_by_name_number_or_place() {
    let place = Workplace::new();
    let own = place.picture(&[]);
    assert_eq!(place.picture(&["--camera", "front"]), own);
    let far = place.picture(&["--camera", "far"]);
    assert_ne!(far, own);
    assert_eq!(place.picture(&["--camera", "1"]), far);
    // 0.9 radians, as the file says.
    assert_eq!(place.picture(&["--camera", "0,0,25:0,0,0:51.5662"]), far);
    let below = place.picture(&["--camera", "-0.5,-2,5:0,0,0"]);
    assert!(below != own && below != far);
    let refused = place.fail(2, &["render", "scene.gltf", "--camera", "nearby"]);
    assert!(refused.contains("no camera `nearby`") && refused.contains("1 `far`"), "{refused}");
}

#[test]
fn lights_replace_the_scenes() {
    let place = Workplace::new();
    let dark = ["--time", "0", "--background", "#000000", "--exposure", "0"];
    let lit = |flags: &[&str]| brightness(&place.picture(&[&dark[..], flags].concat()));
    assert!(lit(&[]) > 0);
    assert_eq!(lit(&["--light", "point:0,0,3:0"]), 0, "a light without strength gives none");
    let one = lit(&["--light", "sun:0,0,-1:1"]);
    assert!(one > 0 && lit(&["--light", "sun:0,0,-1:1", "--light", "point:0,0,3:5"]) > one);
    assert!(lit(&["--light", "spot:0,0,3:0,0,0:20:9"]) > 0);
    assert_eq!(lit(&["--light", "spot:0,0,3:0,0,9:20:9"]), 0, "the cone points away");
    let red = place.picture(&["--background", "0,0,0", "--light", "sun:0,0,-1:2:1,0,0"]);
    assert!(red.iter().any(|pixel| pixel[0] > 0));
}

#[test]
fn an_orbiting_light_goes_round_once() {
    let place = Workplace::new();
    let flags = ["render", "scene.gltf", "--animation", "none", "--background", "#000000", "--size", "16x12"];
    place.succeed(&[&flags[..], &["--orbit-light", "--frames", "0..4", "-o", "%d.png"]].concat());
    let frames = ["0.png", "1.png", "2.png", "3.png"].map(|name| decode_png(&place.path(name)));
    assert_eq!(frames[0], place.picture(&["--animation", "none", "--background", "#000000", "--samples", "1"]));
    // The lamp at (1, 2, 3) goes to (3, 2, −1), (−1, 2, −3) and (−3, 2, 1); the triangle faces it from z = 0.
    let [first, behind, opposite, last] = frames.each_ref().map(|frame| brightness(frame));
    assert!(first > last && last > 0 && behind == 0 && opposite == 0, "{first} {behind} {opposite} {last}");
}

#[test]
fn several_lights_orbit_together() {
    let place = Workplace::new();
    let flags = [
        "render",
        "scene.gltf",
        "--background",
        "#000000",
        "--size",
        "16x12",
        "--frames",
        "0..2",
        "--exposure",
        "0",
        "-o",
        "%d.png",
    ];
    let lamps = ["--light", "point:1,2,3:9:1,0,0", "--light", "point:2,1,3:9:0,1,0"];
    // How much red and green there is once both lamps that move are behind the triangle.
    let behind = |orbiting: &str| {
        place.succeed(&[&flags[..], &lamps, &[orbiting]].concat());
        let pixels = decode_png(&place.path("1.png"));
        [0, 1].map(|channel| pixels.iter().map(|pixel| u32::from(pixel[channel])).sum::<u32>() > 0)
    };
    assert_eq!(behind("--orbit-light"), [false, true]);
    assert_eq!(behind("--orbit-light=1"), [true, false]);
    assert_eq!(behind("--orbit-light=all"), [false, false]);
    let error = place.fail(2, &[&flags[..], &lamps, &["--orbit-light=2"]].concat());
    assert!(error.contains("no light 2") && error.contains("2 lights, numbers 0 to 1"), "{error}");
}

#[test]
fn pictures_follow_exposure_tone_map_and_background() {
    let place = Workplace::new();
    let plain = place.picture(&[]);
    assert!(brightness(&place.picture(&["--exposure", "-2"])) < brightness(&plain));
    assert!(brightness(&place.picture(&["--exposure", "1"])) > brightness(&plain));
    assert_ne!(place.picture(&["--exposure", "3", "--tone-map", "clip"]), place.picture(&["--exposure", "3"]));
    let corner = place.picture(&["--background", "#204060", "--tone-map", "clip"])[0];
    assert_eq!(corner, [0x20, 0x40, 0x60]);
    assert_eq!(place.picture(&["--background", "0,0,1", "--tone-map", "clip"])[0], [0, 0, 255]);
    fs::copy(place.path("picture.png"), place.path("sky.png")).unwrap();
    assert_ne!(place.picture(&["--background", "sky.png"]), plain);
}

#[test]
fn exposure_is_measured_for_files_and_once_for_an_animation() {
    let place = Workplace::new();
    let lit = |candela: &str, more: &[&str]| {
        let light = format!("point:1,2,3:{candela}");
        place.picture(&[&["--time", "0", "--background", "black", "--light", &light], more].concat())
    };
    let bright = lit("80", &[]);
    // Four times as much light is two stops less.
    assert_eq!(lit("20", &[]), bright);
    assert_eq!(lit("20", &["--exposure", "auto"]), bright);
    let fixed = ["--exposure", "0"];
    assert!(brightness(&lit("20", &fixed)) < brightness(&lit("80", &fixed)));
    let brightest = bright.as_flattened().iter().max().unwrap();
    assert!((200..255).contains(brightest), "nearly white: {brightest}");
    // The triangle moves away from the lamp.
    let first_of = |frames: &str| {
        place.succeed(&["render", "scene.gltf", "--size", "16x12", "--frames", frames, "-o", "f_%d.png"]);
        decode_png(&place.path("f_0.png"))
    };
    let first = first_of("0..1");
    assert_eq!(first_of("0..5"), first);
    assert_ne!(place.picture(&["--time", "0", "--samples", "1", "--bounces", "0"]), first);
}

#[test]
fn lengths_are_world_units_or_shares_of_the_scene() {
    let place = Workplace::new();
    // Half of the diagonal of the triangle's box of 2 by 2 by 0, at every moment.
    for time in ["0", "0.25"] {
        for [share, length] in [
            ["--aperture=50%", "--aperture=1.4142135"],
            ["--light-radius=50%", "--light-radius=1.4142135"],
            ["--light=point:1,2,3:radius=50%", "--light=point:1,2,3:radius=1.4142135"],
            ["--light=disk:1,2,3:0,0,0:50%", "--light=disk:1,2,3:0,0,0:1.4142135"],
        ] {
            let rest = ["--samples", "4", "--time", time];
            let pictures = [share, length, "--exposure=0"].map(|flag| place.picture(&[&[flag][..], &rest].concat()));
            assert!(pictures[0] == pictures[1] && pictures[0] != pictures[2], "{share}");
        }
    }
    let sharp = place.picture(&["--aperture", "50%", "--focus", "176.7767%", "--samples", "4"]);
    assert_eq!(sharp, place.picture(&["--aperture", "50%", "--focus", "5", "--samples", "4"]));
    let refused = |flags: &[&str]| place.fail_said(&[&["render", "scene.gltf"], flags].concat());
    for flag in ["--aperture", "--light-radius", "--ambient-occlusion", "--focus"] {
        for value in ["-3%", "%", "2 parts"] {
            let said = refused(&["--aperture", "1", flag, value]);
            assert!(said.contains("is no length: give world units") && said.contains(value), "{said}");
        }
    }
    assert!(refused(&["--aperture", "200%"]).contains("more than the whole scene"));
    let sun = refused(&["--light", "sun:0,-1,0", "--light-radius", "2%"]);
    assert!(sun.contains("in degrees, such as --light-radius 0.27"), "{sun}");
    fs::write(place.path("none.gltf"), br#"{"asset": {"version": "2.0"}, "scenes": [{"nodes": []}]}"#).unwrap();
    let empty = place.fail_said(&["render", "none.gltf", "--ambient-occlusion", "2%"]);
    assert!(empty.contains("the scene has no size") && empty.contains("give world units"), "{empty}");
}

#[test]
fn threads_do_not_change_the_picture_and_samples_smooth_it() {
    let place = Workplace::new();
    let one = place.picture(&["--threads", "1"]);
    assert_eq!(place.picture(&["--threads", "3"]), one);
    assert_ne!(place.picture(&["--samples", "8"]), one);
}

#[test]
fn simd_levels_do_not_change_the_picture() {
    let place = Workplace::new();
    let widest = place.picture(&[]);
    for level in umbrage::rays::SimdLevel::available() {
        assert_eq!(place.picture(&["--simd", level.name()]), widest, "{level}");
    }
}

#[test]
fn animations_are_chosen() {
    let place = Workplace::new();
    let rest = place.picture(&["--time", "0.25", "--animation", "none"]);
    assert_eq!(rest, place.picture(&["--time", "0"]));
    let moved = place.picture(&["--time", "0.25", "--animation", "slide"]);
    assert_ne!(moved, rest);
    assert_eq!(place.picture(&["--time", "0.25", "--animation", "0"]), moved);
    assert_eq!(place.picture(&["--time", "0.25", "--animation", "all"]), moved);
    assert_eq!(place.picture(&[]), moved, "the middle of half a second");
    assert!(place.fail(2, &["render", "scene.gltf", "--animation", "jump"]).contains("jump"));
}

#[test]
fn statistics_come_as_text_or_json() {
    let place = Workplace::new();
    let flags = ["render", "scene.gltf", "--size", "16x12", "--frames", "0..3", "-o", "%d.png", "--stats"];
    let (stdout, stderr) = place.succeed(&[&flags[..], &["text"]].concat());
    assert_eq!(stdout, "");
    for part in [
        "3 frames",
        "see",
        "shadow",
        "camera rays",
        "192",
        "triangles",
        "pixel)",
        "settled by the predicate",
        "for 192 rays",
    ] {
        assert!(stderr.contains(part), "{part} in {stderr}");
    }
    let (stdout, _) = place.succeed(&[&flags[..], &["json"]].concat());
    let json: serde_json::Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!(json["frames"].as_array().unwrap().len(), 3);
    assert_eq!(json["frames"][2]["camera_rays"], 192);
    assert_eq!(json["frames"][1]["triangles"], 1);
    assert_eq!(json["frames"][2]["settled_camera_rays"]["of_rays"], 192);
    assert!(json["frames"][2]["settled_shadow_rays"]["tests"].is_u64());
    assert!(json["median"]["render_milliseconds"].as_f64().unwrap() > 0.0);
    let stages: Vec<&str> =
        json["median"]["stages"].as_array().unwrap().iter().map(|stage| stage["name"].as_str().unwrap()).collect();
    assert!(stages.contains(&"see") && stages.contains(&"shadow"), "{stages:?}");
}

#[test]
fn pipes_see_no_progress_and_quiet_says_nothing() {
    let place = Workplace::new();
    // Long enough for the bar to come, were standard error a terminal.
    let flags = ["render", "scene.gltf", "--size", "1000x1000", "--samples", "3", "--frames", "0..8", "-o", "a.y4m"];
    let (_, stderr) = place.succeed(&flags);
    assert!(!stderr.contains(['\r', '\x1b']) && stderr.lines().count() == 1, "{stderr:?}");
    let (stdout, stderr) = place.succeed(&["render", "scene.gltf", "--size", "16x12", "-q"]);
    assert_eq!((stdout.as_str(), stderr.as_str()), ("", ""));
}

#[test]
fn mirrors_are_followed_where_that_is_asked_for() {
    let place = Workplace::new();
    let render = |bounces: &str| {
        place.succeed(&["render", "demo:glass", "--size", "64x40", "--bounces", bounces, "-o", "a.png"]);
        decode_png(&place.path("a.png"))
    };
    assert!(render("0") != render("1"), "a mirror shows the other balls");
    let refused = |flags: &[&str]| place.fail(2, &[&["render", "scene.gltf"], flags].concat());
    assert!(refused(&["--bounces", "1025"]).contains("1024"));
}

#[test]
fn far_files_take_cameras_and_lights_of_the_world() {
    let place = Workplace::new();
    let obj = |x: u32, y: u32| {
        let vertex = |dx: f64, dy: f64| format!("v {} {} 0\n", f64::from(x) + dx, f64::from(y) + dy);
        [vertex(-0.5, -0.5), vertex(0.5, -0.5), vertex(0.25, 0.5), "f 1 2 3\n".to_owned()].concat()
    };
    let picture = |name: &str, x: u32, y: u32| {
        fs::write(place.path("shape.obj"), obj(x, y)).unwrap();
        let camera = format!("{x}.25,{y},2:{x},{y},0:50");
        let light = format!("point:{x},{}.5,3:40", y + 1);
        let flags = ["render", "shape.obj", "--size", "24x16", "--camera", &camera, "--light", &light, "-o", name];
        place.succeed(&flags);
        fs::read(place.path(name)).unwrap()
    };
    assert_eq!(picture("far.png", 500_000, 4_649_776), picture("near.png", 0, 0));
    let names_origin = |name: &str, x: u32, y: u32| {
        let file = picture(name, x, y);
        file.windows(14).any(|window| window == b"umbrage/origin")
    };
    assert!(names_origin("far.exr", 500_000, 4_649_776) && !names_origin("near.exr", 0, 0));

    let info = |x: u32, y: u32| {
        fs::write(place.path("shape.obj"), obj(x, y)).unwrap();
        place.succeed(&["info", "shape.obj"]).0
    };
    let (far, near) = (info(500_000, 4_649_776), info(0, 0));
    assert!(far.contains("(499999.5, 4649775.5, 0) to (500000.5, 4649776.5, 0)"), "{far}");
    assert!(far.contains("  origin       (500000, 4649776, 0)"), "{far}");
    assert!(near.contains("(-0.5, -0.5, 0) to (0.5, 0.5, 0)") && !near.contains("origin"), "{near}");
}
