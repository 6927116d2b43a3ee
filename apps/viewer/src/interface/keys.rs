//! Keys and their actions.

use eframe::egui::{self, Key as Code, Modifiers};
use glam::Vec3;
use umbrage::rays::LightSource;
use umbrage::spec::LookAt;

use super::menu;
use crate::app::{App, CameraChoice};
use crate::choices::EngineChoice;
use crate::dialogs::Wanted;
use crate::focus::Focus;
use crate::free_camera;

const NONE: Modifiers = Modifiers::NONE;
const CTRL: Modifiers = Modifiers::COMMAND;

/// The action of a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Key {
    Open,
    Reload,
    Screenshot,
    Record,
    CopyCommand,
    Play,
    StepBack,
    StepOn,
    Start,
    FrameAll,
    FrameSubject,
    LookFromLight,
    Engine,
    Heat,
    PixelView,
    Work,
    LightGrid,
    Controls,
    Help,
}

/// An action, the keys that trigger it, their name, and the action's description.
type Row = (Key, &'static [(Modifiers, Code)], &'static str, &'static str);

impl Key {
    /// All of them, in the order of the help.
    pub(super) const ALL: &'static [Row] = &[
        (Self::Open, &[(CTRL, Code::O)], "Ctrl+O", "Open a file"),
        (Self::Reload, &[(CTRL, Code::R)], "Ctrl+R", "Reload the scene"),
        (Self::Screenshot, &[(NONE, Code::P)], "P", "Save the picture as a PNG"),
        (Self::Record, &[(NONE, Code::R)], "R", "Record the animation as a GIF, or stop"),
        (Self::CopyCommand, &[(NONE, Code::C)], "C", "Copy as command"),
        (Self::Play, &[(NONE, Code::Space)], "Space", "Play or pause"),
        (Self::StepBack, &[(NONE, Code::ArrowLeft)], "Left", "One frame back"),
        (Self::StepOn, &[(NONE, Code::ArrowRight)], "Right", "One frame on"),
        (Self::Start, &[(NONE, Code::Home)], "Home", "Back to the start"),
        // Before the key without Shift, which would be pressed as well.
        (Self::FrameAll, &[(Modifiers::SHIFT, Code::F)], "Shift+F", "See the whole scene"),
        (Self::FrameSubject, &[(NONE, Code::F)], "F", "See what moves, or what the scene is about"),
        (Self::LookFromLight, &[(NONE, Code::L)], "L", "Look from the selected light"),
        (Self::Engine, &[(NONE, Code::X)], "X", "Switch between CPU and GPU"),
        (Self::Heat, &[(NONE, Code::M)], "M", "Next heat map"),
        (Self::PixelView, &[(NONE, Code::N)], "N", "Next of normals, UV, depth and wireframe"),
        (Self::Work, &[(NONE, Code::T)], "T", "Show where the time goes"),
        (Self::LightGrid, &[(NONE, Code::G)], "G", "Show the selected light's grid"),
        (Self::Controls, &[(NONE, Code::V)], "V", "Show the controls"),
        (Self::Help, &[(NONE, Code::H), (NONE, Code::F1)], "H or F1", "Help"),
    ];

    /// The action's description and the key's name.
    pub(super) fn words(self) -> (&'static str, &'static str) {
        Self::ALL.iter().find(|(key, ..)| *key == self).map_or(("", ""), |(_, _, name, meaning)| (meaning, name))
    }

    /// The description and the key's name, as one text.
    pub(super) fn label(self) -> String {
        let (meaning, name) = self.words();
        format!("{meaning}  ({name})")
    }

    /// A button with the action of the key, labelled with its description.
    pub(super) fn button(self, app: &mut App, ui: &mut egui::Ui) {
        if ui.button(self.label()).clicked() {
            self.press(app, ui);
        }
    }

    pub(super) fn press(self, app: &mut App, ui: &egui::Ui) {
        match self {
            Self::Open => {
                let context = ui.ctx().clone();
                app.dialogs.ask_for(Wanted::Scene, move || context.request_repaint());
            }
            Self::Reload => app.reopen(None),
            Self::Screenshot => {
                let path = menu::screenshot_path(app);
                app.take_screenshot(path);
            }
            Self::Record if app.recording.is_some() => menu::stop_recording(app),
            Self::Record => menu::record(app, "gif", 1),
            Self::CopyCommand => menu::copy_command(app, ui),
            Self::Play => app.timeline.toggle(),
            Self::StepBack => app.timeline.step(-1),
            Self::StepOn => app.timeline.step(1),
            Self::Start => app.timeline.seconds = 0.0,
            Self::FrameAll => app.frame_all(),
            Self::FrameSubject => app.frame_subject(),
            Self::LookFromLight => look_from_light(app),
            Self::Engine => {
                app.history.clear();
                app.kept.choices.engine = match app.kept.choices.engine {
                    EngineChoice::Cpu => EngineChoice::Gpu(String::new()),
                    EngineChoice::Gpu(_) => EngineChoice::Cpu,
                };
            }
            Self::Heat => app.show = app.show.next_heat(),
            Self::PixelView => app.show = app.show.next_view(),
            Self::Work => app.kept.shows_work ^= true,
            Self::LightGrid => app.shows_light_grid ^= true,
            Self::Controls => app.kept.hides_controls ^= true,
            Self::Help => app.is_help_open ^= true,
        }
    }
}

/// Performs the actions of the pressed keys, unless they are typed into a field.
pub(super) fn press(app: &mut App, ui: &egui::Ui) {
    if ui.ctx().egui_wants_keyboard_input() {
        return;
    }
    for (key, codes, ..) in Key::ALL {
        let is_pressed =
            |&(modifiers, code): &(Modifiers, Code)| ui.input_mut(|input| input.consume_key(modifiers, code));
        if codes.iter().any(is_pressed) {
            key.press(app, ui);
        }
    }
    fly(app, ui);
}

/// Moves the camera while W, A, S, D, Q or E are held.
fn fly(app: &mut App, ui: &egui::Ui) {
    const AXES: [(Code, Vec3); 6] = [
        (Code::W, Vec3::Z),
        (Code::S, Vec3::NEG_Z),
        (Code::D, Vec3::X),
        (Code::A, Vec3::NEG_X),
        (Code::E, Vec3::Y),
        (Code::Q, Vec3::NEG_Y),
    ];
    let (way, seconds, is_fast) = ui.input(|input| {
        let held = AXES
            .iter()
            .filter(|(code, _)| input.modifiers.is_none() | input.modifiers.shift_only() && input.key_down(*code));
        (held.map(|(_, axis)| *axis).sum::<Vec3>(), input.stable_dt.min(0.1), input.modifiers.shift)
    });
    if way != Vec3::ZERO {
        let size = app.focus().size;
        let speed = size * if is_fast { 1.0 } else { 0.25 };
        if let Some(camera) = app.free_camera() {
            free_camera::fly(camera, way * speed * seconds);
        }
        ui.ctx().request_repaint();
    }
}

fn look_from_light(app: &mut App) {
    let Focus { center, size } = app.focus();
    let light = app.lights.lights().get(app.lights.selected.unwrap_or(0));
    let (position, target) = match light.map(|light| light.source) {
        None => return app.notices.say("There is no light to look from."),
        Some(LightSource::Point { position }) => (position, center),
        Some(LightSource::Spot { position, direction, .. }) => (position, position + direction * size * 0.5),
        Some(LightSource::Directional { direction }) => (center - direction * size, center),
    };
    if position != target {
        app.camera = CameraChoice::Free(LookAt { position, target, fov_degrees: 60.0 });
    }
}
