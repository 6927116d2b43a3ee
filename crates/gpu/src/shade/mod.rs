//! The shade stage: computes each pixel's radiance as the CPU engine does, and sums it in a film that stays on the GPU
//! until it is developed.

mod develop;
mod develop_turns;
mod film;
#[cfg(test)]
mod layout;
mod shown;
mod stage;
mod tables;
mod texels;

pub use develop::{Develop, ToneMap};
pub use develop_turns::Turns;
pub use film::{FilmKeeps, FilmPlanes};
pub use shown::Shown;
pub use stage::{Attributes, Layer, Moving, Shade, ShadeInputs};
pub use tables::{ShadeLayers, ShadeLight, ShadeMaterial, ShadeSample, ShadeScene, ShadeSurroundings, ShadeTexture};
pub use texels::Texels;
