//! Stacked stage times of the last pictures.

use eframe::egui::{self, Color32, Rect, Sense, pos2, vec2};

use crate::history::History;

/// A stage's colour, by its index.
pub(super) fn color(stage: usize) -> Color32 {
    // Hues at the golden angle and two lightnesses, so that neighbours differ clearly.
    let hue = (0.58 + 0.381_966 * stage as f32).fract();
    let value = if stage.is_multiple_of(2) { 0.9 } else { 0.7 };
    egui::ecolor::Hsva::new(hue, 0.62, value, 1.0).into()
}

/// Draws one column for each picture, the newest at the right.
pub(super) fn show(history: &History, ui: &mut egui::Ui) {
    let (response, painter) = ui.allocate_painter(vec2(ui.available_width(), 120.0), Sense::hover());
    let rect = response.rect;
    painter.rect_filled(rect, 2.0, ui.visuals().extreme_bg_color);
    let top = round_up(history.longest());
    let column = rect.width() / History::LENGTH as f32;
    let height = |milliseconds: f64| (milliseconds / top) as f32 * rect.height();
    let first = rect.right() - column * history.pictures().len() as f32;
    for (index, times) in history.pictures().enumerate() {
        let left = first + column * index as f32;
        let mut y = rect.bottom();
        for (stage, &milliseconds) in times.iter().enumerate() {
            let above = y - height(milliseconds);
            painter.rect_filled(Rect::from_min_max(pos2(left, above), pos2(left + column, y)), 0.0, color(stage));
            y = above;
        }
    }
    let font = egui::FontId::proportional(10.0);
    for part in [0.5, 1.0] {
        let y = rect.bottom() - part * rect.height();
        painter.hline(rect.x_range(), y, egui::Stroke::new(1.0, Color32::from_white_alpha(40)));
        let label = format!("{} ms", top * f64::from(part));
        painter.text(
            pos2(rect.left() + 3.0, y + 2.0),
            egui::Align2::LEFT_TOP,
            label,
            font.clone(),
            Color32::from_white_alpha(160),
        );
    }
    if let Some(pointer) = response.hover_pos() {
        let number = ((pointer.x - first) / column).floor();
        if let Some(times) = history.pictures().nth(number.max(0.0) as usize).filter(|_| number >= 0.0) {
            let text = format!("{:.2} ms", times.iter().sum::<f64>());
            response.on_hover_text_at_pointer(text);
        }
    }
}

/// A round number that is at least `milliseconds`.
fn round_up(milliseconds: f64) -> f64 {
    let power = 10_f64.powf(milliseconds.max(1e-3).log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|step| step * power);
    steps.into_iter().find(|step| *step >= milliseconds).unwrap_or(10.0 * power)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_are_round() {
        for (longest, top) in [(0.0, 0.001), (0.3, 0.5), (1.0, 1.0), (33.4, 50.0), (78.0, 100.0), (1001.0, 2000.0)] {
            assert!((round_up(longest) / top - 1.0).abs() < 1e-9, "{longest}: {}", round_up(longest));
        }
    }
}
