//! The timeline.

use std::time::Instant;

use eframe::egui::{self, ComboBox, DragValue, Slider};
use umbrage::scene::{Clip, OpenOptions};

use super::keys::Key;
use super::menu;
use crate::app::App;

pub(super) fn show(app: &mut App, ui: &mut egui::Ui) {
    ui.horizontal_wrapped(|ui| {
        if let Some(recording) = &app.recording {
            let done = recording.frame as f32 / recording.frames as f32;
            let left = recording.seconds_left(Instant::now());
            let left = left.map_or(String::new(), |seconds| format!(", {} left", rounded(seconds)));
            let text = format!("Recording {} of {}{left}", recording.frame, recording.frames);
            ui.add(egui::ProgressBar::new(done).text(text).desired_width(320.0));
            if ui.button("Stop").clicked() {
                menu::stop_recording(app);
            }
            return;
        }
        let moves = app.timeline.moves();
        ui.add_enabled_ui(moves, |ui| {
            let play = if app.timeline.is_playing { "Pause" } else { "Play" };
            for (label, key) in [("|<", Key::Start), ("<", Key::StepBack), (play, Key::Play), (">", Key::StepOn)] {
                let button = ui.button(label).on_hover_text(key.label());
                button.widget_info(|| {
                    egui::WidgetInfo::labeled(
                        egui::Role::Button,
                        moves,
                        if label == play { play } else { key.words().0 },
                    )
                });
                if button.clicked() {
                    key.press(app, ui);
                }
            }
            let duration = app.timeline.duration();
            let has_clips = app.open.as_ref().is_some_and(|open| !open.scene.animations().is_empty());
            let width = (ui.available_width() - if has_clips { 590.0 } else { 400.0 }).max(60.0);
            ui.spacing_mut().slider_width = width;
            let scrubber = Slider::new(&mut app.timeline.seconds, 0.0..=duration.max(f64::MIN_POSITIVE))
                .suffix(" s")
                .fixed_decimals(2);
            let time = ui.label("Time").id;
            if ui.add(scrubber).labelled_by(time).dragged() {
                app.timeline.is_playing = false;
            }
            let speed = ui.label("Speed").id;
            let field = DragValue::new(&mut app.timeline.speed).speed(0.01).range(-10.0..=10.0).suffix("×");
            ui.add(field).labelled_by(speed);
            ui.checkbox(&mut app.timeline.loops, "Loop");
        });
        clips(app, ui);
        if !moves && app.open.is_some() {
            ui.weak("Nothing moves in this scene.");
        }
    });
}

/// An estimated time, as text.
fn rounded(seconds: f64) -> String {
    if seconds < 90.0 { format!("{seconds:.0} s") } else { format!("{:.0} min", seconds / 60.0) }
}

/// The choice of animations, where a file has several.
fn clips(app: &mut App, ui: &mut egui::Ui) {
    let Some(open) = &app.open else { return };
    let animations = open.scene.animations();
    if animations.is_empty() {
        return;
    }
    let before = app.clip();
    let mut clip = before.clone();
    let name = |number: usize, name: &str| if name.is_empty() { number.to_string() } else { name.to_owned() };
    let chosen = match &clip {
        Clip::Auto => "Default".to_owned(),
        Clip::All => "All".to_owned(),
        Clip::Rest => "None".to_owned(),
        Clip::Named(name) => name.clone(),
    };
    ComboBox::from_label("Animation").selected_text(chosen).show_ui(ui, |ui| {
        ui.selectable_value(&mut clip, Clip::Auto, "Default");
        ui.selectable_value(&mut clip, Clip::All, "All");
        ui.selectable_value(&mut clip, Clip::Rest, "None");
        for (number, animation) in animations.iter().enumerate() {
            let name = name(number, &animation.name);
            ui.selectable_value(&mut clip, Clip::Named(name.clone()), name);
        }
    });
    if clip != before {
        let options = OpenOptions { clip, ..open.options.clone() };
        app.reopen(Some(options));
    }
}
