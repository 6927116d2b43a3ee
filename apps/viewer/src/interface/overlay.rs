//! What is drawn over the picture: a heat map's legend, and the value under the cursor.

use eframe::egui::{self, Align2, Color32, FontId, Rect, Response, pos2, vec2};

use super::stage::pixel_at;
use crate::app::{App, Shown};
use crate::heat::HeatMap;

pub(super) fn show(app: &App, ui: &egui::Ui, response: &Response, rect: Rect) {
    let Some(shown @ Shown { picture, .. }) = &app.shown else { return };
    let Some(map) = &picture.heat else { return };
    legend(ui, map, rect);
    let Some(pixel) = response.hover_pos().and_then(|place| pixel_at(shown, rect, place)) else { return };
    let count = map.counts[pixel[1] as usize * picture.size()[0] + pixel[0] as usize];
    response.clone().on_hover_text_at_pointer(format!("{count}"));
}

fn legend(ui: &egui::Ui, map: &HeatMap, rect: Rect) {
    const STEPS: u32 = 128;
    let width = (rect.width() - 40.0).clamp(60.0, 320.0);
    let area = Rect::from_min_size(rect.min + vec2(12.0, 12.0), vec2(width + 16.0, 58.0));
    let painter = ui.painter_at(rect);
    painter.rect_filled(area, 4.0, Color32::from_black_alpha(170));
    let bar = Rect::from_min_size(area.min + vec2(8.0, 22.0), vec2(width, 12.0));
    let font = FontId::proportional(12.0);
    let title = map.note.map_or_else(|| map.heat.title().to_owned(), |note| format!("{}, {note}", map.heat.title()));
    painter.text(area.min + vec2(8.0, 4.0), Align2::LEFT_TOP, title, font.clone(), Color32::WHITE);
    let top = map.scale.top();
    for step in 0..STEPS {
        let [red, green, blue] = map.scale.color((u64::from(step) * u64::from(top) / u64::from(STEPS - 1)) as u32);
        let left = bar.left() + bar.width() * step as f32 / STEPS as f32;
        let part = Rect::from_min_size(pos2(left, bar.top()), vec2(bar.width() / STEPS as f32 + 0.5, bar.height()));
        painter.rect_filled(part, 0.0, Color32::from_rgb(red, green, blue));
    }
    for count in map.scale.ticks(bar.width() as u32, 40) {
        let x = bar.left() + bar.width() * count as f32 / top as f32;
        painter.vline(x, bar.bottom()..=bar.bottom() + 3.0, egui::Stroke::new(1.0, Color32::WHITE));
        painter.text(pos2(x, bar.bottom() + 4.0), Align2::CENTER_TOP, count, font.clone(), Color32::WHITE);
    }
}
