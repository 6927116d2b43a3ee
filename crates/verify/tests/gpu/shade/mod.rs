//! The GPU's pictures against the CPU's, for made frames with all kinds of materials, lights and surroundings.
//! `frames.rs` compares frames of scenes.

mod compare;
mod develop;
mod made;
