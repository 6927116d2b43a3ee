//! What renders, and how.

use eframe::egui::{self, ComboBox, DragValue, Slider};
use umbrage::Settings;
use umbrage::gpu::Adapter;
use umbrage::rays::{KdBuilder, KdTraversal};

use crate::app::App;
use crate::choices::{
    Choices, EngineChoice, KdTreeChoices, ListedChoices, Resolution, StructureChoice, SurroundingsChoice,
    UniformChoices,
};

pub(super) fn engine(app: &mut App, ui: &mut egui::Ui) {
    let before = (app.kept.choices.engine.clone(), app.kept.choices.structure);
    let choices = &mut app.kept.choices;
    let chosen = match &choices.engine {
        EngineChoice::Cpu => "CPU".to_owned(),
        EngineChoice::Gpu(name) if name.is_empty() => "GPU".to_owned(),
        EngineChoice::Gpu(name) => name.clone(),
    };
    ComboBox::from_label("Engine").selected_text(chosen).width(150.0).truncate().show_ui(ui, |ui| {
        ui.selectable_value(&mut choices.engine, EngineChoice::Cpu, "CPU");
        for adapter in adapters(ui) {
            let label = if adapter.is_software {
                format!("{} (no GPU, but a program)", adapter.name)
            } else {
                adapter.name.clone()
            };
            ui.selectable_value(&mut choices.engine, EngineChoice::Gpu(adapter.name), label);
        }
    });
    if choices.engine == EngineChoice::Cpu {
        structure(choices, ui);
        ui.add(Slider::new(&mut choices.bounces, 0..=16).text("Mirrors in a row"));
    }
    ui.checkbox(&mut choices.culls_back_faces, "See through back faces");
    if before != (choices.engine.clone(), choices.structure) {
        app.history.clear();
    }
    if let Some(shown) = &app.shown {
        ui.weak(&shown.picture.device);
    }
}

fn structure(choices: &mut Choices, ui: &mut egui::Ui) {
    const ALL: [(StructureChoice, &str); 5] = [
        (StructureChoice::Perspective, "Perspective grid"),
        (StructureChoice::Listed, "Grid with lists"),
        (StructureChoice::Grid, "Uniform grid"),
        (StructureChoice::KdTree, "Kd-tree"),
        (StructureChoice::Bvh, "Hierarchy"),
    ];
    let chosen = ALL.iter().find(|(choice, _)| *choice == choices.structure).map_or("", |(_, name)| *name);
    ComboBox::from_label("Structure").selected_text(chosen).width(150.0).show_ui(ui, |ui| {
        for (choice, name) in ALL {
            ui.selectable_value(&mut choices.structure, choice, name);
        }
    });
    match choices.structure {
        StructureChoice::Listed => listed(&mut choices.listed, ui),
        StructureChoice::Grid => uniform(&mut choices.uniform, ui),
        StructureChoice::KdTree => kd_tree(&mut choices.kd_tree, ui),
        StructureChoice::Perspective | StructureChoice::Bvh => {}
    }
}

fn kd_tree(kd_tree: &mut KdTreeChoices, ui: &mut egui::Ui) {
    // One that takes N² time isn't for a window.
    let builders = KdBuilder::ALL.into_iter().filter(|builder| *builder != KdBuilder::Naive);
    names(ui, "Builder", &mut kd_tree.builder, builders.map(|builder| builder.to_string()));
    let traversals = KdTraversal::KINDS.into_iter().map(|traversal| traversal.to_string());
    names(ui, "Traversal", &mut kd_tree.traversal, traversals);
    if ui.button("Defaults").clicked() {
        *kd_tree = KdTreeChoices::default();
    }
}

fn uniform(uniform: &mut UniformChoices, ui: &mut egui::Ui) {
    ui.add(Slider::new(&mut uniform.cells_per_triangle, 0.1..=100.0).logarithmic(true).text("Cells per triangle"));
    powers(ui, "Pixels a side of a packet", &mut uniform.packet, &[2, 4, 8, 16, 32]);
    if ui.button("Defaults").clicked() {
        *uniform = UniformChoices::default();
    }
}

fn listed(listed: &mut ListedChoices, ui: &mut egui::Ui) {
    powers(ui, "Sorting tile, pixels", &mut listed.sorting_tile, &[8, 16, 32, 64]);
    powers(ui, "Sorting tiles a side", &mut listed.tracing_tiles, &[1, 2, 4, 8]);
    ui.add(Slider::new(&mut listed.slices, 1..=64).text("Depth slices"));
    ui.add(Slider::new(&mut listed.light_cells, 1..=2048).logarithmic(true).text("Light cells a side"));
    ui.add(Slider::new(&mut listed.light_rays, 1..=4096).logarithmic(true).text("Rays per block"));
    ui.add(Slider::new(&mut listed.light_triangles, 1..=4096).logarithmic(true).text("Triangles per block"));
    if ui.button("Defaults").clicked() {
        *listed = ListedChoices::default();
    }
}

fn names(ui: &mut egui::Ui, label: &str, value: &mut String, all: impl Iterator<Item = String>) {
    ComboBox::from_label(label).selected_text(value.as_str()).width(110.0).show_ui(ui, |ui| {
        for name in all {
            ui.selectable_value(value, name.clone(), name);
        }
    });
}

fn powers(ui: &mut egui::Ui, label: &str, value: &mut u32, all: &[u32]) {
    ComboBox::from_label(label).selected_text(value.to_string()).width(60.0).show_ui(ui, |ui| {
        for &power in all {
            ui.selectable_value(value, power, power.to_string());
        }
    });
}

/// This machine's adapters, asked for once.
fn adapters(ui: &egui::Ui) -> Vec<Adapter> {
    ui.ctx().memory_mut(|memory| {
        memory.data.get_temp_mut_or_insert_with(egui::Id::unique("adapters"), Adapter::all).clone()
    })
}

pub(super) fn picture(app: &mut App, ui: &mut egui::Ui) {
    let choices = &mut app.kept.choices;
    resolution(choices, ui);
    ui.horizontal(|ui| {
        let label = ui.label("Samples per pixel").id;
        ui.add(DragValue::new(&mut choices.samples).range(1..=Settings::MAX_SAMPLES).speed(0.1)).labelled_by(label);
    });
    ui.add(Slider::new(&mut choices.exposure_stops, -8.0..=8.0).text("Exposure, stops"));
    ui.checkbox(&mut choices.clips, "Cut off what is too bright");
    ui.horizontal(|ui| {
        let mut is_sky = choices.surroundings == SurroundingsChoice::Sky;
        if ui.checkbox(&mut is_sky, "Sky").changed() {
            choices.surroundings =
                if is_sky { SurroundingsChoice::Sky } else { SurroundingsChoice::Color([0.2, 0.2, 0.2]) };
        }
        if let SurroundingsChoice::Color(color) = &mut choices.surroundings {
            ui.color_edit_button_rgb(color);
            ui.label("Background");
        }
    });
}

fn resolution(choices: &mut Choices, ui: &mut egui::Ui) {
    let chosen = match choices.resolution {
        Resolution::Window => "The window's".to_owned(),
        Resolution::Fraction(side) => format!("1/{side} of the window's"),
        Resolution::Fixed([width, height]) => format!("{width} × {height}"),
    };
    ComboBox::from_label("Resolution").selected_text(chosen).width(150.0).show_ui(ui, |ui| {
        ui.selectable_value(&mut choices.resolution, Resolution::Window, "The window's");
        for side in [2, 4] {
            ui.selectable_value(
                &mut choices.resolution,
                Resolution::Fraction(side),
                format!("1/{side} of the window's"),
            );
        }
        for size in [[512, 512], [1024, 1024], [1280, 720], [1920, 1080]] {
            let [width, height] = size;
            ui.selectable_value(&mut choices.resolution, Resolution::Fixed(size), format!("{width} × {height}"));
        }
    });
}
