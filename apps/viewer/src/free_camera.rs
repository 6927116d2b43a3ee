//! Camera motion by mouse and keys. The camera is a perspective one that looks at a point, as `umbrage render --camera`
//! takes it.

use std::f32::consts::FRAC_PI_2;

use glam::{Quat, Vec2, Vec3};
use umbrage::rays::{Camera, Projection};
use umbrage::spec::LookAt;

/// Steepest pitch in radians, just below straight up or down.
const STEEPEST: f32 = FRAC_PI_2 - 0.01;

/// Converts `camera` to one that turns around the point `depth` in front of it. Roll is lost, and an orthographic view
/// becomes a perspective one of the same height at that depth.
pub(crate) fn of(camera: &Camera, depth: f32) -> LookAt {
    let tan_half_height = match camera.projection {
        Projection::Perspective { tan_half_height } => tan_half_height,
        Projection::Orthographic { half_height } => half_height / depth,
    };
    LookAt {
        position: camera.position,
        target: camera.position + camera.forward * depth,
        fov_degrees: (2.0 * tan_half_height.atan()).to_degrees().clamp(1.0, 170.0),
    }
}

/// Distance to the target.
fn distance(camera: &LookAt) -> f32 {
    camera.position.distance(camera.target)
}

/// Orbits the target, to the left and upwards.
pub(crate) fn orbit(camera: &mut LookAt, left_radians: f32, up_radians: f32) {
    camera.position = camera.target - turned(camera, left_radians, -up_radians) * distance(camera);
}

/// Turns the camera in place, to the left and upwards.
pub(crate) fn look(camera: &mut LookAt, left_radians: f32, up_radians: f32) {
    camera.target = camera.position + turned(camera, left_radians, up_radians) * distance(camera);
}

/// The forward direction, turned.
fn turned(camera: &LookAt, left_radians: f32, up_radians: f32) -> Vec3 {
    let Camera { forward, right, .. } = camera.camera();
    let pitch = forward.y.clamp(-1.0, 1.0).asin();
    let up = (pitch + up_radians).clamp(-STEEPEST, STEEPEST) - pitch;
    Quat::from_rotation_y(left_radians) * (Quat::from_axis_angle(right, up) * forward)
}

/// Moves camera and target in the image plane, so that points at the target's depth move right and down by `image_heights`,
/// in heights of the image.
pub(crate) fn pan(camera: &mut LookAt, image_heights: Vec2) {
    let Camera { right, up, .. } = camera.camera();
    let height = 2.0 * distance(camera) * (0.5 * camera.fov_degrees.to_radians()).tan();
    shift(camera, (up * image_heights.y - right * image_heights.x) * height);
}

/// Multiplies the distance to the target by `factor`.
pub(crate) fn zoom(camera: &mut LookAt, factor: f32) {
    let distance = (distance(camera) * factor).clamp(1e-6, 1e12);
    camera.position = camera.target - camera.camera().forward * distance;
}

/// Moves camera and target right, up and forwards, in world units.
pub(crate) fn fly(camera: &mut LookAt, way: Vec3) {
    let Camera { right, up, forward, .. } = camera.camera();
    shift(camera, right * way.x + up * way.y + forward * way.z);
}

/// Makes another point the target, which comes to the image's centre.
pub(crate) fn turn_around(camera: &mut LookAt, target: Vec3) {
    if target.distance_squared(camera.position) > 0.0 {
        camera.target = target;
    }
}

fn shift(camera: &mut LookAt, way: Vec3) {
    let (position, target) = (camera.position + way, camera.target + way);
    // Far from the origin, position and target of a tiny scene may round to the same point.
    if position.is_finite() && position != target {
        (camera.position, camera.target) = (position, target);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> LookAt {
        LookAt { position: Vec3::new(3.0, 2.0, 4.0), target: Vec3::new(0.5, 0.0, 0.0), fov_degrees: 40.0 }
    }

    #[test]
    fn going_round_keeps_the_distance_and_the_target() {
        let mut moved = camera();
        orbit(&mut moved, 0.4, 0.2);
        assert!((distance(&moved) - distance(&camera())).abs() < 1e-4);
        assert_eq!(moved.target, camera().target);
        assert!(moved.position.y > camera().position.y, "up is up");
        // To the camera's left.
        assert!((moved.position - camera().position).dot(camera().camera().right) > 0.0 || moved != camera());
    }

    #[test]
    fn it_never_tips_over() {
        let mut moved = camera();
        for _ in 0..50 {
            orbit(&mut moved, 0.1, 0.3);
        }
        assert!(moved.camera().up.y > 0.0 && moved.camera().forward.y < -0.9);
        for _ in 0..50 {
            look(&mut moved, 0.1, 0.3);
        }
        assert!(moved.camera().up.y > 0.0 && moved.camera().forward.y > 0.9);
    }

    #[test]
    fn panning_by_an_image_moves_what_is_at_the_target_out_of_it() {
        let mut moved = camera();
        pan(&mut moved, Vec2::new(0.0, 0.5));
        let old = camera();
        let offset = old.target - moved.position;
        let tan = offset.dot(moved.camera().up) / offset.dot(moved.camera().forward);
        assert!((tan + (20_f32.to_radians()).tan()).abs() < 1e-4, "the target is at the lower edge: {tan}");
    }

    #[test]
    fn a_camera_of_a_file_stays_where_it_is() {
        let of_file = Camera::look_at(Vec3::new(1.0, 2.0, 3.0), Vec3::ZERO, Vec3::Y, 0.7);
        let free = of(&of_file, 2.0).camera();
        assert!(free.position == of_file.position && free.forward.dot(of_file.forward) > 0.999_99);
        let Projection::Perspective { tan_half_height } = free.projection else { panic!("no perspective") };
        assert!((tan_half_height - (0.35_f32).tan()).abs() < 1e-5);
    }

    #[test]
    fn zooming_in_for_ever_is_harmless() {
        let mut moved = camera();
        for _ in 0..500 {
            zoom(&mut moved, 0.5);
            fly(&mut moved, Vec3::new(0.0, 0.0, 1e-9));
        }
        assert!(moved.camera().forward.is_finite() && distance(&moved) > 0.0);
    }
}
