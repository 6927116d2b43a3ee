//! The panel about the clicked pixel.

use eframe::egui;
use glam::DVec3;

use super::engine_panel::UNITS;
use crate::app::App;
use crate::probe::{Probe, Surface};

pub(super) fn show(app: &mut App, ui: &mut egui::Ui) {
    let origin = app.open.as_ref().map_or(DVec3::ZERO, |open| open.scene.origin().into());
    match &app.probe {
        None => {
            ui.weak("Click in the picture.");
        }
        Some(Probe { pixel: [x, y], surface: None }) => {
            ui.label(format!("Pixel {x}, {y}: the background"));
        }
        Some(Probe { pixel: [x, y], surface: Some(surface) }) => {
            ui.label(format!("Pixel {x}, {y}"));
            egui::Grid::new("pixel").num_columns(2).show(ui, |ui| rows(ui, surface, origin));
        }
    }
}

/// The properties of a surface, in the world; the scene's coordinates count from `origin`.
fn rows(ui: &mut egui::Ui, surface: &Surface, origin: DVec3) {
    let mut row = |name: &str, value: String| {
        ui.weak(name);
        ui.add(egui::Label::new(value).wrap());
        ui.end_row();
    };
    let Surface { found, material, lights } = surface;
    let side = if found.is_front { "front" } else { "back" };
    row("Triangle", format!("{} ({side})", found.triangle));
    row("Material", material.clone());
    row("Distance", format!("{:.6}{UNITS}", found.distance));
    let [x, y, z] = (found.position + origin).to_array();
    row("Position", format!("{x:.5}, {y:.5}, {z:.5}{UNITS}"));
    let [x, y, z] = found.normal.to_array();
    row("Normal", format!("{x:.4}, {y:.4}, {z:.4}"));
    for (name, lighting) in lights {
        row(name, lighting.clone());
    }
}
