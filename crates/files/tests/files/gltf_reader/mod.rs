//! The glTF reader against hand-computed values and broken files.

mod animation;
mod broken;
mod compressed;
mod extensions;
mod layers;
mod look;
mod mesh;
mod pose;
mod rig;
mod tangents;
