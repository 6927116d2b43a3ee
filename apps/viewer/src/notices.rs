//! Messages to the user.

use std::time::{Duration, Instant};

use eframe::egui;

/// Messages, the newest last.
#[derive(Debug, Default)]
pub(crate) struct Notices {
    all: Vec<Notice>,
}

#[derive(Debug)]
struct Notice {
    text: String,
    is_error: bool,
    since: Instant,
}

impl Notices {
    /// Maximum number shown at once.
    const MOST: usize = 6;
    /// Lifetime of a message that isn't an error, in seconds.
    const SECONDS: u64 = 8;

    pub(crate) fn say(&mut self, text: impl Into<String>) {
        self.add(text.into(), false);
    }

    /// Adds an error, which stays until it is dismissed.
    pub(crate) fn error(&mut self, text: impl Into<String>) {
        self.add(text.into(), true);
    }

    fn add(&mut self, text: String, is_error: bool) {
        // A repeated message replaces the earlier one.
        self.all.retain(|notice| notice.text != text);
        self.all.push(Notice { text, is_error, since: Instant::now() });
        let surplus = self.all.len().saturating_sub(Self::MOST);
        self.all.drain(..surplus);
    }

    /// Shows the messages in the lower left corner of an area.
    pub(crate) fn show(&mut self, ui: &egui::Ui, area: egui::Rect) {
        let life = Duration::from_secs(Self::SECONDS);
        self.all.retain(|notice| notice.is_error || notice.since.elapsed() < life);
        if self.all.is_empty() {
            return;
        }
        ui.ctx().request_repaint_after(Duration::from_secs(1));
        let corner = area.left_bottom() + egui::vec2(8.0, -8.0);
        let shown = egui::Area::new(egui::Id::unique("notices")).fixed_pos(corner).pivot(egui::Align2::LEFT_BOTTOM);
        shown.show(ui.ctx(), |ui| {
            ui.set_max_width((area.width() - 16.0).clamp(50.0, 560.0));
            let mut dismissed = None;
            for (index, notice) in self.all.iter().enumerate() {
                egui::Frame::popup(ui.style()).show(ui, |ui| {
                    ui.horizontal_top(|ui| {
                        if ui.small_button("x").on_hover_text("Dismiss").clicked() {
                            dismissed = Some(index);
                        }
                        let color =
                            if notice.is_error { ui.visuals().error_fg_color } else { ui.visuals().text_color() };
                        ui.add(egui::Label::new(egui::RichText::new(&notice.text).color(color)).wrap());
                    });
                });
            }
            if let Some(index) = dismissed {
                self.all.remove(index);
            }
        });
    }
}
