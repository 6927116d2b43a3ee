//! The bar at the top.

use std::path::{Path, PathBuf};
use std::time::Instant;

use eframe::egui::{self, MenuBar};
use umbrage::gallery::DEMOS;
use umbrage::scene::OpenOptions;

use super::keys::Key;
use crate::app::{App, CameraChoice};
use crate::command;
use crate::pace::Pace;
use crate::recording::Recording;

pub(super) fn show(app: &mut App, ui: &mut egui::Ui) {
    MenuBar::new().ui(ui, |ui| {
        ui.menu_button("File", |ui| file(app, ui));
        ui.menu_button("Gallery", |ui| gallery(app, ui));
        ui.menu_button("View", |ui| view(app, ui));
        ui.menu_button("Help", |ui| {
            if ui.button(Key::Help.label()).clicked() {
                app.is_help_open = true;
            }
        });
        ui.separator();
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            status(app, ui);
            ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| address(app, ui));
        });
    });
}

/// The address of the scene that is open or being opened.
fn address(app: &App, ui: &mut egui::Ui) {
    let label = |ui: &mut egui::Ui, text: String| ui.add(egui::Label::new(text).truncate());
    match (&app.opening, app.address()) {
        (Some(opening), _) => {
            ui.spinner();
            label(ui, format!("Opening {}", name(opening)));
        }
        (None, Some(address)) => {
            label(ui, name(address)).on_hover_text(address.display().to_string());
        }
        (None, None) => {
            label(ui, "Open a scene, or drop a file here".to_owned());
        }
    }
}

/// The rate of pictures in motion, or the samples of a picture that stays.
fn status(app: &App, ui: &mut egui::Ui) {
    if let Some(per_second) = app.pace.per_second(Instant::now()) {
        ui.ctx().request_repaint_after(Pace::WINDOW);
        let decimals = if per_second < 10.0 { 1 } else { 0 };
        ui.weak(format!("{per_second:.decimals$} pictures a second")).on_hover_text("The median of the last second");
    } else if app.shown.is_some() {
        let samples = app.samples();
        let of_all = match app.kept.choices.samples {
            all if all > samples => format!(" of {all}"),
            _ => String::new(),
        };
        ui.weak(format!("Samples a pixel: {samples}{of_all}"));
    }
}

fn file(app: &mut App, ui: &mut egui::Ui) {
    Key::Open.button(app, ui);
    ui.menu_button("Recent", |ui| {
        for path in app.kept.recent.clone() {
            if ui.button(name(&path)).on_hover_text(path.display().to_string()).clicked() {
                app.open(path, OpenOptions::for_pictures());
            }
        }
    });
    Key::Reload.button(app, ui);
    let mut watches = app.watch.is_some();
    if ui.checkbox(&mut watches, "Reload when the file changes").changed() {
        app.watch = watches.then(Default::default);
    }
    ui.separator();
    Key::Screenshot.button(app, ui);
    Key::Record.button(app, ui);
    let can_record = app.recording.is_none() && app.shown.is_some();
    if ui.add_enabled(can_record, egui::Button::new("Record the animation as numbered PNGs")).clicked() {
        record(app, "png", 1);
    }
    if ui.add_enabled(can_record, egui::Button::new("Record a GIF of half the size")).clicked() {
        record(app, "gif", 2);
    }
    ui.separator();
    let copy = ui.button(Key::CopyCommand.label()).on_hover_text("The `umbrage render` line that makes this picture");
    if copy.clicked() {
        Key::CopyCommand.press(app, ui);
    }
    if ui.button("Quit").clicked() {
        ui.ctx().send_viewport_cmd(egui::ViewportCommand::Close);
    }
}

fn gallery(app: &mut App, ui: &mut egui::Ui) {
    for demo in DEMOS {
        if ui.button(demo.name).on_hover_text(demo.about).clicked() {
            app.open(format!("demo:{}", demo.name).into(), OpenOptions::for_pictures());
        }
    }
}

fn view(app: &mut App, ui: &mut egui::Ui) {
    Key::FrameSubject.button(app, ui);
    Key::FrameAll.button(app, ui);
    Key::LookFromLight.button(app, ui);
    if ui.button("Back to the scene's camera").clicked() {
        app.camera = CameraChoice::Default;
    }
    ui.separator();
    ui.checkbox(&mut app.kept.shows_work, Key::Work.label());
    let mut shows_controls = !app.kept.hides_controls;
    if ui.checkbox(&mut shows_controls, Key::Controls.label()).changed() {
        app.kept.hides_controls = !shows_controls;
    }
    let mut shows_strip = !app.kept.hides_strip;
    let strip = egui::Checkbox::new(&mut shows_strip, "Show the strip of stages' times beside the controls");
    if ui.add_enabled(shows_controls, strip).changed() {
        app.kept.hides_strip = !shows_strip;
    }
}

/// Stops a recording early.
pub(super) fn stop_recording(app: &mut App) {
    app.recording = None;
    app.notices.say("The recording was stopped. An unfinished GIF is left out.");
}

/// Records the animation into the current folder, with a part of the picture's width and height.
pub(super) fn record(app: &mut App, extension: &str, divisor: u32) {
    let Some(shown) = &app.shown else { return };
    let size = shown.whole.map(|side| side.div_ceil(divisor));
    let number = if extension == "png" { "_%04d" } else { "" };
    let path = free_path(&format!("{}{{}}{number}", stem(app.address())), extension);
    app.recording = Some(Recording::new(path, app.timeline.duration(), size));
}

pub(super) fn copy_command(app: &mut App, ui: &egui::Ui) {
    match command::line(app) {
        Ok(line) => {
            app.notices.say(format!("Copied: {line}"));
            ui.ctx().copy_text(line);
        }
        Err(why) => app.notices.error(why),
    }
}

/// A free path for a picture in the current folder.
pub(super) fn screenshot_path(app: &App) -> PathBuf {
    free_path(&format!("{}{{}}", stem(app.address())), "png")
}

/// A free path by a pattern, in which `{}` stands for nothing or for a number.
fn free_path(name: &str, extension: &str) -> PathBuf {
    let path = |number: String| PathBuf::from(format!("{}.{extension}", name.replace("{}", &number)));
    let is_free = |path: &PathBuf| {
        let first = path.to_string_lossy().replace("%04d", "0000");
        !Path::new(&first).exists()
    };
    let numbered = (2..10_000).map(|number| path(format!("-{number}")));
    std::iter::once(path(String::new())).chain(numbered).find(is_free).unwrap_or_else(|| path(String::new()))
}

/// File stem of a picture of a scene.
fn stem(address: Option<&Path>) -> String {
    let name = address.map_or_else(String::new, name);
    let stem = name.trim_start_matches("demo:").split(['?', '.', '%']).next().unwrap_or_default();
    if stem.is_empty() { "umbrage".to_owned() } else { stem.to_owned() }
}

/// An address without its folders.
fn name(address: &Path) -> String {
    address.file_name().map_or_else(|| address.display().to_string(), |name| name.to_string_lossy().into_owned())
}
