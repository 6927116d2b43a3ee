//! The panel of the camera.

use eframe::egui::{self, DragValue};
use glam::Vec3;

use super::keys::Key;
use crate::app::{App, CameraChoice};

pub(super) fn show(app: &mut App, ui: &mut egui::Ui) {
    let names: Vec<String> =
        app.cameras().iter().enumerate().map(|(number, camera)| camera_name(number, &camera.name)).collect();
    let default = if names.is_empty() { "Sees everything" } else { "The scene's first" };
    let chosen = match &app.camera {
        CameraChoice::Default => default.to_owned(),
        CameraChoice::OfScene(number) => names.get(*number).cloned().unwrap_or_else(|| default.to_owned()),
        CameraChoice::Free(_) => "Free".to_owned(),
    };
    egui::ComboBox::from_label("Seen from").selected_text(chosen).show_ui(ui, |ui| {
        ui.selectable_value(&mut app.camera, CameraChoice::Default, default);
        for (number, name) in names.iter().enumerate() {
            ui.selectable_value(&mut app.camera, CameraChoice::OfScene(number), name);
        }
        if ui.selectable_label(matches!(app.camera, CameraChoice::Free(_)), "Free").clicked() {
            app.free_camera();
        }
    });
    let size = app.focus().size;
    if let CameraChoice::Free(camera) = &mut app.camera {
        let mut moved = *camera;
        vector(ui, "Position, units", &mut moved.position, size);
        vector(ui, "Looks at, units", &mut moved.target, size);
        if moved.position != moved.target {
            *camera = moved;
        }
        ui.add(egui::Slider::new(&mut camera.fov_degrees, 1.0..=170.0).suffix("°").text("Field of view"));
    }
    ui.horizontal_wrapped(|ui| {
        for (text, key) in
            [("See subject", Key::FrameSubject), ("See all", Key::FrameAll), ("From light", Key::LookFromLight)]
        {
            if ui.button(text).on_hover_text(key.label()).clicked() {
                key.press(app, ui);
            }
        }
    });
}

/// Three draggable fields, with a speed by the scene's size.
pub(super) fn vector(ui: &mut egui::Ui, label: &str, vector: &mut Vec3, size: f32) {
    ui.horizontal_wrapped(|ui| {
        let label = ui.label(label).id;
        for axis in [&mut vector.x, &mut vector.y, &mut vector.z] {
            ui.add(DragValue::new(axis).speed(0.002 * size).max_decimals(3)).labelled_by(label);
        }
    });
}

fn camera_name(number: usize, name: &str) -> String {
    if name.is_empty() { format!("Camera {}", number + 1) } else { name.to_owned() }
}
