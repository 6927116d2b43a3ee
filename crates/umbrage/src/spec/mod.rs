//! Lights, cameras and backgrounds in words, as `umbrage render` takes them and its window writes them.
//!
//! Each type reads its words with `FromStr` and writes them with `Display`. Their meaning may depend on the scene:
//! [`LightSpec::light`] and [`BackgroundSpec::open`] find it. Coordinates are the world's, in f64:
//! [`WorldLookAt::local`] and [`LightSpec::local`] bring them to a scene's [origin](umbrage_scene::Scene::origin).

mod background;
mod camera;
mod color;
mod length;
mod light;

use std::fmt;

use glam::{DVec3, Vec3};

pub use background::BackgroundSpec;
pub use camera::{CameraSpec, LookAt, WorldLookAt};
pub use length::Length;
pub use light::{LightSpec, UnspeakableLight};

/// Three numbers with commas between them.
struct Words<T>([T; 3]);

impl<T: fmt::Display> fmt::Display for Words<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, z] = &self.0;
        write!(f, "{x},{y},{z}")
    }
}

/// The f64 with the same decimal digits as each f32, so that 0.1 stays 0.1.
fn widened(vector: Vec3) -> DVec3 {
    let widened = |number: f32| number.to_string().parse().unwrap_or(f64::from(number));
    DVec3::from(vector.to_array().map(widened))
}

/// A point of the world: numbers that are finite in f32 as well.
fn world_point(text: &str) -> Result<DVec3, String> {
    vector(text)?;
    let numbers = text.split(',').map(|number| number.trim().parse::<f64>().unwrap_or_default());
    Ok(numbers.zip(0..).fold(DVec3::ZERO, |mut point, (number, axis)| {
        point[axis] = number;
        point
    }))
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
