//! The GPU poses vertices as the CPU does: positions bit for bit, normals and tangents but for rounding.

mod compare;
mod engine;
mod made;
mod posing;
mod scenes;
