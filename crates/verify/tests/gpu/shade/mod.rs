//! The GPU's pictures against the CPU's, of made frames in which all kinds of materials, lights and surroundings are.
//! `gpu.rs` compares frames of scenes.

mod compare;
mod develop;
mod made;
