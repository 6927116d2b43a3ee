use glam::Vec3;
use umbrage::scene::{Frame, Light};
use umbrage::{CameraChoice, Scene, Settings};

use crate::failure::Failure;
use crate::job::Job;
use crate::lights::orbited;
use crate::values::CameraFlag;

/// Puts the cameras and lights of the command line in place, moment by moment.
pub(crate) struct Staging {
    settings: Settings,
    orbit_light: bool,
    /// The middle of the scene over its whole animation.
    center: Vec3,
    /// The scene at the last moment, in memory that is used again.
    frame: Frame,
}

impl Staging {
    /// # Errors
    /// Where the scene can't be posed or lacks the camera.
    pub(crate) fn new(job: &Job, scene: &Scene, first_seconds: f64) -> Result<Self, Failure> {
        let mut frame = Frame::default();
        let mut settings = job.settings.clone();
        let listed = match &job.camera {
            Some(CameraFlag::Listed(name)) => Some(name),
            Some(CameraFlag::Placed(camera)) => {
                settings.camera = (*camera).into();
                None
            }
            None => None,
        };
        // The frame says which cameras there are, and where the scene is.
        if listed.is_some() || job.orbit_light || !job.lights.is_empty() {
            scene.pose(first_seconds, &mut frame)?;
        }
        let center = frame.animation_bounds.center();
        if !job.lights.is_empty() {
            settings.lights = Some(job.lights.iter().map(|light| light.light(center)).collect());
        }
        if let Some(name) = listed {
            settings.camera = CameraChoice::Scene(listed_camera(&frame, name)?);
        }
        Ok(Self { settings, orbit_light: job.orbit_light, center, frame })
    }

    /// The settings for a moment; `turn` says how far an orbiting light has come, 1 being once round.
    ///
    /// # Errors
    /// Where the scene can't be posed.
    pub(crate) fn settings(&mut self, scene: &Scene, seconds: f64, turn: f64) -> Result<Settings, Failure> {
        let mut settings = self.settings.clone();
        let own_lights = self.orbit_light && settings.lights.is_none();
        if own_lights {
            scene.pose(seconds, &mut self.frame)?;
        }
        if self.orbit_light {
            let mut lights: Vec<Light> = settings.lights.take().unwrap_or_else(|| self.frame.lights.clone());
            if let Some(first) = lights.first_mut() {
                first.source = orbited(first.source, self.center, turn);
            }
            settings.lights = Some(lights);
        }
        Ok(settings)
    }
}

/// The place of the camera with this name, or else this number.
pub(crate) fn listed_camera(frame: &Frame, name: &str) -> Result<usize, Failure> {
    let cameras = &frame.cameras;
    let named = cameras.iter().position(|camera| &*camera.name == name);
    let numbered = || name.parse().ok().filter(|&number: &usize| number < cameras.len());
    named.or_else(numbered).ok_or_else(|| {
        let listed: Vec<String> =
            cameras.iter().enumerate().map(|(number, camera)| format!("{number} `{}`", camera.name)).collect();
        let hint = if listed.is_empty() {
            "the scene has no camera; give one as X,Y,Z:X,Y,Z[:FOV]".to_owned()
        } else {
            format!("the scene has {}", listed.join(", "))
        };
        Failure::input(format!("--camera: the scene has no camera `{name}`"), hint)
    })
}

#[cfg(test)]
mod tests {
    use umbrage::rays::Camera;
    use umbrage::scene::NamedCamera;

    use super::*;

    #[test]
    fn cameras_are_found_by_name_before_number() {
        let camera = Camera::look_at(Vec3::Z, Vec3::ZERO, Vec3::Y, 1.0);
        let named = |name: &str| NamedCamera { name: name.into(), camera };
        let frame = Frame { cameras: vec![named("1"), named("left"), named("")], ..Frame::default() };
        assert_eq!(listed_camera(&frame, "1").unwrap(), 0);
        assert_eq!(listed_camera(&frame, "left").unwrap(), 1);
        assert_eq!(listed_camera(&frame, "2").unwrap(), 2);
        let Failure::Input { message, hint } = listed_camera(&frame, "3").unwrap_err() else { panic!() };
        assert!(message.contains("no camera `3`") && hint.unwrap().contains("1 `left`"));
    }
}
