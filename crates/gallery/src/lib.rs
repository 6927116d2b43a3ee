//! The gallery: procedural scenes that move, the same on every machine.
//!
//! Each demo is one file with a `SCENE`, which is one line of [`DEMOS`], and a function that opens it: it makes the
//! still parts, and returns the function that poses the demo.
#![forbid(unsafe_code)]

mod architecture;
mod build;
mod character;
mod cloth;
mod forest;
mod forest_paints;
mod furniture;
mod gears;
mod glade;
mod glass;
mod hall;
mod hall_paints;
mod marbles;
mod plant;
mod sculpture;
mod shatter;
mod stadium;
mod statue;
mod studio;
mod sweep;
mod trophy;

#[cfg(test)]
mod tests;

use std::fmt;

use umbrage_scene::{Animated, Error, Frame, Scene};

/// A scene of the gallery, opened as `demo:NAME` or `demo:NAME?triangles=N`.
#[derive(Clone, Copy, Debug)]
pub struct DemoScene {
    /// Name after `demo:` in its address.
    pub name: &'static str,
    /// A short description.
    pub about: &'static str,
    /// Default number of triangles.
    pub triangles: usize,
    /// Duration of a cycle.
    seconds: f32,
    /// The moment that shows it best.
    still_seconds: f32,
    /// Makes it, of about this many triangles.
    open: fn(usize) -> Pose,
}

/// Writes the surfaces of a moment into a frame, and adds its lights and its camera.
type Pose = Box<dyn Fn(Moment, &mut Frame) + Send + Sync>;

/// A moment of a demo.
#[derive(Clone, Copy, Debug)]
struct Moment {
    /// Seconds since the start.
    seconds: f32,
    /// From 0 at the start to 1 at the end.
    part: f32,
}

/// A demo that is open.
struct Demo {
    scene: &'static DemoScene,
    pose: Pose,
}

impl Animated for Demo {
    fn duration_seconds(&self) -> f64 {
        f64::from(self.scene.seconds)
    }

    fn still_seconds(&self) -> f64 {
        f64::from(self.scene.still_seconds)
    }

    fn pose(&self, seconds: f64, frame: &mut Frame) -> Result<(), Error> {
        (self.pose)(Moment { seconds: seconds as f32, part: (seconds / self.duration_seconds()) as f32 }, frame);
        Ok(())
    }
}

impl fmt::Debug for Demo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Demo").field(self.scene).finish()
    }
}

/// Every scene of the gallery.
pub const DEMOS: &[DemoScene] = &[
    cloth::SCENE,
    marbles::SCENE,
    shatter::SCENE,
    statue::SCENE,
    glass::SCENE,
    forest::SCENE,
    hall::SCENE,
    stadium::SCENE,
    gears::SCENE,
];

/// Prefix of every demo's address.
pub const PREFIX: &str = "demo:";

/// Range of the number of triangles; numbers outside are clamped.
const TRIANGLES: std::ops::RangeInclusive<usize> = 100..=20_000_000;

/// Opens the demo of `address`: `demo:NAME` or `demo:NAME?triangles=N`.
///
/// # Errors
/// If there is no such demo or option, or `N` isn't a whole number above zero.
pub fn open(address: &str) -> Result<Scene, Error> {
    Scene::new(Box::new(make(address)?))
}

/// As [`open`], before it becomes a scene.
fn make(full: &str) -> Result<Demo, Error> {
    let error = |cause: String| Error::Address { address: full.to_owned(), cause };
    let address = full.strip_prefix(PREFIX).unwrap_or_default();
    let (name, options) = address.split_once('?').map_or((address, None), |(name, options)| (name, Some(options)));
    let scene = DEMOS.iter().find(|demo| demo.name == name).ok_or_else(|| {
        let names = DEMOS.iter().map(|demo| demo.name).collect::<Vec<_>>().join(", ");
        error(format!("there is no demo `{name}`; there are {names}"))
    })?;
    let mut triangles = scene.triangles;
    for option in options.into_iter().flat_map(|options| options.split('&')) {
        let Some(number) = option.strip_prefix("triangles=") else {
            return Err(error(format!("there is no option `{option}`; write `{name}?triangles=N`")));
        };
        let count = number.parse::<usize>().ok().filter(|&count| count > 0).ok_or_else(|| {
            error(format!("`{number}` is no number of triangles; write a whole number such as 50000"))
        })?;
        triangles = count.clamp(*TRIANGLES.start(), *TRIANGLES.end());
    }
    Ok(Demo { scene, pose: (scene.open)(triangles) })
}
