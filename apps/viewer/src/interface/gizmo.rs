//! Draggable handles of lights in the picture.

use std::f32::consts::TAU;

use eframe::egui::{self, Align2, Color32, FontId, Painter, PointerButton, Pos2, Response, Stroke, vec2};
use glam::{DVec3, Vec2, Vec3};
use umbrage::rays::LightSource;
use umbrage::scene::{Light, LightShape};

use crate::app::App;
use crate::focus::Focus;
use crate::light_list::unit;
use crate::probe::light_name;
use crate::projection::Projected;

/// The dragged part of a light.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Grab {
    light: usize,
    part: Part,
}

/// A part of a light's gizmo.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Part {
    /// The light itself: moves in the picture's plane, or round the scene for a sun.
    Center,
    /// An arrow along a world axis.
    Axis(usize),
    /// The target of a spot.
    Target,
}

const AXES: [(Vec3, Color32); 3] = [
    (Vec3::X, Color32::from_rgb(230, 80, 70)),
    (Vec3::Y, Color32::from_rgb(110, 200, 80)),
    (Vec3::Z, Color32::from_rgb(80, 130, 240)),
];
/// Maximum distance of the pointer from a handle, in points.
const REACH: f32 = 11.0;
/// Length of the axes in points.
const AXIS: f32 = 54.0;

/// Draws the handles and moves the dragged light. Returns whether there is one.
pub(super) fn show(app: &mut App, ui: &egui::Ui, response: &Response, picture: &Projected, painter: &Painter) -> bool {
    let id = response.id.with("gizmo");
    let mut grab: Option<Grab> = ui.data(|data| data.get_temp(id).flatten());
    let handles = handles(app, picture);
    if response.drag_started_by(PointerButton::Primary) {
        let pressed = ui.input(|input| input.pointer.press_origin());
        grab = pressed.and_then(|pointer| nearest(&handles, pointer)).map(|handle| handle.grab);
        if let Some(Grab { light, .. }) = grab {
            app.lights.selected = Some(light);
        }
    }
    if !response.dragged() {
        if let Some(pointer) = response.interact_pointer_pos().filter(|_| response.clicked_by(PointerButton::Primary))
            && let Some(handle) = nearest(&handles, pointer)
        {
            app.lights.selected = Some(handle.grab.light);
        }
        grab = None;
    }
    if let (Some(Grab { light, part }), Some(pointer)) = (grab, response.interact_pointer_pos()) {
        let focus = app.focus();
        if let Some(changed) = app.lights.change(light) {
            drag(&mut changed.source, part, picture, pointer, response.drag_delta(), focus);
        }
    }
    outline(app, picture, painter);
    draw(
        &handles,
        app.lights.selected,
        grab.or_else(|| response.hover_pos().and_then(|pointer| nearest(&handles, pointer)).map(|handle| handle.grab)),
        painter,
    );
    name_handles(app, ui, &handles);
    ui.data_mut(|data| data.insert_temp(id, grab));
    grab.is_some()
}

/// Draws the rims of flat lights.
fn outline(app: &App, picture: &Projected, painter: &Painter) {
    for light in app.lights.lights() {
        let LightSource::Spot { position, direction, .. } = light.source else { continue };
        let rim: Vec<Vec2> = match light.shape {
            LightShape::Ball(_) => continue,
            LightShape::Disk(radius) => (0..48).map(|i| radius * Vec2::from_angle(i as f32 / 48.0 * TAU)).collect(),
            LightShape::Rectangle { width, height } => [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)]
                .map(|(x, y)| Vec2::new(x * width, y * height))
                .to_vec(),
        };
        let [across, up] = Light::axes(direction).map(DVec3::as_vec3);
        let on_screen = rim.iter().map(|point| picture.on_screen(position + across * point.x + up * point.y));
        // A light that is partly behind the camera gets no rim.
        if let Some(rim) = on_screen.collect::<Option<Vec<Pos2>>>() {
            painter.add(egui::Shape::closed_line(rim, Stroke::new(1.5, tint(light.color))));
        }
    }
}

/// Names the handles for assistive programs.
fn name_handles(app: &App, ui: &egui::Ui, handles: &[Handle]) {
    for handle in handles.iter().filter(|handle| handle.grab.part == Part::Center) {
        let number = handle.grab.light;
        let Some(light) = app.lights.lights().get(number) else { continue };
        let rect = egui::Rect::from_center_size(handle.center, egui::Vec2::splat(2.0 * REACH));
        let response = ui.interact(rect, ui.scope_id().with(("handle", number)), egui::Sense::hover());
        let label = format!("Handle of {}", light_name(number, light));
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, &label));
    }
}

/// A part of a light on the screen that can be grabbed.
struct Handle {
    grab: Grab,
    center: Pos2,
    /// Start of the line to the handle.
    from: Pos2,
    color: Color32,
}

fn nearest(handles: &[Handle], pointer: Pos2) -> Option<&Handle> {
    // Of equally near handles, takes the one drawn last.
    let distances = handles.iter().rev().map(|handle| (handle, handle.center.distance(pointer)));
    distances
        .filter(|(_, distance)| *distance <= REACH)
        .min_by(|one, other| one.1.total_cmp(&other.1))
        .map(|(handle, _)| handle)
}

fn handles(app: &App, picture: &Projected) -> Vec<Handle> {
    let focus = app.focus();
    let mut handles = Vec::new();
    for (number, light) in app.lights.lights().iter().enumerate() {
        let position = position(&light.source, focus);
        let Some(on_screen) = picture.on_screen(position) else { continue };
        let handle = |part, center, color| Handle { grab: Grab { light: number, part }, center, from: center, color };
        let is_selected = app.lights.selected == Some(number);
        let center = handle(Part::Center, on_screen, tint(light.color));
        if is_selected && !matches!(light.source, LightSource::Directional { .. }) {
            let depth = (position - picture.camera.position).dot(picture.camera.forward);
            // Long enough to be grabbed at any depth.
            let length = picture.height_at(depth).unwrap_or(0.0) * AXIS / picture.rect.height();
            for (axis, (way, color)) in AXES.into_iter().enumerate() {
                if let Some(end) = picture.on_screen(position + way * length) {
                    handles.push(Handle { from: on_screen, ..handle(Part::Axis(axis), end, color) });
                }
            }
        }
        let aim = match light.source {
            LightSource::Spot { direction, .. } if is_selected => {
                picture.on_screen(position + direction * (0.25 * focus.size))
            }
            _ => None,
        };
        if let Some(aim) = aim {
            handles.push(Handle { from: on_screen, ..handle(Part::Target, aim, Color32::from_rgb(250, 220, 120)) });
        }
        let toward = match light.source {
            LightSource::Directional { .. } => picture.on_screen(focus.center).unwrap_or(on_screen),
            _ => on_screen,
        };
        handles.push(Handle { from: toward, ..center });
    }
    handles
}

/// World position of a light's handle; a sun's is beside the scene.
pub(super) fn position(source: &LightSource, Focus { center, size }: Focus) -> Vec3 {
    match *source {
        LightSource::Point { position } | LightSource::Spot { position, .. } => position,
        LightSource::Directional { direction } => center - direction * (0.5 * size),
    }
}

/// A light's colour, brightened to be visible.
pub(super) fn tint(color: Vec3) -> Color32 {
    let brightest = color.max_element().max(1e-6);
    let [red, green, blue] =
        (color / brightest).to_array().map(|level| (255.0 * (0.35 + 0.65 * level.clamp(0.0, 1.0))) as u8);
    Color32::from_rgb(red, green, blue)
}

fn drag(source: &mut LightSource, part: Part, picture: &Projected, pointer: Pos2, moved: egui::Vec2, focus: Focus) {
    let camera = picture.camera;
    let at = position(source, focus);
    let depth = (at - camera.position).dot(camera.forward);
    let Some(height) = picture.height_at(depth) else { return };
    let scale = height / picture.rect.height();
    let way = (camera.right * moved.x - camera.up * moved.y) * scale;
    match (source, part) {
        (LightSource::Point { position } | LightSource::Spot { position, .. }, Part::Center) => *position += way,
        (LightSource::Point { position } | LightSource::Spot { position, .. }, Part::Axis(axis)) => {
            let direction = AXES[axis].0;
            let (Some(from), Some(to)) =
                (picture.on_screen(*position), picture.on_screen(*position + direction * (scale * AXIS)))
            else {
                return;
            };
            let along = (to - from) / AXIS;
            // An axis that points at the camera moves nothing.
            if along.length_sq() > 0.01 {
                *position += direction * (moved.dot(along) / along.length_sq() * scale);
            }
        }
        (LightSource::Spot { position, direction, .. }, Part::Target) => {
            if let Some(turned) = unit(*direction * (0.25 * focus.size) + way) {
                *direction = turned;
            }
            debug_assert!(position.is_finite());
        }
        (LightSource::Directional { direction }, _) => {
            if let Some(turned) =
                on_sphere(picture, pointer, focus, *direction).and_then(|from| unit(focus.center - from))
            {
                *direction = turned;
            }
        }
        (LightSource::Point { .. }, Part::Target) => {}
    }
}

/// The point under the pointer on the sphere of the suns' handles, on the side of the sun's last position.
fn on_sphere(picture: &Projected, pointer: Pos2, Focus { center, size }: Focus, direction: Vec3) -> Option<Vec3> {
    let (origin, way) = picture.ray(pointer);
    let radius = 0.5 * size;
    let way = way.try_normalize()?;
    let offset = origin - center;
    let half = offset.dot(way);
    let below_root = half * half - offset.length_squared() + radius * radius;
    // Outside of the sphere, the nearest point of its outline.
    let root = below_root.max(0.0).sqrt();
    let was_near = -direction.dot(way) < 0.0;
    let t = if was_near { -half - root } else { -half + root };
    let point = origin + way * t;
    center.is_finite().then(|| center + (point - center).normalize_or(-direction) * radius)
}

fn draw(handles: &[Handle], selected: Option<usize>, hot: Option<Grab>, painter: &Painter) {
    for handle in handles {
        let is_hot = hot == Some(handle.grab);
        let is_selected = selected == Some(handle.grab.light);
        if handle.from != handle.center {
            painter
                .line_segment([handle.from, handle.center], Stroke::new(if is_hot { 3.0 } else { 1.5 }, handle.color));
        }
        let radius = match handle.grab.part {
            Part::Center => 7.0,
            Part::Axis(_) | Part::Target => 5.0,
        } + if is_hot { 2.0 } else { 0.0 };
        painter.circle(
            handle.center,
            radius,
            handle.color,
            Stroke::new(if is_selected { 2.0 } else { 1.0 }, Color32::BLACK),
        );
        if handle.grab.part == Part::Center {
            if is_selected {
                painter.circle_stroke(handle.center, radius + 2.0, Stroke::new(1.5, Color32::WHITE));
            }
            let label = handle.grab.light + 1;
            painter.text(
                handle.center + vec2(0.0, -16.0),
                Align2::CENTER_CENTER,
                label,
                FontId::proportional(11.0),
                Color32::WHITE,
            );
        }
    }
}
