//! Overlays of the picture: a heat map's legend, the value under the cursor, and a light's grid.

use eframe::egui::{self, Align2, Color32, FontId, Painter, Pos2, Rect, Response, Stroke, pos2, vec2};
use glam::Vec3;
use umbrage::rays::Projection;

use super::stage::pixel_at;
use crate::app::{App, Shown};
use crate::heat::{HeatMap, title};
use crate::light_grid::LightGridPicture;
use crate::projection::Projected;

pub(super) fn show(app: &App, ui: &egui::Ui, response: &Response, rect: Rect) {
    let Some(shown @ Shown { picture, .. }) = &app.shown else { return };
    let Some(map) = &picture.heat else { return };
    legend(ui, map, rect);
    let Some(pixel) = response.hover_pos().and_then(|pointer| pixel_at(shown, rect, pointer)) else { return };
    let count = map.counts[pixel[1] as usize * picture.size()[0] + pixel[0] as usize];
    response.clone().on_hover_text_at_pointer(format!("{}: {count}", title(map.heat)));
}

fn legend(ui: &egui::Ui, map: &HeatMap, rect: Rect) {
    const STEPS: u32 = 128;
    let width = (rect.width() - 40.0).clamp(60.0, 320.0);
    let area = Rect::from_min_size(rect.min + vec2(12.0, 12.0), vec2(width + 16.0, 58.0));
    let painter = ui.painter_at(rect);
    painter.rect_filled(area, 4.0, Color32::from_black_alpha(170));
    let bar = Rect::from_min_size(area.min + vec2(8.0, 22.0), vec2(width, 12.0));
    let font = FontId::proportional(12.0);
    painter.text(area.min + vec2(8.0, 4.0), Align2::LEFT_TOP, map.title(), font.clone(), Color32::WHITE);
    let top = map.scale.top();
    for step in 0..STEPS {
        let [red, green, blue] = map.scale.color((u64::from(step) * u64::from(top) / u64::from(STEPS - 1)) as u32);
        let left = bar.left() + bar.width() * step as f32 / STEPS as f32;
        let part = Rect::from_min_size(pos2(left, bar.top()), vec2(bar.width() / STEPS as f32 + 0.5, bar.height()));
        painter.rect_filled(part, 0.0, Color32::from_rgb(red, green, blue));
    }
    for count in map.scale.ticks(bar.width() as u32, 40) {
        let x = bar.left() + bar.width() * count as f32 / top as f32;
        painter.vline(x, bar.bottom()..=bar.bottom() + 3.0, Stroke::new(1.0, Color32::WHITE));
        painter.text(pos2(x, bar.bottom() + 4.0), Align2::CENTER_TOP, count, font.clone(), Color32::WHITE);
    }
}

/// Draws the cells of the picture's light grid over it, and the faces' frames from the light into the view.
pub(super) fn light_grid(shown: &Shown, painter: &Painter, picture: &Projected) {
    let (Some(grid), Some(texture)) = (&shown.picture.light_grid, &shown.light_grid) else { return };
    painter.image(texture.id(), picture.rect, Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0)), Color32::WHITE);
    for (face, frame) in grid.faces.iter().enumerate() {
        let color = LightGridPicture::color(face);
        let (thick, thin) = (Stroke::new(2.0, color), Stroke::new(1.0, color));
        let line = |from: Vec3, to: Vec3, stroke: Stroke| {
            if let Some(ends) = visible(picture, from, to) {
                painter.line_segment(ends, stroke);
            }
        };
        for corner in 0..4 {
            let next = (corner + 1) % 4;
            line(frame.near[corner], frame.near[next], thick);
            line(frame.far[corner], frame.far[next], thick);
            line(grid.origin.unwrap_or(frame.near[corner]), frame.far[corner], thin);
        }
    }
}

/// Projects the part of a line that is in front of the camera.
fn visible(picture: &Projected, from: Vec3, to: Vec3) -> Option<[Pos2; 2]> {
    /// Minimum depth of a line's end, relative to its length.
    const NEAREST: f32 = 1e-4;
    let camera = picture.camera;
    let depth = |point: Vec3| (point - camera.position).dot(camera.forward);
    let nearest = match camera.projection {
        Projection::Perspective { .. } => NEAREST * from.distance(to),
        Projection::Orthographic { .. } => f32::NEG_INFINITY,
    };
    let end = |end: Vec3, other: Vec3| {
        let (here, there) = (depth(end), depth(other));
        let cut = if here < nearest { end.lerp(other, (nearest - here) / (there - here)) } else { end };
        picture.on_screen(cut)
    };
    let is_seen = depth(from).max(depth(to)) > nearest;
    is_seen.then(|| Some([end(from, to)?, end(to, from)?])).flatten()
}

#[cfg(test)]
mod tests {
    use umbrage::rays::Camera;

    use super::*;

    #[test]
    fn lines_end_before_the_camera() {
        let camera = Camera::look_at(Vec3::Z, Vec3::ZERO, Vec3::Y, 0.8);
        let picture = Projected { camera, rect: Rect::from_min_size(Pos2::ZERO, vec2(300.0, 200.0)) };
        let [front, behind] = [Vec3::new(0.1, 0.2, 0.0), Vec3::new(0.1, 0.2, 2.0)];
        let whole = visible(&picture, front, Vec3::ZERO).expect("in front");
        assert_eq!(whole, [picture.on_screen(front).expect("in front"), pos2(150.0, 100.0)]);
        let [from, to] = visible(&picture, behind, front).expect("partly in front");
        assert_eq!(to, whole[0]);
        // Along the line, away from the middle, and far outside.
        let (near, far) = (to - pos2(150.0, 100.0), from - pos2(150.0, 100.0));
        assert!(far.length() > 1000.0 && near.dot(far) / (near.length() * far.length()) > 0.999, "{from:?}");
        assert_eq!(visible(&picture, behind, behind + Vec3::X), None);
        let parallel = Camera { projection: Projection::Orthographic { half_height: 1.0 }, ..camera };
        assert!(visible(&Projected { camera: parallel, ..picture }, behind, behind + Vec3::X).is_some());
    }
}
