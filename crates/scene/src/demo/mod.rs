//! The gallery: procedural scenes that move, the same on every machine.
//!
//! Each demo is one file with one type that has `SCENE`, `open`, `pose` and `duration_seconds`, and one line in
//! `gallery!` below.

mod build;

use crate::{Error, Frame};

/// A scene of the gallery, opened as `demo:NAME` or `demo:NAME?triangles=N`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DemoScene {
    /// What follows `demo:`.
    pub name: &'static str,
    /// What there is to see, in a few words.
    pub about: &'static str,
    /// How many triangles it has unless asked for another number.
    pub triangles: usize,
}

/// The enum of the demos and its dispatch, from one line for each.
macro_rules! gallery {
    ($($demo:ident => $module:ident::$type:ident,)*) => {
        /// Every scene of the gallery.
        pub const DEMOS: &[DemoScene] = &[$($module::$type::SCENE,)*];

        /// A procedural scene of the gallery.
        #[derive(Debug)]
        pub(crate) enum Demo {
            $($demo(Box<$module::$type>),)*
        }

        impl Demo {
            /// The demo called `name`, with about `triangles` triangles or as many as it usually has; `None` when
            /// there is no such demo.
            fn named(name: &str, triangles: Option<usize>) -> Option<Self> {
                $(if name == $module::$type::SCENE.name {
                    let triangles = triangles.unwrap_or($module::$type::SCENE.triangles);
                    return Some(Self::$demo(Box::new($module::$type::open(triangles))));
                })*
                None
            }

            /// Writes the scene at `seconds`, from 0 to [`Demo::duration_seconds`], into `frame`.
            pub(crate) fn pose(&self, seconds: f64, frame: &mut Frame) {
                match self {
                    $(Self::$demo(demo) => demo.pose(seconds, frame),)*
                }
            }

            /// How long the scene's animation takes before it starts again.
            pub(crate) fn duration_seconds(&self) -> f64 {
                match self {
                    $(Self::$demo(demo) => demo.duration_seconds(),)*
                }
            }
        }
    };
}

mod architecture;
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

gallery! {
    Cloth => cloth::Cloth,
    Marbles => marbles::Marbles,
    Shatter => shatter::Shatter,
    Statue => statue::Statue,
    Glass => glass::Glass,
    Forest => forest::Forest,
    Hall => hall::Hall,
    Stadium => stadium::Stadium,
}

/// The numbers of triangles that a demo can be asked for; what is beyond is brought to the nearer end.
const TRIANGLES: std::ops::RangeInclusive<usize> = 100..=20_000_000;

impl Demo {
    /// The demo that `NAME` or `NAME?triangles=N` means.
    ///
    /// # Errors
    /// Where there is no such demo or option, or `N` isn't a whole number above zero.
    pub(crate) fn open(address: &str) -> Result<Self, Error> {
        let full = || format!("demo:{address}");
        let (name, options) = address.split_once('?').map_or((address, None), |(name, options)| (name, Some(options)));
        if !DEMOS.iter().any(|demo| demo.name == name) {
            let names = DEMOS.iter().map(|demo| demo.name).collect::<Vec<_>>().join(", ");
            return Err(Error::address(full(), format!("there is no demo `{name}`; there are {names}")));
        }
        let mut triangles = None;
        for option in options.into_iter().flat_map(|options| options.split('&')) {
            let Some(number) = option.strip_prefix("triangles=") else {
                let cause = format!("there is no option `{option}`; write `{name}?triangles=N`");
                return Err(Error::address(full(), cause));
            };
            let count = number.parse::<usize>().ok().filter(|&count| count > 0).ok_or_else(|| {
                let cause = format!("`{number}` is no number of triangles; write a whole number such as 50000");
                Error::address(full(), cause)
            })?;
            triangles = Some(count.clamp(*TRIANGLES.start(), *TRIANGLES.end()));
        }
        Self::named(name, triangles).ok_or_else(|| Error::address(full(), format!("there is no demo `{name}`")))
    }
}
