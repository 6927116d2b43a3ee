//! The layers that a film has beside its colours.

use std::fmt;
use std::str::FromStr;

use umbrage_rays::{Choice, UnknownChoice, choices};

/// Data that a [`Film`](crate::Film) can have beside its colours, in [`FilmLayers`](crate::FilmLayers).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layer {
    /// The part of each pixel that each light reaches.
    Shadow,
    /// The motion of each pixel's hit, in pixels.
    Motion,
    /// The hit's position in its triangle.
    Barycentric,
    /// The ids of the object and the triangle.
    Ids,
    /// The part of each pixel that each object covers.
    Cryptomatte,
}

choices! { Layer, "layer":
    "shadow" => Shadow, "how much of each pixel each light reaches: shadow.NAME";
    "motion" => Motion, "how far what is seen moves until the next frame, in pixels: motion.X, motion.Y";
    "barycentric" => Barycentric, "where in its triangle what is seen is: barycentric.u, barycentric.v";
    "ids" => Ids, "numbers of objects and triangles: ids.object, ids.triangle";
    "cryptomatte" => Cryptomatte, "objects' mattes by their names, which compositing programs pick: CryptoObject";
}

/// A set of [`Layer`]s; without any, a film is only the picture, its depths, normals and triangles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Layers(u8);

impl Layers {
    /// None of them.
    pub const NONE: Self = Self(0);

    /// The name of all of them together.
    pub const ALL: &str = "all";

    /// Every layer that there is.
    #[must_use]
    pub fn all() -> Self {
        Layer::all().collect()
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(self) -> bool {
        self == Self::NONE
    }

    /// Whether `layer` is one of them.
    #[must_use]
    pub fn has(self, layer: Layer) -> bool {
        self.0 & Self::from(layer).0 != 0
    }
}

impl From<Layer> for Layers {
    fn from(layer: Layer) -> Self {
        Self(1 << layer as u8)
    }
}

impl FromIterator<Layer> for Layers {
    fn from_iter<I: IntoIterator<Item = Layer>>(layers: I) -> Self {
        layers.into_iter().fold(Self::NONE, |all, layer| Self(all.0 | Self::from(layer).0))
    }
}

impl FromStr for Layers {
    type Err = UnknownChoice;

    /// Reads names with commas between them, or `all`.
    fn from_str(text: &str) -> Result<Self, UnknownChoice> {
        if text == Self::ALL {
            return Ok(Self::all());
        }
        let named = |name: &str| {
            let known = Layer::names().into_iter().map(|(name, _)| name).chain([Self::ALL]);
            Layer::named(name.trim()).map_err(|_| UnknownChoice::new(Layer::OPTION, name, known))
        };
        text.split(',').map(named).collect()
    }
}

impl fmt::Display for Layers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<&str> = Layer::all().filter(|&layer| self.has(layer)).map(Layer::name).collect();
        f.pad(&names.join(","))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_of_names_are_sets() {
        let some: Layers = "shadow,ids".parse().unwrap();
        assert!(some.has(Layer::Shadow) && some.has(Layer::Ids) && !some.has(Layer::Motion) && !some.is_empty());
        assert_eq!("ids, shadow,ids".parse(), Ok(some));
        assert_eq!(some.to_string(), "shadow,ids");
        let all: Layers = "all".parse().unwrap();
        assert!(Layer::all().all(|layer| all.has(layer)) && all == all.to_string().parse().unwrap());
        assert!(Layers::default().is_empty());
        for wrong in ["", "shadow,", "shadows", "shadow,all"] {
            let refused = wrong.parse::<Layers>().unwrap_err().to_string();
            assert!(refused.contains("cryptomatte, all"), "{refused}");
        }
    }
}
