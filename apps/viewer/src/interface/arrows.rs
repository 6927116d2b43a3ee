//! Arrows at the edge of the picture that point to lights out of view.

use eframe::egui::{self, Align2, FontId, Painter, Pos2, Rect, Response, Sense, Shape, Stroke, Vec2, vec2};
use glam::Vec3;

use super::gizmo::{position, tint};
use crate::app::App;
use crate::probe::light_name;
use crate::projection::Projected;

/// Length of an arrow, and distance of its tip from the edge, in points.
const LENGTH: f32 = 16.0;
const MARGIN: f32 = 6.0;

/// Draws the arrows. A click selects the light.
pub(super) fn show(app: &mut App, ui: &egui::Ui, response: &Response, picture: &Projected, painter: &Painter) {
    let focus = app.focus();
    let mut clicked = None;
    for (number, light) in app.lights.lights().iter().enumerate() {
        let Some(arrow) = Arrow::to(position(&light.source, focus), picture, response.rect) else { continue };
        let name = light_name(number, light);
        let area = Rect::from_center_size(arrow.tip - 0.5 * LENGTH * arrow.way, Vec2::splat(1.5 * LENGTH));
        let hovered = ui.interact(area, ui.scope_id().with(("arrow", number)), Sense::click()).on_hover_text(&name);
        hovered.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, format!("Arrow to {name}")));
        if hovered.clicked() {
            clicked = Some(number);
        }
        let is_marked = hovered.hovered() || app.lights.selected == Some(number);
        let outline =
            if is_marked { Stroke::new(2.0, egui::Color32::WHITE) } else { Stroke::new(1.0, egui::Color32::BLACK) };
        painter.add(Shape::convex_polygon(arrow.corners(), tint(light.color), outline));
        let label = arrow.tip - (LENGTH + 8.0) * arrow.way;
        painter.text(label, Align2::CENTER_CENTER, number + 1, FontId::proportional(11.0), egui::Color32::WHITE);
    }
    app.lights.selected = clicked.or(app.lights.selected);
}

/// An arrow's tip and unit direction.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Arrow {
    tip: Pos2,
    way: Vec2,
}

impl Arrow {
    /// The arrow to a world point outside of `area` on the screen; `None` where the point is inside, or the area is
    /// too small.
    fn to(point: Vec3, picture: &Projected, area: Rect) -> Option<Self> {
        let is_in_view = picture.on_screen(point).is_some_and(|position| area.contains(position));
        let edge = area.shrink(MARGIN);
        if is_in_view || !edge.is_positive() {
            return None;
        }
        let offset = point - picture.camera.position;
        let way = vec2(offset.dot(picture.camera.right), -offset.dot(picture.camera.up)).normalized();
        // A point straight behind the camera is reached by a turn to either side.
        let way = if way.is_finite() && way != Vec2::ZERO { way } else { Vec2::DOWN };
        let from = edge.clamp(picture.rect.center());
        let reach = |from: f32, least: f32, most: f32, way: f32| match way {
            0.0 => f32::INFINITY,
            _ => ((if way > 0.0 { most } else { least }) - from) / way,
        };
        let across = reach(from.x, edge.left(), edge.right(), way.x);
        let along = reach(from.y, edge.top(), edge.bottom(), way.y);
        Some(Self { tip: from + across.min(along) * way, way })
    }

    fn corners(self) -> Vec<Pos2> {
        let (base, side) = (self.tip - LENGTH * self.way, 0.5 * LENGTH * self.way.rot90());
        vec![self.tip, base + side, base - side]
    }
}

#[cfg(test)]
mod tests {
    use eframe::egui::pos2;
    use umbrage::rays::Camera;

    use super::*;

    #[test]
    fn arrows_point_to_what_is_out_of_view() {
        let camera = Camera::look_at(Vec3::new(0.0, 0.0, 5.0), Vec3::ZERO, Vec3::Y, 0.8);
        let area = Rect::from_min_size(Pos2::ZERO, vec2(300.0, 200.0));
        let picture = Projected { camera, rect: area };
        let to = |x: f32, y: f32, z: f32| Arrow::to(Vec3::new(x, y, z), &picture, area);
        assert_eq!(to(0.0, 0.0, 0.0), None);
        // Points in front of the camera and behind it, on the same side.
        for z in [0.0, 20.0] {
            assert_eq!(to(100.0, 0.0, z), Some(Arrow { tip: pos2(294.0, 100.0), way: Vec2::RIGHT }));
            assert_eq!(to(0.0, 100.0, z), Some(Arrow { tip: pos2(150.0, 6.0), way: Vec2::UP }));
        }
        let corner = to(-100.0, -100.0, 20.0).expect("an arrow");
        assert!(corner.tip.distance(pos2(56.0, 194.0)) < 1e-3 && corner.way.x == -corner.way.y, "{corner:?}");
        assert_eq!(to(0.0, 0.0, 20.0).map(|arrow| arrow.way), Some(Vec2::DOWN));
        assert_eq!(Arrow::to(Vec3::X * 100.0, &picture, Rect::from_min_size(Pos2::ZERO, vec2(9.0, 9.0))), None);
    }
}
