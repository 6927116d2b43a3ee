//! The gallery: procedural scenes that move, the same on every machine.
//!
//! Each demo is one file with one type that has a `SCENE`, is [`Animated`] and stands in one line of [`DEMOS`].
#![forbid(unsafe_code)]

mod architecture;
mod build;
mod character;
mod cloth;
mod detail;
mod forest;
mod forest_paints;
mod furniture;
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
mod wind;

#[cfg(test)]
mod tests;

use umbrage_scene::{Animated, Error, Scene};

/// A scene of the gallery, opened as `demo:NAME` or `demo:NAME?triangles=N`.
#[derive(Clone, Copy, Debug)]
pub struct DemoScene {
    /// What follows `demo:`.
    pub name: &'static str,
    /// What there is to see, in a few words.
    pub about: &'static str,
    /// How many triangles it has unless asked for another number.
    pub triangles: usize,
    /// Makes it of about so many triangles.
    open: fn(usize) -> Box<dyn Animated>,
}

/// Every scene of the gallery.
pub const DEMOS: &[DemoScene] = &[
    cloth::Cloth::SCENE,
    marbles::Marbles::SCENE,
    shatter::Shatter::SCENE,
    statue::Statue::SCENE,
    glass::Glass::SCENE,
    forest::Forest::SCENE,
    hall::Hall::SCENE,
    stadium::Stadium::SCENE,
];

/// What the address of every demo begins with.
pub const PREFIX: &str = "demo:";

/// The numbers of triangles that a demo can be asked for; what is beyond is brought to the nearer end.
const TRIANGLES: std::ops::RangeInclusive<usize> = 100..=20_000_000;

/// Opens the demo that `address` means: `demo:NAME` or `demo:NAME?triangles=N`.
///
/// # Errors
/// Where there is no such demo or option, or `N` isn't a whole number above zero.
pub fn open(address: &str) -> Result<Scene, Error> {
    Scene::new(make(address)?)
}

/// As [`open`], before it becomes a scene.
fn make(full: &str) -> Result<Box<dyn Animated>, Error> {
    let error = |cause: String| Error::Address { address: full.to_owned(), cause };
    let address = full.strip_prefix(PREFIX).unwrap_or_default();
    let (name, options) = address.split_once('?').map_or((address, None), |(name, options)| (name, Some(options)));
    let demo = DEMOS.iter().find(|demo| demo.name == name).ok_or_else(|| {
        let names = DEMOS.iter().map(|demo| demo.name).collect::<Vec<_>>().join(", ");
        error(format!("there is no demo `{name}`; there are {names}"))
    })?;
    let mut triangles = demo.triangles;
    for option in options.into_iter().flat_map(|options| options.split('&')) {
        let Some(number) = option.strip_prefix("triangles=") else {
            return Err(error(format!("there is no option `{option}`; write `{name}?triangles=N`")));
        };
        let count = number.parse::<usize>().ok().filter(|&count| count > 0).ok_or_else(|| {
            error(format!("`{number}` is no number of triangles; write a whole number such as 50000"))
        })?;
        triangles = count.clamp(*TRIANGLES.start(), *TRIANGLES.end());
    }
    Ok((demo.open)(triangles))
}
