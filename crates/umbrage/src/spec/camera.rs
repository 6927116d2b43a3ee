use std::fmt;
use std::str::FromStr;

use glam::{DVec3, Vec3};
use umbrage_rays::Camera;

use super::{Words, number, widened, world_point};

/// Which camera sees a scene: `NAME`, `NUMBER` or `X,Y,Z:X,Y,Z[:FOV]`.
#[derive(Clone, Debug, PartialEq)]
pub enum CameraSpec {
    /// One of the scene's, by name or by number from 0.
    Listed(String),
    /// A new one.
    LookAt(WorldLookAt),
}

/// A perspective camera that looks at a point, the world's Y axis upwards, in the world's coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorldLookAt {
    /// Where it is.
    pub position: DVec3,
    /// The point that it looks at; another one.
    pub target: DVec3,
    /// Its vertical field of view, 0.01 to 179 degrees.
    pub fov_degrees: f32,
}

impl WorldLookAt {
    /// The camera from a scene's [origin](umbrage_scene::Scene::origin).
    #[must_use]
    pub fn local(&self, origin: [f64; 3]) -> LookAt {
        let local = |point: DVec3| (point - DVec3::from(origin)).as_vec3();
        let Self { position, target, fov_degrees } = *self;
        LookAt { position: local(position), target: local(target), fov_degrees }
    }
}

/// A [`WorldLookAt`] whose points count from a scene's origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LookAt {
    /// Where it is.
    pub position: Vec3,
    /// The point that it looks at; another one.
    pub target: Vec3,
    /// Its vertical field of view, 0.01 to 179 degrees.
    pub fov_degrees: f32,
}

impl LookAt {
    /// The default field of view.
    pub const DEFAULT_FOV_DEGREES: f32 = 40.0;

    /// The camera in the world's coordinates, inverse of [`WorldLookAt::local`].
    #[must_use]
    pub fn in_world(&self, origin: [f64; 3]) -> WorldLookAt {
        let world = |point: Vec3| widened(point) + DVec3::from(origin);
        let Self { position, target, fov_degrees } = *self;
        WorldLookAt { position: world(position), target: world(target), fov_degrees }
    }

    /// The camera itself.
    #[must_use]
    pub fn camera(&self) -> Camera {
        Camera::look_at(self.position, self.target, Vec3::Y, self.fov_degrees.to_radians())
    }
}

impl fmt::Display for CameraSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Listed(name) => f.write_str(name),
            Self::LookAt(WorldLookAt { position, target, fov_degrees }) => {
                write!(f, "{}:{}:{fov_degrees}", Words(position.to_array()), Words(target.to_array()))
            }
        }
    }
}

impl FromStr for CameraSpec {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts: Vec<&str> = text.split(':').collect();
        let numeric = text.starts_with(|first: char| first.is_ascii_digit() || "+-.".contains(first));
        if !(numeric && text.contains(',')) {
            return Ok(Self::Listed(text.to_owned()));
        }
        let (position, target, fov) = match parts[..] {
            [position, target] => (position, target, None),
            [position, target, fov] => (position, target, Some(fov)),
            [position] if world_point(position).is_ok() => {
                return Err(format!("a camera needs a point to look at as well, such as {position}:0,0,0"));
            }
            _ => return Err("give a camera as X,Y,Z:X,Y,Z or X,Y,Z:X,Y,Z:FOV".to_owned()),
        };
        let (position, target) = (world_point(position)?, world_point(target)?);
        if position == target {
            return Err("the camera is where it looks at; move one of the two points".to_owned());
        }
        let fov_degrees = fov.map_or(Ok(LookAt::DEFAULT_FOV_DEGREES), number)?;
        if !(0.01..=179.0).contains(&fov_degrees) {
            return Err("a field of view is from 0.01 to 179 degrees".to_owned());
        }
        Ok(Self::LookAt(WorldLookAt { position, target, fov_degrees }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cameras_are_listed_or_placed() {
        assert_eq!("Main, left".parse(), Ok(CameraSpec::Listed("Main, left".to_owned())));
        assert_eq!("0".parse(), Ok(CameraSpec::Listed("0".to_owned())));
        let look_at = WorldLookAt { position: DVec3::new(0.0, 1.0, 5.0), target: DVec3::ZERO, fov_degrees: 60.0 };
        assert_eq!("0,1,5:0,0,0:60".parse(), Ok(CameraSpec::LookAt(look_at)));
        let spec = CameraSpec::LookAt(WorldLookAt { target: DVec3::new(500_000.123, -2.0, 1e-7), ..look_at });
        assert_eq!(spec.to_string().parse(), Ok(spec));
        for text in
            ["0,1,5", "0,1:0,0,0", "0,1,5:0,0,0:0", "0,1,5:0,0,0:200", "1,1,1:1,1,1", "0,1,x:0,0,0", "0,nan,1:0,0,0"]
        {
            assert!(text.parse::<CameraSpec>().is_err(), "{text}");
        }
    }
    #[test]
    fn cameras_far_away_are_near_the_origin_of_their_scene() {
        let CameraSpec::LookAt(world) = "500000.25,4649776.5,3:500000,4649776,0".parse().unwrap() else { panic!() };
        let local = world.local([500_000.0, 4_649_776.0, 0.0]);
        assert_eq!((local.position, local.target), (Vec3::new(0.25, 0.5, 3.0), Vec3::ZERO));
        assert_eq!(local.in_world([500_000.0, 4_649_776.0, 0.0]), world);
        // Numbers of f32 have as few digits as before.
        let near = LookAt { position: Vec3::splat(0.1), target: Vec3::ZERO, fov_degrees: 40.0 };
        assert_eq!(CameraSpec::LookAt(near.in_world([0.0; 3])).to_string(), "0.1,0.1,0.1:0,0,0:40");
        assert_eq!(near.in_world([0.0; 3]).local([0.0; 3]), near);
    }
}
