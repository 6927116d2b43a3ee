use std::fmt;
use std::str::FromStr;

use glam::Vec3;
use umbrage_rays::Camera;

use super::{Words, number, vector};

/// Which camera sees a scene: `NAME`, `NUMBER` or `X,Y,Z:X,Y,Z[:FOV]`.
#[derive(Clone, Debug, PartialEq)]
pub enum CameraSpec {
    /// One of the scene's, by name or by number from 0.
    Listed(String),
    /// A new one.
    LookAt(LookAt),
}

/// A perspective camera that looks at a point, the world's Y axis upwards.
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
    /// The field of view where nobody says which.
    pub const DEFAULT_FOV_DEGREES: f32 = 40.0;

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
            Self::LookAt(LookAt { position, target, fov_degrees }) => {
                write!(f, "{}:{}:{fov_degrees}", Words(*position), Words(*target))
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
            [position] if vector(position).is_ok() => {
                return Err(format!("a camera needs a point to look at as well, such as {position}:0,0,0"));
            }
            _ => return Err("give a camera as X,Y,Z:X,Y,Z or X,Y,Z:X,Y,Z:FOV".to_owned()),
        };
        let (position, target) = (vector(position)?, vector(target)?);
        if position == target {
            return Err("the camera is where it looks at; move one of the two points".to_owned());
        }
        let fov_degrees = fov.map_or(Ok(LookAt::DEFAULT_FOV_DEGREES), number)?;
        if !(0.01..=179.0).contains(&fov_degrees) {
            return Err("a field of view is from 0.01 to 179 degrees".to_owned());
        }
        Ok(Self::LookAt(LookAt { position, target, fov_degrees }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cameras_are_listed_or_placed() {
        assert_eq!("Main, left".parse(), Ok(CameraSpec::Listed("Main, left".to_owned())));
        assert_eq!("0".parse(), Ok(CameraSpec::Listed("0".to_owned())));
        let look_at = LookAt { position: Vec3::new(0.0, 1.0, 5.0), target: Vec3::ZERO, fov_degrees: 60.0 };
        assert_eq!("0,1,5:0,0,0:60".parse(), Ok(CameraSpec::LookAt(look_at)));
        let spec = CameraSpec::LookAt(LookAt { target: Vec3::new(0.1, -2.0, 1e-7), ..look_at });
        assert_eq!(spec.to_string().parse(), Ok(spec));
        for text in
            ["0,1,5", "0,1:0,0,0", "0,1,5:0,0,0:0", "0,1,5:0,0,0:200", "1,1,1:1,1,1", "0,1,x:0,0,0", "0,nan,1:0,0,0"]
        {
            assert!(text.parse::<CameraSpec>().is_err(), "{text}");
        }
    }
}
