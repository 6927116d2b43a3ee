//! What keys and the mouse do.

use eframe::egui;

use super::keys::Key;
use crate::app::App;

const MOUSE: [(&str, &str); 7] = [
    ("Drag", "Go round the scene"),
    ("Drag with the right or middle button, or Shift", "Move sideways"),
    ("Drag with Ctrl", "Look around"),
    ("Wheel", "Nearer or farther"),
    ("Click", "What is at a pixel"),
    ("Double click", "Turn around what is there"),
    ("Drag a light's handle", "Move the light, along an axis if one is grabbed"),
];

const FLIGHT: [(&str, &str); 2] = [("W A S D Q E", "Fly"), ("with Shift", "Faster")];

pub(super) fn show(app: &mut App, ui: &egui::Ui) {
    let window = egui::Window::new("Help").open(&mut app.is_help_open).collapsible(false).resizable(false);
    window.anchor(egui::Align2::CENTER_CENTER, egui::Vec2::ZERO).show(ui.ctx(), |ui| {
        let keys = Key::ALL.map(|key| (key.names(), key.meaning()));
        for (title, rows) in [("Keys", &keys[..]), ("Flying", &FLIGHT), ("In the picture", &MOUSE)] {
            ui.strong(title);
            egui::Grid::new(title).num_columns(2).spacing([24.0, 4.0]).show(ui, |ui| {
                for (key, meaning) in rows {
                    ui.monospace(*key);
                    ui.label(*meaning);
                    ui.end_row();
                }
            });
            ui.add_space(6.0);
        }
    });
}
