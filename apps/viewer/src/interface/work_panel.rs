//! The panel of times and work.

use eframe::egui;
use indicatif::HumanCount;

use super::chart;
use crate::app::{App, Shown};
use crate::show::Show;

pub(super) fn show(app: &mut App, ui: &mut egui::Ui) {
    ui.strong("Time of the last pictures");
    chart::show(&app.history, ui);
    let Some(Shown { picture, .. }) = &app.shown else {
        ui.weak("Nothing was rendered yet.");
        return;
    };
    let stats = &picture.stats;
    let total = stats.total_milliseconds();
    egui::Grid::new("stages").num_columns(3).striped(true).show(ui, |ui| {
        for stage in &stats.stages {
            let index = app.history.names().iter().position(|name| *name == stage.name).unwrap_or(0);
            let (square, _) = ui.allocate_exact_size(egui::Vec2::splat(10.0), egui::Sense::hover());
            ui.painter().rect_filled(square, 1.0, chart::color(index));
            ui.label(stage.name);
            ui.monospace(format!("{:9.3} ms", stage.milliseconds));
            ui.end_row();
        }
        ui.label("");
        ui.strong("all");
        ui.monospace(format!("{total:9.3} ms"));
        ui.end_row();
    });
    ui.separator();
    egui::Grid::new("counts").num_columns(2).striped(true).show(ui, |ui| {
        let mut row = |name: &str, value: String| {
            ui.label(name);
            ui.monospace(value);
            ui.end_row();
        };
        let grouped = |number: u64| HumanCount(number).to_string();
        row("picture", format!("{} × {}", picture.view.width, picture.view.height));
        row("from order to pixels", format!("{:.1} ms", picture.milliseconds));
        row("triangles", grouped(stats.triangles as u64));
        row("vertices", grouped(stats.vertices as u64));
        row("lights", grouped(stats.lights as u64));
        row("camera rays", grouped(stats.camera_rays));
        row("shadow rays", grouped(stats.shadow_rays));
        let rays = (stats.camera_rays + stats.shadow_rays) as f64;
        row("rays a second", grouped((rays / (1e-3 * total.max(1e-6))) as u64));
        let parts = [
            ("structure", stats.structure_bytes),
            ("light grid", stats.point_bytes),
            ("frame", stats.frame_bytes),
            ("pixels", stats.pixel_bytes),
        ];
        for (name, bytes) in parts {
            row(name, format!("{} bytes", HumanCount(bytes as u64)));
        }
        if stats.uploaded_bytes > 0 {
            row("uploaded", format!("{} bytes", HumanCount(stats.uploaded_bytes)));
        }
        if stats.omitted_marks > 0 {
            row(
                "left out",
                format!("{} points and lines: only the CPU draws them", HumanCount(stats.omitted_marks as u64)),
            );
        }
        for omitted in &stats.omitted {
            row("left out", format!("{}: {}", HumanCount(u64::from(omitted.count)), omitted.reason));
        }
    });
    ui.separator();
    show_list(&mut app.show, ui);
    if let Some(map) = &picture.heat {
        let highest = map.counts.iter().copied().max().unwrap_or(0);
        ui.weak(format!("{}, at most {}", map.title(), HumanCount(u64::from(highest))));
    }
    ui.separator();
    ui.checkbox(&mut app.shows_light_grid, "Light grid");
    if let Some(grid) = &picture.light_grid {
        ui.weak(grid.title());
    }
}

/// The choice of the view that the picture shows.
fn show_list(chosen: &mut Show, ui: &mut egui::Ui) {
    egui::ComboBox::from_label("Show").selected_text(chosen.title()).height(400.0).show_ui(ui, |ui| {
        let mut entry = |ui: &mut egui::Ui, show: Show| {
            ui.selectable_value(chosen, show, show.title()).on_hover_text(show.about());
        };
        entry(ui, Show::Light);
        ui.separator();
        Show::views().for_each(|view| entry(ui, view));
        ui.separator();
        Show::heats().for_each(|heat| entry(ui, heat));
    });
}
