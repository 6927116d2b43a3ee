//! The interface, driven through its own widgets, asserting on what they show.

use std::time::{Duration, Instant};

use eframe::egui::{Event, Key, Modifiers, MouseWheelSource, MouseWheelUnit, Pos2, TouchPhase, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use umbrage_viewer::{App, Start};

/// A window, without a screen.
struct Window {
    harness: Harness<'static, Option<App>>,
}

impl Window {
    /// With a scene, once its first picture is there.
    fn open(scene: &str) -> Self {
        let start = Start { scene: Some(scene.into()), forgets: true, ..Start::default() };
        let harness = Harness::builder().with_size(vec2(1000.0, 700.0)).wgpu().build_ui_state(
            move |ui, state: &mut Option<App>| {
                state.get_or_insert_with(|| App::new(ui.ctx(), start.clone(), None, None)).show(ui);
            },
            None,
        );
        let mut window = Self { harness };
        window.settle();
        window
    }

    /// Until what is chosen is on the screen.
    fn settle(&mut self) {
        let start = Instant::now();
        loop {
            self.harness.run_steps(2);
            if self.harness.state().as_ref().is_some_and(App::is_idle) {
                break;
            }
            assert!(start.elapsed() < Duration::from_secs(120), "nothing was shown in time");
            std::thread::sleep(Duration::from_millis(5));
        }
        self.harness.run_steps(3);
    }

    fn click(&mut self, label: &str) {
        self.harness.get_by_label(label).click();
        self.settle();
    }

    fn press(&mut self, key: Key) {
        self.harness.key_press(key);
        self.settle();
    }

    fn shows(&self, text: &str) -> bool {
        self.harness.query_all_by_label_contains(text).next().is_some()
    }

    /// The pixels of the whole window.
    fn pixels(&mut self) -> Vec<u8> {
        self.harness.render().expect("a rendered window").into_raw()
    }

    /// The middle of the picture, and some points from there.
    fn in_picture(&self, right: f32, down: f32) -> Pos2 {
        self.harness.get_by_label("Picture").rect().center() + vec2(right, down)
    }

    fn drag(&mut self, from: Pos2, to: Pos2) {
        self.harness.hover_at(from);
        self.harness.step();
        self.harness.drag_at(from);
        self.harness.step();
        for step in 1..=4 {
            self.harness.hover_at(from + (to - from) * (step as f32 / 4.0));
            self.harness.step();
        }
        self.harness.drop_at(to);
        self.settle();
    }
}

#[test]
fn a_scene_is_opened_played_and_paused() {
    let mut window = Window::open("demo:cloth?triangles=2000");
    assert!(window.shows("Pause"), "an animation plays at once");
    let playing = window.pixels();
    window.press(Key::Space);
    assert!(window.shows("Play"));
    let paused = window.pixels();
    assert!(playing != paused);
    assert!(paused == window.pixels(), "a paused picture stays");
    window.press(Key::ArrowRight);
    assert!(paused != window.pixels(), "one frame on");
    window.press(Key::Home);
    window.harness.get_by_label("Loop").click();
    window.settle();
}

#[test]
fn the_work_is_shown() {
    let mut window = Window::open("demo:cloth?triangles=2000");
    window.press(Key::Space);
    window.press(Key::T);
    for text in ["see", "shadow", "shade", "camera rays", "rays a second", "bytes"] {
        assert!(window.shows(text), "{text}");
    }
    let plain = window.pixels();
    window.click("Triangles tested");
    assert!(plain != window.pixels());
    window.click("Undecided tests");
    window.click("None");
    assert!(plain == window.pixels(), "the picture is back");
}

#[test]
fn the_camera_follows_mouse_and_keys() {
    let mut window = Window::open("demo:marbles?triangles=2000");
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
fn lights_are_added_dragged_and_removed() {
    let mut window = Window::open("demo:glass?triangles=2000");
    window.press(Key::Space);
    let before = window.pixels();
    window.click("Add point");
    assert!(window.shows("Light 3 (point)"));
    assert!(before != window.pixels());
    window.click("Shadows of Light 3");
    window.click("Reset");
    assert!(!window.shows("Light 3 (point)"));
    assert!(before == window.pixels(), "the scene's own lights are back");
}

#[test]
fn a_pixel_says_what_it_shows() {
    let mut window = Window::open("demo:cloth?triangles=2000");
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
}

#[test]
fn broken_files_are_messages() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("broken.glb");
    std::fs::write(&path, b"glTF, but not really").expect("a file");
    let mut window = Window::open(&path.to_string_lossy());
    assert!(window.shows("broken.glb"));
    window.press(Key::H);
    assert!(window.shows("Play or pause"), "the help still opens");
}

#[test]
fn the_help_lists_every_key() {
    let mut window = Window::open("demo:cloth?triangles=500");
    window.press(Key::H);
    for text in ["Play or pause", "Save the picture as a PNG", "Look from the selected light", "W A S D Q E", "H or F1"]
    {
        assert!(window.shows(text), "{text}");
    }
    window.press(Key::F1);
    assert!(!window.shows("W A S D Q E"));
}
