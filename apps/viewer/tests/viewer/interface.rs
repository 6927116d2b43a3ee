//! The interface, driven through its own widgets, with assertions on their texts.

use std::collections::HashMap;
use std::time::{Duration, Instant};

use eframe::egui::{Context, Event, Key, Modifiers, MouseWheelSource, MouseWheelUnit, Rect, TouchPhase, vec2};
use egui_kittest::kittest::Queryable;
use glam::Vec3;
use umbrage::rays::LightSource;
use umbrage::scene::Light;
use umbrage_viewer::{App, EngineChoice, Start};

use crate::window::Window;

#[test]
fn pictures_that_stay_become_sharper() {
    let scene = "demo:statue?triangles=2000";
    let start = Start { scene: Some(scene.into()), size: Some([96, 64]), samples: Some(40), ..Start::default() };
    let Some(mut window) = Window::start(start) else { return };
    if window.shows("Pause") {
        window.press(Key::Space);
    }
    let samples = |window: &Window| window.harness.state().as_ref().map_or(0, App::samples);
    let wait_for = |window: &mut Window, expected: u32| {
        let start = Instant::now();
        while samples(window) != expected {
            assert!(start.elapsed() < Duration::from_secs(120), "{} samples in time", samples(window));
            window.harness.run_steps(2);
            std::thread::sleep(Duration::from_millis(5));
        }
    };
    wait_for(&mut window, 40);
    window.harness.run_steps(2);
    assert!(window.shows("Samples a pixel: 40") && !window.shows("pictures a second"));
    let sharp = window.harness.state().as_ref().map_or(0, App::pictures);
    window.harness.run_steps(8);
    assert_eq!(window.harness.state().as_ref().map_or(0, App::pictures), sharp, "it has all of its samples");
    // Pictures in motion are shown at once, and then become sharper again.
    let (from, to) = (window.in_picture(0.0, 0.0), window.in_picture(40.0, 10.0));
    window.drag(from, to);
    wait_for(&mut window, 40);
    let pictures = window.harness.state().as_ref().map_or(0, App::pictures) - sharp;
    assert!(pictures >= 4, "1, 4, 16 and 40 samples, after what was seen on the way: {pictures}");
}

#[test]
fn a_scene_is_opened_played_and_paused() {
    let Some(mut window) = Window::open("demo:cloth?triangles=2000") else { return };
    assert!(window.shows("Pause"), "an animation plays at once");
    let start = Instant::now();
    while !window.shows("pictures a second") {
        assert!(start.elapsed() < Duration::from_secs(60), "no pace in time");
        window.harness.run_steps(2);
        std::thread::sleep(Duration::from_millis(5));
    }
    window.keep("playing");
    let playing = window.pixels();
    window.press(Key::Space);
    assert!(window.shows("Play"));
    let paused = window.pixels();
    assert!(playing != paused);
    window.keep("paused");
    assert!(paused == window.pixels(), "a paused picture stays");
    window.press(Key::ArrowRight);
    assert!(paused != window.pixels(), "one frame on");
    window.press(Key::Home);
    window.harness.get_by_label("Loop").click();
    window.settle();
}

#[test]
fn the_work_is_shown() {
    let Some(mut window) = Window::open("demo:cloth?triangles=2000") else { return };
    window.press(Key::Space);
    window.press(Key::T);
    for text in ["see", "shadow", "shade", "camera rays", "rays a second", "bytes"] {
        assert!(window.shows(text), "{text}");
    }
    let plain = window.pixels();
    window.choose("Show", "Triangles tested");
    window.keep("heat");
    assert!(plain != window.pixels());
    window.choose("Show", "Undecided tests");
    window.choose("Show", "Light");
    assert!(plain == window.pixels(), "the picture is back");
}

#[test]
fn what_pixels_saw_is_shown() {
    let Some(mut window) = Window::open("demo:cloth?triangles=2000") else { return };
    window.press(Key::Space);
    window.press(Key::T);
    let mut pictures = vec![window.pixels()];
    for view in ["Normals", "UV", "Depth", "Wireframe"] {
        window.choose("Show", view);
        window.keep(view);
        let picture = window.pixels();
        assert!(!pictures.contains(&picture), "{view}");
        pictures.push(picture);
    }
    window.press(Key::N);
    assert!(window.pixels() == pictures[0], "the light is back after the last of them");
}

#[test]
fn pairs_are_shown_by_tile_and_points_by_cell() {
    let Some(mut window) = Window::open("demo:cloth?triangles=2000") else { return };
    window.press(Key::Space);
    window.press(Key::T);
    let plain = window.pixels();
    // On the cloth, away from the legend and the light's handle.
    let middle = window.in_picture(0.0, 60.0);
    let corner = window.tile(0, 0).min;
    let tile = (middle - corner) / 64.0;
    let tile = window.tile(tile.x as u32, tile.y as u32);

    window.choose("Show", "Pairs per tile");
    assert!(window.shows("Pairs per tile, at most "));
    let pairs = window.count_at("Pairs per tile", tile.center());
    assert!(pairs > 0);
    window.keep("pairs");
    assert_eq!(window.count_at("Pairs per tile", tile.min + vec2(3.0, 3.0)), pairs, "a tile's pixels have the same");
    window.harness.remove_cursor();
    window.harness.run_steps(4);
    let colors = window.pixels_in(tile);
    assert!(colors.iter().all(|color| *color == colors[0] && *color != [0, 0, 0, 255]), "{:?}", colors[0]);

    window.choose("Show", "Points per light cell");
    assert!(window.shows("Points per light cell of light 1, at most "));
    assert!(!window.shows("Pairs per tile, at most "));
    assert!(window.count_at("Points per light cell", middle) > 1);
    window.keep("points");
    window.harness.remove_cursor();
    window.harness.run_steps(4);
    let colors = window.pixels_in(tile);
    assert!(colors.iter().any(|color| *color != colors[0]), "cells are smaller than tiles");

    window.choose("Show", "Light");
    assert!(plain == window.pixels(), "the picture is back");
}

#[test]
fn the_chosen_lights_cells_are_shown() {
    let Some(mut window) = Window::open("demo:glass?triangles=2000") else { return };
    window.press(Key::Space);
    window.press(Key::T);
    window.choose("Show", "Points per light cell");
    let first = window.pixels();
    assert!(window.shows("Points per light cell of light 1"));
    window.click("Add point");
    assert!(window.shows("Points per light cell of light 3"), "the new light is selected");
    assert!(first != window.pixels());
    // Without lights there are no cells, and still a picture.
    for _ in 0..3 {
        let remove = window.harness.get_all_by_label("x").next().expect("a light");
        remove.click();
        window.settle();
    }
    assert!(window.shows("No light: the surroundings alone light the scene."));
    assert!(window.shows("Points per light cell, but there is no light, at most 0"));
    window.press(Key::G);
    assert!(!window.shows("Light 1: "), "no light, no grid");
}

#[test]
fn a_lights_grid_is_drawn_over_the_scene() {
    let Some(mut window) = Window::open("demo:cloth?triangles=2000") else { return };
    window.press(Key::Space);
    window.press(Key::T);
    let whole = window.harness.get_by_label("Rendered scene").rect();
    let around = Rect::from_center_size(window.in_picture(0.0, 60.0), vec2(60.0, 60.0));
    let (plain, surface) = (window.pixels_in(whole), window.pixels_in(around));
    window.click_in_panel("Light grid");
    assert!(window.shows("Light 1: "));
    let tinted = window.pixels_in(around);
    let darker = |(tinted, plain): (&[u8; 4], &[u8; 4])| tinted[1] < plain[1];
    let brighter = |(tinted, plain): (&[u8; 4], &[u8; 4])| tinted[1] > plain[1];
    let pairs = || tinted.iter().zip(&surface);
    let counts = [pairs().filter(|&pair| darker(pair)).count(), pairs().filter(|&pair| brighter(pair)).count()];
    assert!(counts.iter().all(|count| *count > tinted.len() / 20), "cells alternate: {counts:?} of {}", tinted.len());
    // The frame of the face, in its colour.
    let of_frame = |pixels: &[[u8; 4]]| pixels.iter().filter(|pixel| **pixel == [40, 150, 255, 255]).count();
    window.keep("light_grid");
    let with_grid = window.pixels_in(whole);
    assert!(of_frame(&with_grid) > 100 && of_frame(&plain) == 0, "{}", of_frame(&with_grid));
    window.press(Key::G);
    assert!(plain == window.pixels_in(whole), "the key takes it away");
    window.press(Key::G);
    assert!(with_grid == window.pixels_in(whole));
}

#[test]
fn the_camera_follows_mouse_and_keys() {
    let Some(mut window) = Window::open("demo:marbles?triangles=2000") else { return };
    window.press(Key::Space);
    let before = window.pixels();
    let (from, to) = (window.in_picture(-150.0, 120.0), window.in_picture(-60.0, 150.0));
    window.drag(from, to);
    let orbited = window.pixels();
    assert!(before != orbited && window.shows("Field of view"));
    window.harness.hover_at(from);
    window.harness.event(Event::MouseWheel {
        unit: MouseWheelUnit::Line,
        delta: vec2(0.0, 3.0),
        source: MouseWheelSource::Wheel,
        phase: TouchPhase::Move,
        modifiers: Modifiers::NONE,
    });
    window.settle();
    let zoomed = window.pixels();
    assert!(orbited != zoomed);
    window.harness.key_down(Key::W);
    window.harness.run_steps(5);
    window.harness.key_up(Key::W);
    window.settle();
    assert!(zoomed != window.pixels(), "W flies");
    window.press(Key::F);
    window.press(Key::L);
}

#[test]
fn the_subject_of_a_vast_scene_is_framed() {
    // A cup, which turns, in the middle of a stadium.
    let Some(mut window) = Window::open("demo:stadium?triangles=5000") else { return };
    window.press(Key::Space);
    window.press(Key::Home);
    window.press(Key::F);
    let cup = window.pixels();
    window.keep("subject");
    window.harness.key_press_modifiers(Modifiers::SHIFT, Key::F);
    window.settle();
    window.keep("whole");
    let stadium = window.pixels();
    let is_like = |one: &[u8], other: &[u8]| {
        let others = one.iter().zip(other).filter(|(one, other)| one.abs_diff(**other) > 20).count();
        others < one.len() / 50
    };
    assert!(!is_like(&cup, &stadium));
    window.click_in_panel("See subject");
    assert!(is_like(&cup, &window.pixels()));
    window.click_in_panel("See all");
    assert!(is_like(&stadium, &window.pixels()));
}

#[test]
fn lights_are_added_dragged_and_removed() {
    let Some(mut window) = Window::open("demo:glass?triangles=2000") else { return };
    window.press(Key::Space);
    let before = window.pixels();
    window.keep("before");
    window.click("Add point");
    assert!(window.shows("Light 3 (point)"));
    assert!(before != window.pixels());
    let handle = window.harness.get_by_label("Handle of Light 3").rect().center();
    let added = window.pixels();
    window.drag(handle, handle + vec2(60.0, 30.0));
    let dragged = window.harness.get_by_label("Handle of Light 3").rect().center();
    assert!(dragged.distance(handle + vec2(60.0, 30.0)) < 8.0, "{handle} went to {dragged}");
    assert!(added != window.pixels());
    window.click("Shadows of Light 3");
    window.keep("light");
    // A panel has a size instead of a cone, and stands in the command as one.
    window.click("Add rectangle");
    assert!(window.shows("Light 4 (rectangle)") && window.shows("Width") && window.shows("Height"));
    assert!(!window.shows("Cone") && !window.shows("Radius"));
    window.keep("panel");
    window.press(Key::C);
    assert!(window.shows("--light rect:"));
    window.click("Reset");
    window.keep("reset");
    assert!(!window.shows("Light 3 (point)"));
    assert!(before == window.pixels(), "the scene's own lights are back");
}

#[test]
fn arrows_lead_to_lights_out_of_view() {
    let above = |height: f32| Light { source: LightSource::Point { position: Vec3::Y * height }, ..lamp(0.0) };
    let (scene, lights) = (Some("demo:cloth?triangles=2000".into()), Some(vec![above(1000.0), above(1.0)]));
    let Some(mut window) = Window::start(Start { scene, lights, ..Start::default() }) else { return };
    window.press(Key::Space);
    window.keep("arrows");
    let picture = window.harness.get_by_label("Rendered scene").rect();
    let arrow = window.harness.get_by_label("Arrow to Light 1").rect().center();
    assert!((picture.top()..picture.top() + 40.0).contains(&arrow.y), "{arrow} in {picture}");
    assert!(window.harness.query_by_label("Arrow to Light 2").is_none(), "it is in view");
    assert!(!window.shows("Intensity"));
    window.click("Arrow to Light 1");
    assert!(window.shows("Intensity"), "the light is selected");
    window.press(Key::L);
    assert!(window.harness.query_by_label("Arrow to Light 2").is_none(), "it is below the selected light");
}

#[test]
fn a_pixel_says_what_it_shows() {
    let Some(mut window) = Window::open("demo:cloth?triangles=2000") else { return };
    window.press(Key::Space);
    assert!(window.shows("Click in the picture."));
    let middle = window.in_picture(0.0, 60.0);
    window.harness.drag_at(middle);
    window.harness.step();
    window.harness.drop_at(middle);
    window.harness.step();
    let start = Instant::now();
    while window.shows("Click in the picture.") && start.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(10));
        window.harness.run_steps(2);
    }
    assert!(window.shows("Triangle") && window.shows("Material") && window.shows("Normal"));
    window.keep("pixel");
}

#[test]
fn broken_files_are_messages() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("broken.glb");
    std::fs::write(&path, b"glTF, but not really").expect("a file");
    let Some(mut window) = Window::open(&path.to_string_lossy()) else { return };
    assert!(window.shows("broken.glb"));
    window.press(Key::H);
    assert!(window.shows("Play or pause"), "the help still opens");
}

#[test]
fn the_help_lists_every_key() {
    let Some(mut window) = Window::open("demo:cloth?triangles=500") else { return };
    window.press(Key::H);
    for text in [
        "Play or pause",
        "Save the picture as a PNG",
        "Look from the selected light",
        "Show the selected light's grid",
        "W A S D Q E",
        "H or F1",
    ] {
        assert!(window.shows(text), "{text}");
    }
    window.keep("help");
    window.press(Key::F1);
    assert!(!window.shows("W A S D Q E"));
}

fn lamp(place: f32) -> Light {
    let source = LightSource::Point { position: Vec3::new(place.cos(), 1.5, place.sin()) };
    Light::new(source, 0.3)
}

#[test]
fn no_light_and_sixty_four() {
    for count in [0, 64] {
        let lights = Some((0..count).map(|number| lamp(number as f32)).collect());
        let scene = Some("demo:cloth?triangles=500".into());
        let Some(mut window) = Window::start(Start { scene, lights, ..Start::default() }) else { return };
        window.press(Key::Space);
        assert_eq!(window.shows("No light"), count == 0);
        assert_eq!(window.shows("Light 64 (point)"), count == 64);
        window.press(Key::L);
    }
}

#[test]
fn a_window_without_size_waits_for_one() {
    let Some(mut window) = Window::open("demo:cloth?triangles=500") else { return };
    window.press(Key::Space);
    for side in [1.0, 0.0, 30.0] {
        window.harness.set_size(vec2(side, side));
        window.harness.run_steps(3);
    }
    window.harness.set_size(vec2(1000.0, 700.0));
    window.settle();
    let pixels = window.pixels();
    assert!(pixels.as_chunks::<4>().0.iter().any(|pixel| *pixel != pixels[..4]), "the picture is back");
}

#[test]
fn a_narrow_window_has_half_of_its_width_for_the_picture() {
    let Some(mut window) = Window::open("demo:cloth?triangles=2000") else { return };
    window.press(Key::Space);
    for size in [vec2(640.0, 480.0), vec2(480.0, 320.0)] {
        window.harness.set_size(size);
        for panel in ["Seen from", "camera rays"] {
            window.settle();
            let picture = window.harness.get_by_label("Rendered scene").rect();
            assert!(picture.width() >= 0.48 * size.x && picture.height() >= 0.5 * size.y, "{picture} of {size}");
            assert!(window.shows(panel), "{panel}");
            window.keep(&format!("narrow_{}_{}", size.x, panel.replace(' ', "_")));
            window.press(Key::T);
        }
        assert!(window.shows("Seen from"), "the controls are back");
    }
}

#[test]
fn the_strip_of_times_is_there_beside_the_controls() {
    let Some(mut window) = Window::open("demo:cloth?triangles=2000") else { return };
    window.press(Key::Space);
    window.harness.set_size(vec2(800.0, 600.0));
    window.settle();
    assert!(window.shows("Times of stages: animate") && window.shows("Seen from"));
    window.keep("eight_hundred");
    window.choose("Tone map", "Clip");
    window.click("View");
    window.click("Show the strip of stages' times beside the controls");
    assert!(!window.shows("Times of stages: animate"));
}

/// Settings of windows, in memory.
#[derive(Default)]
struct Storage(HashMap<String, String>);

impl eframe::Storage for Storage {
    fn get_string(&self, key: &str) -> Option<String> {
        self.0.get(key).cloned()
    }

    fn set_string(&mut self, key: &str, value: String) {
        self.0.insert(key.to_owned(), value);
    }

    fn remove_string(&mut self, key: &str) {
        self.0.remove(key);
    }

    fn flush(&mut self) {}
}

#[test]
fn a_window_that_forgets_keeps_nothing() {
    let kept = |forgets: bool, storage: &mut Storage| {
        let start = Start { scene: Some("demo:cloth?triangles=500".into()), forgets, ..Start::default() };
        let mut app = App::new(&Context::default(), start, Some(storage), None);
        eframe::App::save(&mut app, storage);
    };
    let mut storage = Storage::default();
    kept(true, &mut storage);
    assert!(storage.0.is_empty());
    kept(false, &mut storage);
    assert!(!storage.0.is_empty());
}

#[test]
fn an_engine_that_is_not_there_is_a_message() {
    let engine = Some(EngineChoice::Gpu("no such adapter".to_owned()));
    let scene = Some("demo:cloth?triangles=500".into());
    let Some(mut window) = Window::start(Start { scene, engine, ..Start::default() }) else { return };
    assert!(window.shows("no GPU adapter has \"no such adapter\" in its name"));
    window.press(Key::X);
    assert!(!window.shows("Drop a scene here") && window.shows("CPU with"), "the CPU renders");
}

#[test]
fn both_engines_show_the_same() {
    let Some(mut window) = Window::open("demo:shatter?triangles=500") else { return };
    window.press(Key::Space);
    let on_cpu = window.pixels();
    window.press(Key::X);
    assert!(!window.shows("CPU with"));
    let on_gpu = window.pixels();
    let others = on_cpu.iter().zip(&on_gpu).filter(|(one, other)| one.abs_diff(**other) > 2).count();
    assert!(others < on_cpu.len() / 1000, "{others} of {}", on_cpu.len());
}

#[test]
fn what_is_shown_can_be_copied_as_a_command() {
    let Some(mut window) = Window::open("demo:cloth?triangles=500") else { return };
    window.press(Key::Space);
    let (from, to) = (window.in_picture(-150.0, 120.0), window.in_picture(-60.0, 150.0));
    window.drag(from, to);
    window.click("Add sun");
    window.press(Key::C);
    for text in ["umbrage render 'demo:cloth?triangles=500'", "--camera", "--light sun:", "--size"] {
        assert!(window.shows(text), "{text}");
    }
}
