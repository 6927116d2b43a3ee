//! The panel of the engine and its options.

use std::ops::RangeInclusive;

use eframe::egui::{self, ComboBox, DragValue, Slider};
use glam::Vec3;
use umbrage::gpu::Adapter;
use umbrage::rays::Choice;
use umbrage::scene::{Ground, GroundChoice, GroundSurface, Light, OpenOptions};
use umbrage::spec::BackgroundSpec;
use umbrage::{OptionValues, Settings, Sides, StructureOption, ToneMap};
use umbrage_papers::KdBuilder;

use crate::app::App;
use crate::choices::{Choices, EngineChoice, Resolution};
use crate::dialogs::{Dialogs, Wanted};
use crate::notices::Notices;

/// Unit of lengths: the file's own.
pub(super) const UNITS: &str = " units";

/// The name of a choice, as menus have names.
fn capital(name: &str) -> String {
    const OWN: &[(&str, &str)] = &[("bvh", "BVH"), ("kdtree", "Kd-tree")];
    if let Some((_, own)) = OWN.iter().find(|(known, _)| *known == name) {
        return (*own).to_owned();
    }
    let mut letters = name.chars().map(|letter| if letter == '-' { ' ' } else { letter });
    letters.next().map(|first| first.to_uppercase().chain(letters).collect()).unwrap_or_default()
}

pub(super) fn engine(app: &mut App, ui: &mut egui::Ui) {
    let before = (app.kept.choices.engine.clone(), app.kept.choices.structures.chosen().name());
    let choices = &mut app.kept.choices;
    let chosen = match &choices.engine {
        EngineChoice::Cpu => "CPU".to_owned(),
        EngineChoice::Gpu(name) if name.is_empty() => "GPU".to_owned(),
        EngineChoice::Gpu(name) => name.clone(),
    };
    ComboBox::from_label("Engine").selected_text(chosen).truncate().show_ui(ui, |ui| {
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
        structure(choices, &mut app.notices, ui);
    }
    ui.add(Slider::new(&mut choices.bounces, 0..=16).text("Bounces")).on_hover_text("Mirrors and glass in a row");
    if choices.bounces > 0 && choices.samples > 1 {
        ui.checkbox(&mut choices.gloss, "Blurred mirrors").on_hover_text("Each sample has one direction of highlights");
    }
    if choices.engine == EngineChoice::Cpu {
        ui.checkbox(&mut choices.smooth_terminator, "Smooth terminators").on_hover_text(
            "Light ends on round surfaces where their vertices' normals say, instead of at whole triangles",
        );
    }
    if choices.engine == EngineChoice::Cpu {
        for (size, name) in [(&mut choices.point_size, "Points"), (&mut choices.line_width, "Lines")] {
            ui.add(Slider::new(size, 0.5..=16.0).text(name)).on_hover_text("Of the scene's own, in pixels");
        }
    }
    ComboBox::from_label("Sides").selected_text(capital(choices.sides.name())).show_ui(ui, |ui| {
        for &(name, sides, about) in Sides::CHOICES {
            ui.selectable_value(&mut choices.sides, sides, capital(name)).on_hover_text(about);
        }
    });
    if before != (choices.engine.clone(), choices.structures.chosen().name()) {
        app.history.clear();
        app.coarseness.clear();
    }
    if let Some(shown) = &app.shown {
        ui.weak(&shown.picture.device);
    }
}

fn structure(choices: &mut Choices, notices: &mut Notices, ui: &mut egui::Ui) {
    let structures = &mut choices.structures;
    let chosen = structures.chosen().name();
    ComboBox::from_label("Structure").selected_text(capital(chosen)).show_ui(ui, |ui| {
        for structure in umbrage_papers::structures().iter() {
            let (name, about) = (structure.name(), structure.about());
            if ui.selectable_label(name == chosen, capital(name)).on_hover_text(about).clicked() {
                structures.choose(name);
            }
        }
    });
    let structure = structures.change();
    for option in structure.options() {
        let Some(before) = structure.option(option.name) else { continue };
        let after = self::option(option, &before, ui);
        if after != before
            && let Err(impossible) = structure.set_option(option.name, &after)
        {
            notices.error(impossible.to_string());
        }
    }
    if structure.options().next().is_some() && ui.button("Defaults").clicked() {
        *structure = structure.with_defaults();
    }
}

/// An option's field: its new value as text.
fn option(option: &StructureOption, value: &str, ui: &mut egui::Ui) -> String {
    /// The least and greatest numbers of cells for each triangle, and of triangles in nested grids' cells, that are
    /// useful.
    const DENSITIES: RangeInclusive<f64> = 0.1..=100.0;
    const MOST: u32 = 4096;
    /// A rectangle of angles to begin with.
    const WIDE: [f32; 4] = [-45.0, 45.0, -45.0, 45.0];
    let StructureOption { name, about, values, .. } = option;
    let label = capital(name);
    match values {
        OptionValues::Names(names) => {
            let mut chosen = value.to_owned();
            // A builder of O(N²) time is too slow for a window.
            let names = names().into_iter().filter(|(name, _)| *name != KdBuilder::Naive.name());
            let list = ComboBox::from_label(label).selected_text(capital(value)).width(110.0).show_ui(ui, |ui| {
                for (name, about) in names {
                    let entry = ui.selectable_value(&mut chosen, name.to_owned(), capital(name));
                    if !about.is_empty() {
                        entry.on_hover_text(about);
                    }
                }
            });
            list.response.on_hover_text(*about);
            chosen
        }
        OptionValues::Whole(range) => {
            let mut number = value.parse::<u32>().unwrap_or(*range.start());
            ui.add(Slider::new(&mut number, range.clone()).logarithmic(true).text(label)).on_hover_text(*about);
            number.to_string()
        }
        OptionValues::WholeOrAuto(range) => {
            // The lowest number stands for `auto`.
            let least = range.start() - 1;
            let mut number = value.parse::<u32>().unwrap_or(least);
            let named = |number: f64, _| if number as u32 == least { "Auto".to_owned() } else { number.to_string() };
            let slider = Slider::new(&mut number, least..=MOST).logarithmic(true).text(label).custom_formatter(named);
            ui.add(slider).on_hover_text(*about);
            if number == least { "auto".to_owned() } else { number.to_string() }
        }
        OptionValues::Rectangle => {
            let mut is_auto = value == "auto";
            ui.checkbox(&mut is_auto, format!("{label}: auto")).on_hover_text(*about);
            let mut degrees = value.split(':').map(|number| number.parse::<f32>().ok());
            let mut degrees = WIDE.map(|wide| degrees.next().flatten().unwrap_or(wide));
            if !is_auto {
                ui.horizontal(|ui| {
                    for number in &mut degrees {
                        ui.add(DragValue::new(number).range(-180.0..=180.0).suffix("°"));
                    }
                });
            }
            if is_auto { "auto".to_owned() } else { degrees.map(|number| number.to_string()).join(":") }
        }
        OptionValues::Positive => {
            let mut number = value.parse::<f64>().unwrap_or(*DENSITIES.start());
            ui.add(Slider::new(&mut number, DENSITIES).logarithmic(true).text(label)).on_hover_text(*about);
            number.to_string()
        }
        OptionValues::Share => {
            let mut number = value.parse::<f64>().unwrap_or_default();
            ui.add(Slider::new(&mut number, 0.0..=1.0).text(label)).on_hover_text(*about);
            number.to_string()
        }
        OptionValues::Switch => {
            let mut is_on = value == "true";
            ui.checkbox(&mut is_on, label).on_hover_text(*about);
            is_on.to_string()
        }
    }
}

/// Effects that samples are spread over, if there are several samples; `size` is the scene's, in world units.
fn spread(choices: &mut Choices, size: f32, ui: &mut egui::Ui) {
    if choices.samples < 2 {
        return;
    }
    let mut number = |name: &str, about: &str, number: DragValue<'_>| {
        ui.horizontal(|ui| {
            let label = ui.label(name).on_hover_text(about).id;
            ui.add(number).labelled_by(label);
        });
    };
    let speed = 0.001 * size;
    let sharp = "Diameter of the lens: with 0, everything is sharp";
    number("Aperture", sharp, DragValue::new(&mut choices.aperture).range(0.0..=f32::MAX).speed(speed).suffix(UNITS));
    let about = "How long the shutter is open: what moves leaves a streak";
    let shutter = DragValue::new(&mut choices.shutter_seconds).range(0.0..=60.0).speed(0.001).suffix(" s");
    number("Shutter", about, shutter);
    let about = "Of lights without a radius of their own, of suns in degrees: shadows have soft edges";
    let radius = DragValue::new(&mut choices.light_radius).range(0.0..=Light::MAX_SUN_RADIUS_DEGREES).speed(speed);
    let radius = radius.suffix(" units or °");
    number("Lights' radius", about, radius);
    if !choices.sky_shadows {
        let about = "Light from all around doesn't come from where something is nearer: with 0, nothing is";
        let reach = DragValue::new(&mut choices.ambient_occlusion).range(0.0..=f32::MAX).speed(speed).suffix(UNITS);
        number("Ambient occlusion", about, reach);
    }
    ui.checkbox(&mut choices.sky_shadows, "Shadows of the sky")
        .on_hover_text("Each sample has one direction of its light");
    if choices.aperture > 0.0 {
        let mut is_given = choices.focus.is_some();
        ui.checkbox(&mut is_given, "Focus at a depth").on_hover_text("Otherwise on what is in the middle");
        choices.focus = is_given.then(|| choices.focus.unwrap_or(size));
        if let Some(focus) = &mut choices.focus {
            ui.add(DragValue::new(focus).range(1e-3 * size..=f32::MAX).speed(speed).suffix(UNITS));
        }
    }
}

/// This machine's adapters, asked for once.
fn adapters(ui: &egui::Ui) -> Vec<Adapter> {
    ui.ctx().memory_mut(|memory| {
        memory.data.get_temp_mut_or_insert_with(egui::Id::unique("adapters"), Adapter::all).clone()
    })
}

pub(super) fn picture(app: &mut App, ui: &mut egui::Ui) {
    let size = app.focus().size;
    let choices = &mut app.kept.choices;
    resolution(choices, ui);
    let mut samples = |name: &str, about: &str, samples: &mut u32| {
        ui.horizontal(|ui| {
            let label = ui.label(name).on_hover_text(about).id;
            ui.add(DragValue::new(samples).range(1..=Settings::MAX_SAMPLES).speed(0.1)).labelled_by(label);
        });
    };
    samples("Samples per pixel", "Of a picture that stays: it becomes sharper until it has them", &mut choices.samples);
    samples("In motion", "Samples per pixel while anything moves", &mut choices.samples_in_motion);
    spread(choices, size, ui);
    ui.add(Slider::new(&mut choices.exposure_stops, -8.0..=8.0).text("Exposure").suffix(" stops"));
    ComboBox::from_label("Tone map").selected_text(capital(choices.tone_map.name())).show_ui(ui, |ui| {
        for &(name, tone_map, about) in ToneMap::CHOICES {
            ui.selectable_value(&mut choices.tone_map, tone_map, capital(name)).on_hover_text(about);
        }
    });
    surroundings(&mut choices.surroundings, &mut app.dialogs, ui);
    ground(app, ui);
    variant(app, ui);
}

/// The choice of the background.
fn surroundings(chosen: &mut BackgroundSpec, dialogs: &mut Dialogs, ui: &mut egui::Ui) {
    let name = match chosen {
        BackgroundSpec::Sky => "Sky",
        BackgroundSpec::Transparent => "None",
        BackgroundSpec::Color(_) => "Colour",
        BackgroundSpec::File(_) => "Image",
    };
    ui.horizontal(|ui| {
        ComboBox::from_label("Background").selected_text(name).show_ui(ui, |ui| {
            ui.selectable_value(chosen, BackgroundSpec::Sky, "Sky");
            ui.selectable_value(chosen, BackgroundSpec::Transparent, "None").on_hover_text("Transparent in pictures");
            if ui.selectable_label(name == "Colour", "Colour").clicked() && name != "Colour" {
                *chosen = BackgroundSpec::Color(Vec3::splat(0.2));
            }
            let image = ui.selectable_label(name == "Image", "Image …");
            if image.on_hover_text("Light from all around: a latitude-longitude image, such as an .hdr").clicked() {
                let context = ui.ctx().clone();
                dialogs.ask_for(Wanted::Background, move || context.request_repaint());
            }
        });
        match chosen {
            BackgroundSpec::Color(color) => {
                ui.color_edit_button_rgb(color.as_mut());
            }
            BackgroundSpec::File(path) => {
                let name = path.file_name().unwrap_or_default().to_string_lossy();
                ui.add(egui::Label::new(name).truncate()).on_hover_text(path.display().to_string());
            }
            BackgroundSpec::Sky | BackgroundSpec::Transparent => {}
        }
    });
}

/// The floor under the scene; a change opens the scene again.
fn ground(app: &mut App, ui: &mut egui::Ui) {
    let Some(open) = &app.open else { return };
    let before = open.scene.ground();
    let mut surface = before.map(|ground| ground.surface);
    ComboBox::from_label("Ground").selected_text(capital(surface.map_or("none", Choice::name))).show_ui(ui, |ui| {
        ui.selectable_value(&mut surface, None, "None");
        for &(name, choice, about) in GroundSurface::CHOICES {
            ui.selectable_value(&mut surface, Some(choice), capital(name)).on_hover_text(about);
        }
    });
    if surface != before.map(|ground| ground.surface) {
        let own = |surface| GroundChoice::Own(Ground { surface, ..before.unwrap_or_default() });
        let ground = surface.map_or(GroundChoice::None, own);
        app.reopen(Some(OpenOptions { ground, ..open.options.clone() }));
    }
}

/// The choice of material variant, if the file has several; a change opens the scene again.
fn variant(app: &mut App, ui: &mut egui::Ui) {
    let Some(open) = &app.open else { return };
    let variants = open.scene.variants();
    if variants.is_empty() {
        return;
    }
    let before = &open.options.variant;
    let mut chosen = before.clone();
    let name = before.clone().unwrap_or_else(|| "Default".to_owned());
    ComboBox::from_label("Variant").selected_text(name).truncate().show_ui(ui, |ui| {
        ui.selectable_value(&mut chosen, None, "Default");
        for name in variants {
            ui.selectable_value(&mut chosen, Some(name.clone()), name);
        }
    });
    if chosen != *before {
        app.reopen(Some(OpenOptions { variant: chosen, ..open.options.clone() }));
    }
}

fn resolution(choices: &mut Choices, ui: &mut egui::Ui) {
    let chosen = match choices.resolution {
        Resolution::Window => "The window's".to_owned(),
        Resolution::Fraction(side) => format!("1/{side} of the window's"),
        Resolution::Fixed([width, height]) => format!("{width} × {height}"),
    };
    ComboBox::from_label("Resolution").selected_text(chosen).show_ui(ui, |ui| {
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
