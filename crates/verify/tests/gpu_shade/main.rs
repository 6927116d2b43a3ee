//! The GPU's shading against the CPU's, of what the CPU engine sees: scenes as they are.

mod compare;
mod made;
mod scenes;
