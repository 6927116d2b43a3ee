//! The picture, and the mouse's actions in it.

use eframe::egui::{self, Color32, PointerButton, Pos2, Rect, Response, Sense, pos2, vec2};
use glam::Vec2;

use super::{arrows, gizmo, overlay};
use crate::app::{App, CameraChoice, Shown};
use crate::choices::Resolution;
use crate::free_camera;
use crate::projection::Projected;

pub(super) fn show(app: &mut App, ui: &mut egui::Ui) {
    let area = ui.available_rect_before_wrap();
    let response = ui.allocate_rect(area, Sense::click_and_drag());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "Rendered scene"));
    app.screen = pixels(area, ui.pixels_per_point());
    let Some(shown) = &app.shown else {
        let text = egui::RichText::new(app.in_place_of_a_picture()).size(20.0).color(Color32::GRAY);
        ui.put(area, egui::Label::new(text).selectable(false));
        app.notices.show(ui, area);
        return;
    };
    let rect = picture_rect(shown, app.kept.choices.resolution, area, ui.pixels_per_point());
    let texture = shown.heat.as_ref().map_or(shown.texture, egui::TextureHandle::id);
    let whole = Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0));
    let painter = ui.painter_at(area);
    painter.image(texture, rect, whole, Color32::WHITE);
    let picture = Projected::new(&shown.picture.view, rect);
    overlay::light_grid(shown, &painter, &picture);
    let is_light_dragged = gizmo::show(app, ui, &response, &picture, &painter);
    arrows::show(app, ui, &response, &picture, &painter);
    overlay::show(app, ui, &response, rect);
    if !is_light_dragged {
        navigate(app, ui, &response, rect);
    }
    app.notices.show(ui, area);
}

/// Size of an area in pixels.
fn pixels(area: Rect, pixels_per_point: f32) -> [u32; 2] {
    [area.width(), area.height()].map(|side| (side * pixels_per_point).round().clamp(0.0, 1e5) as u32)
}

/// The picture's rectangle: pixel for pixel if it is as large as the window, else as large as fits. A coarse picture gets
/// the rectangle of the full one.
fn picture_rect(shown: &Shown, resolution: Resolution, area: Rect, pixels_per_point: f32) -> Rect {
    let size = shown.whole.map(|side| side as f32 / pixels_per_point);
    let size = vec2(size[0], size[1]);
    let fit = (area.width() / size.x).min(area.height() / size.y);
    let scale = match resolution {
        Resolution::Window => 1.0,
        Resolution::Fraction(_) => fit,
        // Small pictures aren't enlarged, so that each pixel can be inspected.
        Resolution::Fixed(_) => fit.min(1.0),
    };
    let corner = match resolution {
        // On the screen's own pixels.
        Resolution::Window => area.min,
        Resolution::Fraction(_) | Resolution::Fixed(_) => area.center() - size * (0.5 * scale),
    };
    Rect::from_min_size(corner, size * scale)
}

/// The picture's pixel under a screen position.
pub(super) fn pixel_at(shown: &Shown, rect: Rect, pointer: Pos2) -> Option<[u32; 2]> {
    let [width, height] = shown.picture.size();
    let x = ((pointer.x - rect.left()) / rect.width() * width as f32).floor();
    let y = ((pointer.y - rect.top()) / rect.height() * height as f32).floor();
    let is_inside = (0.0..width as f32).contains(&x) && (0.0..height as f32).contains(&y);
    is_inside.then_some([x as u32, y as u32])
}

fn navigate(app: &mut App, ui: &egui::Ui, response: &Response, rect: Rect) {
    const RADIANS_PER_HEIGHT: f32 = 3.0;
    let (modifiers, scroll) =
        ui.input(|input| (input.modifiers, input.smooth_scroll_delta().y * input.zoom_delta().recip()));
    let dragged = response.drag_delta() / rect.height().max(1.0);
    let turns = dragged * RADIANS_PER_HEIGHT;
    if dragged != egui::Vec2::ZERO {
        let is_primary = response.dragged_by(PointerButton::Primary);
        if let Some(camera) = app.free_camera() {
            if is_primary && modifiers.command {
                free_camera::look(camera, turns.x * 0.5, turns.y * 0.5);
            } else if is_primary && !modifiers.shift {
                free_camera::orbit(camera, -turns.x, turns.y);
            } else {
                free_camera::pan(camera, Vec2::new(dragged.x, dragged.y));
            }
        }
    }
    if response.hovered()
        && scroll != 0.0
        && let Some(camera) = app.free_camera()
    {
        free_camera::zoom(camera, (-0.004 * scroll).exp());
    }
    let Some(pointer) = response.interact_pointer_pos() else { return };
    let Some(pixel) = app.shown.as_ref().and_then(|shown| pixel_at(shown, rect, pointer)) else { return };
    if response.clicked_by(PointerButton::Primary) {
        app.worker.probe(pixel);
    }
    if response.double_clicked_by(PointerButton::Primary) {
        let surface = app.probe.as_ref().and_then(|probe| probe.surface.as_ref());
        if let Some(position) = surface.map(|surface| surface.found.position.as_vec3())
            && let Some(camera) = app.free_camera()
        {
            free_camera::turn_around(camera, position);
        }
    }
    // The scene's own cameras can't be moved.
    debug_assert!(dragged == egui::Vec2::ZERO || app.shown.is_none() || matches!(app.camera, CameraChoice::Free(_)));
}
