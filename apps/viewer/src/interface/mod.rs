//! The layout of the window.

mod arrows;
mod camera_panel;
mod chart;
mod engine_panel;
mod gizmo;
mod help;
mod keys;
mod light_panel;
mod menu;
mod object_panel;
mod overlay;
mod panels;
mod probe_panel;
mod stage;
mod strip;
mod time_bar;
mod work_panel;

use eframe::egui;

use self::panels::Panels;
use crate::app::App;
use crate::dialogs::Wanted;

impl eframe::App for App {
    fn ui(&mut self, ui: &mut egui::Ui, _: &mut eframe::Frame) {
        self.show(ui);
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        if !self.forgets {
            eframe::set_value(storage, Self::KEY, &self.kept);
        }
    }

    fn persist_egui_memory(&self) -> bool {
        false
    }
}

impl App {
    /// Takes over new pictures, shows the whole interface, and orders a picture of the user's choices.
    pub fn show(&mut self, ui: &mut egui::Ui) {
        self.receive(ui.ctx());
        keys::press(self, ui);
        drop_files(self, ui);
        egui::Panel::top("menu").show(ui, |ui| menu::show(self, ui));
        egui::Panel::bottom("time").show(ui, |ui| time_bar::show(self, ui));
        // Without the controls, the picture has all of the window.
        if !self.kept.hides_strip && !self.kept.hides_controls {
            egui::Panel::bottom("stages").show(ui, |ui| strip::show(self, ui));
        }
        let panels = Panels::fit(&self.kept, ui.available_width());
        if panels.has_work {
            let panel = egui::Panel::left("work").default_size(300.0).size_range(panels.widths);
            panel.show(ui, |ui| scrolled(ui, |ui| work_panel::show(self, ui)));
        }
        if panels.has_controls {
            let panel = egui::Panel::right("controls").default_size(310.0).size_range(panels.widths);
            panel.show(ui, |ui| {
                scrolled(ui, |ui| {
                    section(ui, "Camera", |ui| camera_panel::show(self, ui));
                    section(ui, "Lights", |ui| light_panel::show(self, ui));
                    if object_panel::has_choice(self) {
                        let header = egui::CollapsingHeader::new(egui::RichText::new("Objects").strong());
                        header.show(ui, |ui| object_panel::show(self, ui));
                    }
                    section(ui, "Engine", |ui| engine_panel::engine(self, ui));
                    section(ui, "Picture", |ui| engine_panel::picture(self, ui));
                    section(ui, "Pixel", |ui| probe_panel::show(self, ui));
                });
            });
        }
        let frame = egui::Frame::new().fill(egui::Color32::from_gray(24));
        egui::CentralPanel::default().frame(frame).show(ui, |ui| stage::show(self, ui));
        help::show(self, ui);
        self.order();
    }
}

/// A panel's widgets, narrower in a narrow one. Wider contents are cut off, and don't widen the panel.
fn scrolled(ui: &mut egui::Ui, contents: impl FnOnce(&mut egui::Ui)) {
    let area = ui.available_rect_before_wrap();
    let mut inner = ui.new_child(egui::UiBuilder::new().max_rect(area));
    let spacing = inner.spacing_mut();
    spacing.slider_width = (0.35 * area.width()).clamp(40.0, 100.0);
    spacing.combo_width = (0.51 * area.width()).clamp(80.0, 150.0);
    egui::ScrollArea::vertical().auto_shrink(false).show(&mut inner, contents);
    ui.advance_cursor_after_rect(area);
}

fn section(ui: &mut egui::Ui, title: &str, contents: impl FnOnce(&mut egui::Ui)) {
    egui::CollapsingHeader::new(egui::RichText::new(title).strong()).default_open(true).show(ui, contents);
}

/// Opens a file that is dropped on the window: a scene or, where it is an image, a background.
fn drop_files(app: &mut App, ui: &egui::Ui) {
    let dropped = ui.input(|input| input.raw.dropped_files.first().map(|file| file.path().to_owned()));
    if let Some(path) = dropped {
        app.open_as(Wanted::of(&path), path);
    }
}
