//! The GPU's shading against the CPU's, of what the CPU engine sees: made frames, in which all kinds of materials, lights
//! and surroundings are. `gpu.rs` compares whole frames of scenes.

mod compare;
mod made;
