use std::collections::BTreeSet;
use std::str::FromStr;

use glam::{Quat, Vec3};
use umbrage::rays::LightSource;
use umbrage::scene::{Frame, Light, LightShape, NamedCamera};
use umbrage::spec::{CameraSpec, Length, LightSpec};
use umbrage::{CameraChoice, Scene, Settings};

use crate::failure::Failure;
use crate::flags::RenderFlags;
use crate::job::{Job, with_lengths};

/// The cameras and lights of the command line, moment by moment.
pub(crate) struct Staging {
    settings: Settings,
    orbiting: Option<OrbitingLights>,
    /// The middle of the scene over its whole animation.
    center: Vec3,
    /// The scene at the last moment, in reused memory.
    frame: Frame,
}

impl Staging {
    /// # Errors
    /// Where the scene can't be posed, lacks the camera, or has no size although a length is a share of it.
    pub(crate) fn new(job: &Job, scene: &Scene, first_seconds: f64) -> Result<Self, Failure> {
        let mut frame = Frame::default();
        let size = scene.size();
        check_shares(&job.flags, size)?;
        let mut settings = with_lengths(job.settings.clone(), &job.flags, size);
        // The frame has the scene's cameras, lights and bounds.
        if matches!(job.flags.camera, Some(CameraSpec::Listed(_)))
            || job.flags.orbit_light.is_some()
            || !job.flags.lights.is_empty()
            || job.flags.light_radius.is_share()
        {
            scene.pose(first_seconds, &mut frame)?;
        }
        settings.camera = camera_choice(job.flags.camera.as_ref(), &frame.cameras, scene.origin())?;
        let center = frame.animation_bounds.center();
        if !job.flags.lights.is_empty() {
            let lights = job.flags.lights.iter().map(|light| light.local(scene.origin()).light(center, size));
            settings.lights = Some(lights.collect());
        }
        let mut lights = settings.lights.as_ref().unwrap_or(&frame.lights).iter();
        let is_bare_sun =
            |light: &Light| matches!(light.source, LightSource::Directional { .. }) && light.shape == LightShape::POINT;
        if job.flags.light_radius.is_share() && lights.any(is_bare_sun) {
            let message = format!("--light-radius {}: a sun's radius is no share of the scene", job.flags.light_radius);
            return Err(Failure::input(message, "give it in degrees, such as --light-radius 0.27"));
        }
        Ok(Self { settings, orbiting: job.flags.orbit_light.clone(), center, frame })
    }

    /// The settings for a moment; `turn` is the angle of orbiting lights, in turns.
    ///
    /// # Errors
    /// Where the scene can't be posed, or lacks a light that is to orbit.
    pub(crate) fn settings(&mut self, scene: &Scene, seconds: f64, turn: f64) -> Result<Settings, Failure> {
        let mut settings = self.settings.clone();
        let Some(orbiting) = &self.orbiting else { return Ok(settings) };
        let mut lights: Vec<Light> = match settings.lights.take() {
            Some(lights) => lights,
            None => {
                scene.pose(seconds, &mut self.frame)?;
                self.frame.lights.clone()
            }
        };
        for number in orbiting.numbers(lights.len())? {
            lights[number].source = orbited(lights[number].source, self.center, turn);
        }
        settings.lights = Some(lights);
        Ok(settings)
    }
}

/// Checks that the scene has a size, if any length is a share of it.
fn check_shares(flags: &RenderFlags, size: f32) -> Result<(), Failure> {
    let lengths = [Some(flags.aperture), flags.focus, Some(flags.light_radius), Some(flags.ambient_occlusion)];
    let is_asked = lengths.into_iter().flatten().any(Length::is_share) || flags.lights.iter().any(LightSpec::is_share);
    match is_asked && size <= 0.0 {
        true => Err(Failure::input("the scene has no size of which a length could be a share", "give world units")),
        false => Ok(()),
    }
}

/// The lights that `--orbit-light` moves.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum OrbitingLights {
    First,
    All,
    Numbered(Vec<usize>),
}

impl FromStr for OrbitingLights {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        match text {
            "first" => Ok(Self::First),
            "all" => Ok(Self::All),
            list => {
                let numbers: Result<BTreeSet<usize>, _> = list.split(',').map(|number| number.trim().parse()).collect();
                let numbers = numbers.map_err(|_| "`first`, `all` or numbers from 0 are needed, such as 0,2")?;
                Ok(Self::Numbered(numbers.into_iter().collect()))
            }
        }
    }
}

impl OrbitingLights {
    /// The indices of moving lights among `count`; none if there are no lights.
    ///
    /// # Errors
    /// Where a numbered light isn't there.
    fn numbers(&self, count: usize) -> Result<Vec<usize>, Failure> {
        match self {
            Self::First => Ok((0..count.min(1)).collect()),
            Self::All => Ok((0..count).collect()),
            Self::Numbered(numbers) => match numbers.iter().find(|&&number| number >= count) {
                None => Ok(numbers.clone()),
                Some(missing) => {
                    let hint = match count {
                        0 => "the scene has no light; give one with --light".to_owned(),
                        1 => "the scene has one light, number 0".to_owned(),
                        _ => format!("the scene has {count} lights, numbers 0 to {}", count - 1),
                    };
                    Err(Failure::input(format!("--orbit-light: the scene has no light {missing}"), hint))
                }
            },
        }
    }
}

/// The source, rotated about the vertical axis through `center` by `turn` turns.
fn orbited(source: LightSource, center: Vec3, turn: f64) -> LightSource {
    let rotation = Quat::from_rotation_y((turn.fract() * std::f64::consts::TAU) as f32);
    let moved = |position: Vec3| center + rotation * (position - center);
    let turned = |direction: Vec3| (rotation * direction).normalize();
    match source {
        LightSource::Point { position } => LightSource::Point { position: moved(position) },
        LightSource::Spot { position, direction, inner_radians, outer_radians } => {
            LightSource::Spot { position: moved(position), direction: turned(direction), inner_radians, outer_radians }
        }
        LightSource::Directional { direction } => LightSource::Directional { direction: turned(direction) },
    }
}

/// The camera of a flag, from the scene's `origin`; among its `cameras` by name, or else by number.
pub(crate) fn camera_choice(
    flag: Option<&CameraSpec>,
    cameras: &[NamedCamera],
    origin: [f64; 3],
) -> Result<CameraChoice, Failure> {
    let name = match flag {
        None => return Ok(CameraChoice::Default),
        Some(CameraSpec::LookAt(look_at)) => return Ok(look_at.local(origin).camera().into()),
        Some(CameraSpec::Listed(name)) => name,
    };
    let named = cameras.iter().position(|camera| *camera.name == **name);
    let numbered = || name.parse().ok().filter(|&number: &usize| number < cameras.len());
    named.or_else(numbered).map(CameraChoice::Scene).ok_or_else(|| {
        let listed = cameras.iter().enumerate().map(|(number, camera)| match &*camera.name {
            "" => format!("{number} (without a name)"),
            name => format!("{number} `{name}`"),
        });
        let listed = listed.collect::<Vec<_>>().join(", ");
        let hint = match cameras.len() {
            0 => "the scene has no camera; give one as X,Y,Z:X,Y,Z[:FOV]".to_owned(),
            1 => format!("the scene has one camera: {listed}"),
            count => format!("the scene has {count} cameras: {listed}"),
        };
        Failure::input(format!("--camera: the scene has no camera `{name}`"), hint)
    })
}

#[cfg(test)]
mod tests {
    use umbrage::rays::Camera;

    use super::*;

    #[test]
    fn cameras_are_found_by_name_before_number() {
        let camera = Camera::look_at(Vec3::Z, Vec3::ZERO, Vec3::Y, 1.0);
        let named = |name: &str| NamedCamera { name: name.into(), camera };
        let cameras = [named("1"), named("left"), named("")];
        let chosen = |name: &str| camera_choice(Some(&CameraSpec::Listed(name.to_owned())), &cameras, [0.0; 3]);
        for (name, number) in [("1", 0), ("left", 1), ("2", 2)] {
            assert_eq!(chosen(name).unwrap(), CameraChoice::Scene(number));
        }
        let Failure::Input { message, hint } = chosen("3").unwrap_err() else { panic!() };
        assert!(message.contains("no camera `3`"));
        assert_eq!(hint.unwrap(), "the scene has 3 cameras: 0 `1`, 1 `left`, 2 (without a name)");
        let alone = camera_choice(Some(&CameraSpec::Listed("9".to_owned())), &cameras[2..], [0.0; 3]);
        let Failure::Input { hint, .. } = alone.unwrap_err() else { panic!() };
        assert_eq!(hint.unwrap(), "the scene has one camera: 0 (without a name)");
    }

    #[test]
    fn lights_that_orbit_are_the_first_all_or_numbered() {
        let parsed = |text: &str| text.parse::<OrbitingLights>();
        for (text, numbers) in [("first", vec![0]), ("all", vec![0, 1, 2]), ("2,0,2", vec![0, 2])] {
            assert_eq!(parsed(text).unwrap().numbers(3).unwrap(), numbers);
        }
        assert!(OrbitingLights::First.numbers(0).unwrap().is_empty());
        let Failure::Input { message, hint } = parsed("1,3").unwrap().numbers(3).unwrap_err() else { panic!() };
        assert!(message.contains("no light 3") && hint.unwrap().contains("0 to 2"));
        assert!(parsed("").is_err() && parsed("-1").is_err() && parsed("both").is_err());
    }

    #[test]
    fn a_quarter_of_an_orbit_turns_x_to_minus_z() {
        let center = Vec3::new(1.0, 0.0, 0.0);
        let LightSource::Point { position } =
            orbited(LightSource::Point { position: Vec3::new(3.0, 5.0, 0.0) }, center, 0.25)
        else {
            panic!("not a point")
        };
        assert!(position.abs_diff_eq(Vec3::new(1.0, 5.0, -2.0), 1e-5), "{position}");
    }
}
