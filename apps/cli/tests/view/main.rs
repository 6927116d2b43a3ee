//! The real window, on an X server without a screen: only in builds with the window, on Linux.
#![cfg(all(feature = "view", target_os = "linux"))]

mod display;
mod scene;

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use display::{Display, Shot};

/// The window's process, killed when dropped.
struct Window(Child);

impl Drop for Window {
    fn drop(&mut self) {
        self.0.kill().ok();
        self.0.wait().ok();
    }
}

/// Polls `ask` until it returns an answer, and panics with `what` after a timeout.
fn wait_for<T>(what: &str, mut ask: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(answer) = ask() {
            return answer;
        }
        assert!(start.elapsed() < Duration::from_secs(180), "{what} didn't happen in time");
        std::thread::sleep(Duration::from_millis(100));
    }
}

/// Saves a picture for review, if `UMBRAGE_WINDOW_PICTURES` names a folder.
fn keep(shot: &Shot, name: &str) {
    if let Some(folder) = std::env::var_os("UMBRAGE_WINDOW_PICTURES") {
        shot.write(&Path::new(&folder).join(format!("window_{name}.png")));
    }
}

/// Waits for a picture that no longer changes.
fn still(display: &Display) -> Shot {
    let mut last = display.shot();
    wait_for("a still picture", || {
        std::thread::sleep(Duration::from_millis(700));
        let shot = display.shot();
        let is_still = shot == last;
        last = shot;
        is_still.then(|| last.clone())
    })
}

fn umbrage() -> &'static str {
    env!("CARGO_BIN_EXE_umbrage")
}

#[test]
fn a_window_plays_is_changed_and_closed() {
    let Some(display) = Display::start() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let scene = scene::write(folder.path());
    let child = Command::new(umbrage())
        .args(["view", "--forget", "--engine", "cpu"])
        .arg(&scene)
        .current_dir(folder.path())
        .env("DISPLAY", display.name())
        .env_remove("WAYLAND_DISPLAY")
        .stderr(Stdio::inherit())
        .spawn()
        .expect("a process");
    let mut window = Window(child);
    wait_for("a window", || display.find_window());
    wait_for("a title", || display.title().filter(|title| title.contains("moving.gltf") && title.contains("CPU")));

    // The animation plays at once; the space bar pauses it. Without panels the picture fills the window.
    display.press("v");
    std::thread::sleep(Duration::from_millis(500));
    let playing = display.shot();
    keep(&playing, "playing");
    wait_for("motion", || (display.shot() != playing).then_some(()));
    display.press("space");
    display.press("Home");
    let paused = still(&display);
    keep(&paused, "paused");
    assert!(paused.colors() > 50, "{} colours", paused.colors());

    // The file's light is in the middle of its camera's view.
    let [x, y] = paused.middle();
    display.drag([x, y], [x + 120, y - 60]);
    let dragged = still(&display);
    keep(&dragged, "dragged");
    assert!(dragged != paused, "a light was dragged");

    // The copied command renders the screenshot.
    display.press("p");
    let screenshot = folder.path().join("moving.png");
    wait_for("a screenshot", || screenshot.exists().then_some(()));
    display.press("c");
    let command = wait_for("a command", || display.clipboard().filter(|text| text.starts_with("umbrage render ")));
    let rendered = render(&command, folder.path());
    assert!(std::fs::read(&screenshot).expect("a file") == std::fs::read(rendered).expect("a file"), "{command}");

    display.press("m");
    let heat = still(&display);
    keep(&heat, "heat");
    assert!(heat != dragged, "a heat map");
    // On a busy machine a picture may come later than the next key, so each is checked several times.
    let is_plain = || (0..3).any(|_| still(&display).differs_little(&dragged));
    let press = || {
        display.press("m");
        false
    };
    assert!((0..8).any(|_| is_plain() || press()), "after the last heat map there is none");

    display.press("x");
    wait_for("another engine or a message", || display.title().filter(|title| !title.contains("CPU")));
    // On a software GPU the next samples may take longer than the wait for a still picture.
    let same = || Some(still(&display)).filter(|shot| shot.differs_little(&dragged));
    keep(&wait_for("the same picture by both engines", same), "gpu");

    display.resize([400, 100]);
    display.resize([1, 1]);
    display.resize([900, 600]);
    keep(&still(&display), "resized");
    display.close();
    let status = wait_for("an end", || window.0.try_wait().expect("a process"));
    assert!(status.success(), "{status}");
}

#[test]
fn without_a_display_there_is_a_message() {
    for (display, remedy) in [(":no-such-display", "may be gone"), ("", "set DISPLAY or WAYLAND_DISPLAY")] {
        let output = Command::new(umbrage())
            .args(["view", "--forget"])
            .env("DISPLAY", display)
            .env_remove("WAYLAND_DISPLAY")
            .output()
            .expect("a process");
        let message = String::from_utf8_lossy(&output.stderr);
        assert!(
            message.contains("error: no window could be opened") && message.contains("umbrage render"),
            "{message}"
        );
        assert!(message.contains(remedy), "{message}");
        assert_eq!(output.status.code(), Some(1));
    }
}

#[test]
fn without_an_adapter_that_can_draw_there_is_a_message() {
    let Some(display) = Display::start() else { return };
    let output = Command::new(umbrage())
        .args(["view", "--forget"])
        .env("DISPLAY", display.name())
        .env_remove("WAYLAND_DISPLAY")
        // The loader finds no driver, and OpenGL isn't tried.
        .envs(["VK_DRIVER_FILES", "VK_ICD_FILENAMES"].map(|name| (name, "/no-such-driver.json")))
        .env("WGPU_BACKEND", "vulkan")
        .output()
        .expect("a process");
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(message.contains("error: no window could be opened") && message.contains("umbrage render"), "{message}");
    assert_eq!(output.status.code(), Some(1));
}

/// Runs a copied command, and returns the path of its picture.
fn render(command: &str, folder: &Path) -> PathBuf {
    let rest = command.strip_prefix("umbrage ").expect("our command");
    let path = folder.join("again.png");
    let line = format!("'{}' {rest} --quiet -o '{}'", umbrage(), path.display());
    let status = Command::new("sh").args(["-c", &line]).current_dir(folder).status().expect("a shell");
    assert!(status.success(), "{line}");
    path
}
