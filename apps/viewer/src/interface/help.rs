//! Help for keys and the mouse.

use eframe::egui;

use super::keys::Key;
use crate::app::App;

const MOUSE: [(&str, &str); 8] = [
    ("Drag", "Go round the scene"),
    ("Drag with Shift, or another button", "Move sideways"),
    ("Drag with Ctrl", "Look around"),
    ("Wheel", "Nearer or farther"),
    ("Click", "What is at a pixel"),
    ("Double click", "Turn around what is there"),
    ("Drag a light's handle", "Move the light, along an axis if one is grabbed"),
    ("Click an arrow at the edge", "Select the light that is out of view there"),
];

const FLIGHT: [(&str, &str); 2] = [("W A S D Q E", "Fly"), ("with Shift", "Faster")];

pub(super) fn show(app: &mut App, ui: &egui::Ui) {
    let window = egui::Window::new("Help").open(&mut app.is_help_open).collapsible(false).resizable(false);
    window.anchor(egui::Align2::CENTER_CENTER, egui::Vec2::ZERO).show(ui.ctx(), |ui| {
        let keys: Vec<_> = Key::ALL.iter().map(|(_, _, name, meaning)| (*name, *meaning)).collect();
        egui::ScrollArea::vertical().show(ui, |ui| {
            ui.horizontal_top(|ui| {
                ui.vertical(|ui| table(ui, "Keys", &keys));
                ui.add_space(16.0);
                ui.vertical(|ui| {
                    table(ui, "In the picture", &MOUSE);
                    table(ui, "Flying", &FLIGHT);
                });
            });
        });
    });
}

fn table(ui: &mut egui::Ui, title: &str, rows: &[(&str, &str)]) {
    ui.strong(title);
    egui::Grid::new(title).num_columns(2).spacing([16.0, 4.0]).show(ui, |ui| {
        for (key, meaning) in rows {
            ui.label(egui::RichText::new(*key).strong());
            ui.label(*meaning);
            ui.end_row();
        }
    });
    ui.add_space(6.0);
}
