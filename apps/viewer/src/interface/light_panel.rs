//! The list of lights.

use std::f32::consts::FRAC_PI_2;

use eframe::egui::{self, DragValue, Slider};
use glam::Vec3;
use umbrage::rays::LightSource;
use umbrage::scene::{Light, LightShape};
use umbrage::spec::LightSpec;

use super::camera_panel::vector;
use super::engine_panel::UNITS;
use crate::app::App;
use crate::light_list::{LightList, kind, unit};
use crate::probe::light_name;

pub(super) fn show(app: &mut App, ui: &mut egui::Ui) {
    let focus = app.focus();
    let list = &mut app.lights;
    let mut removed = None;
    egui::ScrollArea::vertical().id_salt("light list").max_height(180.0).auto_shrink([false, true]).show(ui, |ui| {
        for (number, light) in list.lights().to_vec().iter().enumerate() {
            ui.horizontal(|ui| {
                let is_selected = list.selected == Some(number);
                let name = format!("{} ({})", light_name(number, light), kind(light));
                if ui.selectable_label(is_selected, name).clicked() {
                    list.selected = (!is_selected).then_some(number);
                }
                let mut casts_shadow = light.casts_shadow;
                let label = format!("Shadows of {}", light_name(number, light));
                let shadow = ui.checkbox(&mut casts_shadow, "shadow").on_hover_text(&label);
                shadow.widget_info(|| egui::WidgetInfo::selected(egui::Role::CheckBox, true, casts_shadow, &label));
                if casts_shadow != light.casts_shadow
                    && let Some(changed) = list.change(number)
                {
                    changed.casts_shadow = casts_shadow;
                }
                if ui.small_button("x").on_hover_text("Remove").clicked() {
                    removed = Some(number);
                }
            });
        }
    });
    if list.lights().is_empty() {
        ui.weak("No light: the surroundings alone light the scene.");
    }
    if let Some(removed) = removed {
        list.remove(removed);
    }
    ui.horizontal_wrapped(|ui| {
        let has_room = list.lights().len() < LightList::MOST;
        for light in list.to_add(focus) {
            if ui.add_enabled(has_room, egui::Button::new(format!("Add {}", kind(&light)))).clicked() {
                list.add(light);
            }
        }
        if ui.add_enabled(list.is_changed, egui::Button::new("Reset")).on_hover_text("The scene's own lights").clicked()
        {
            list.reset();
        }
    });
    let Some(selected) = list.selected else {
        ui.weak("Select a light to change it, and drag it in the picture.");
        return;
    };
    let Some(light) = list.lights().get(selected) else { return };
    let mut changed = light.clone();
    edit(ui, &mut changed, focus.size);
    if changed != *light
        && let Some(light) = list.change(selected)
    {
        *light = changed;
    }
}

/// The fields of one light.
fn edit(ui: &mut egui::Ui, light: &mut Light, size: f32) {
    ui.separator();
    ui.horizontal(|ui| {
        let mut color = light.color.to_array();
        if ui.color_edit_button_rgb(&mut color).changed() {
            light.color = Vec3::from_array(color).max(Vec3::ZERO);
        }
        ui.label("Colour");
    });
    let unit_name = if matches!(light.source, LightSource::Directional { .. }) { " lx" } else { " cd" };
    let speed = 0.01 * light.intensity.max(0.1);
    ui.horizontal(|ui| {
        let label = ui.label("Intensity").id;
        let field = DragValue::new(&mut light.intensity).range(0.0..=1e12).speed(speed).suffix(unit_name);
        ui.add(field).labelled_by(label);
    });
    let is_sun = matches!(light.source, LightSource::Directional { .. });
    let (most, suffix) = if is_sun { (Light::MAX_SUN_RADIUS_DEGREES, "°") } else { (1e12, UNITS) };
    let mut length = |name: &str, length: &mut f32| {
        ui.horizontal(|ui| {
            let label = ui.label(name).on_hover_text("Soft edges of its shadows, where a pixel has several samples").id;
            let speed = if is_sun { 0.01 } else { 0.001 * size };
            ui.add(DragValue::new(length).range(0.0..=most).speed(speed).suffix(suffix)).labelled_by(label);
        });
    };
    match &mut light.shape {
        LightShape::Ball(radius) | LightShape::Disk(radius) => length("Radius", radius),
        LightShape::Rectangle { width, height } => {
            length("Width", width);
            length("Height", height);
        }
    }
    match &mut light.source {
        LightSource::Point { position } => vector(ui, "Position, units", position, size),
        LightSource::Directional { direction } => way(ui, direction),
        LightSource::Spot { position, direction, inner_radians, outer_radians } => {
            vector(ui, "Position, units", position, size);
            way(ui, direction);
            let mut degrees = 2.0 * outer_radians.to_degrees();
            if !light.shape.is_flat()
                && ui.add(Slider::new(&mut degrees, 0.1..=180.0).suffix("°").text("Cone")).changed()
            {
                *outer_radians = (0.5 * degrees).to_radians().min(FRAC_PI_2);
                *inner_radians = LightSpec::INNER * *outer_radians;
            }
        }
    }
}

/// A direction's fields.
fn way(ui: &mut egui::Ui, direction: &mut Vec3) {
    let mut changed = *direction;
    vector(ui, "Direction", &mut changed, 2.0);
    if changed != *direction
        && let Some(changed) = unit(changed)
    {
        *direction = changed;
    }
}
