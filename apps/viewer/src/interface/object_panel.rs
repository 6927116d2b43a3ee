//! The list of the scene's objects, which can be shown or hidden.

use eframe::egui;

use crate::app::App;

/// Maximum height of the list in points.
const HIGHEST: f32 = 180.0;

/// Whether the scene has several objects.
pub(super) fn has_choice(app: &App) -> bool {
    app.open.as_ref().is_some_and(|open| open.scene.objects().len() > 1)
}

pub(super) fn show(app: &mut App, ui: &mut egui::Ui) {
    let Some(open) = &app.open else { return };
    let objects = open.scene.objects();
    let find_id = ui.scope_id().with("find");
    let mut find: String = ui.data(|data| data.get_temp(find_id)).unwrap_or_default();
    let mut are_shown: Vec<bool> = objects.iter().map(|name| !open.scene.is_hidden(name)).collect();
    let before = are_shown.clone();
    ui.add(egui::TextEdit::singleline(&mut find).hint_text("Find"));
    let is_wanted = |name: &str| name.to_lowercase().contains(&find.to_lowercase());
    let wanted: Vec<usize> = (0..objects.len()).filter(|&object| is_wanted(&objects[object])).collect();
    ui.horizontal(|ui| {
        for (label, about, shown) in [("Show", "All that are listed", true), ("Hide", "All that are listed", false)] {
            if ui.button(label).on_hover_text(about).clicked() {
                wanted.iter().for_each(|&object| are_shown[object] = shown);
            }
        }
        let hidden = before.iter().filter(|shown| !**shown).count();
        if hidden > 0 {
            ui.weak(format!("{hidden} of {} hidden", objects.len()));
        }
    });
    let height = ui.spacing().interact_size.y;
    let list = egui::ScrollArea::vertical().id_salt("object list").max_height(HIGHEST).auto_shrink([false, true]);
    list.show_rows(ui, height, wanted.len(), |ui, rows| {
        for &object in &wanted[rows] {
            ui.checkbox(&mut are_shown[object], &*objects[object]);
        }
    });
    ui.data_mut(|data| data.insert_temp(find_id, find));
    if are_shown != before {
        let hidden = objects.iter().zip(are_shown).filter(|(_, shown)| !shown);
        let hidden = hidden.map(|(name, _)| name.to_string()).collect();
        app.hide(hidden);
    }
}
