//! Lights, cameras and backgrounds in words: what `umbrage render` takes and its window writes.
//!
//! Each type reads its words with `FromStr` and writes them with `Display`. What they mean may depend on the scene:
//! [`LightSpec::light`] and [`BackgroundSpec::open`] say what comes of them.

mod background;
mod camera;
mod color;
mod length;
mod light;

use std::fmt;

use glam::Vec3;

pub use background::BackgroundSpec;
pub use camera::{CameraSpec, LookAt};
pub use length::Length;
pub use light::{LightSpec, UnspeakableLight};

/// Three numbers with commas between them.
struct Words(Vec3);

impl fmt::Display for Words {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{},{},{}", self.0.x, self.0.y, self.0.z)
    }
}

/// A finite number.
fn number(text: &str) -> Result<f32, String> {
    let number = text.trim().parse::<f32>().ok().filter(|number| number.is_finite());
    number.ok_or_else(|| format!("`{text}` is not a number"))
}

/// Three finite numbers with commas between them.
fn vector(text: &str) -> Result<Vec3, String> {
    let parts = text.split(',').map(number).collect::<Result<Vec<f32>, String>>()?;
    match parts[..] {
        [x, y, z] => Ok(Vec3::new(x, y, z)),
        _ => Err(format!("`{text}` is not three numbers with commas between them")),
    }
}
