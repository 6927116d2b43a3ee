//! The times of the last picture's stages, in one line under it.

use eframe::egui::{self, Align2, Color32, FontId, Rect, Sense, Stroke, vec2};

use super::chart;
use crate::app::{App, Shown};

pub(super) fn show(app: &App, ui: &mut egui::Ui) {
    const HEIGHT: f32 = 18.0;
    const TOTAL_WIDTH: f32 = 70.0;
    let (response, painter) = ui.allocate_painter(vec2(ui.available_width(), HEIGHT), Sense::hover());
    let Some(Shown { picture, .. }) = &app.shown else { return };
    let stats = &picture.stats;
    let total = stats.total_milliseconds();
    let font = FontId::proportional(12.0);
    let area = response.rect;
    let width = (area.width() - TOTAL_WIDTH).max(0.0);
    let mut left = area.min;
    for stage in &stats.stages {
        let part = (stage.milliseconds / total.max(f64::MIN_POSITIVE)) as f32 * width;
        let rect = Rect::from_min_size(left, vec2(part, HEIGHT));
        left.x += part;
        let index = app.history.names().iter().position(|name| *name == stage.name).unwrap_or(0);
        painter.rect(
            rect,
            0.0,
            chart::color(index),
            Stroke::new(1.0, Color32::from_gray(24)),
            egui::StrokeKind::Inside,
        );
        let text = format!("{} {:.1} ms", stage.name, stage.milliseconds);
        let galley = painter.layout_no_wrap(text, font.clone(), Color32::BLACK);
        if galley.size().x + 6.0 < part {
            painter.galley(rect.min + vec2(4.0, 2.0), galley, Color32::BLACK);
        }
    }
    let all = format!("{total:.1} ms");
    painter.text(area.right_center(), Align2::RIGHT_CENTER, &all, font, ui.visuals().text_color());
    let stages = stats.stages.iter().map(|stage| format!("{} {:.2} ms", stage.name, stage.milliseconds));
    let stages: Vec<String> = stages.collect();
    let label = format!("Times of stages: {}; all {all}", stages.join(", "));
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, &label));
    response.on_hover_text(stages.join("\n"));
}
