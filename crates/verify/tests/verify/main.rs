//! Tests of the CPU engine, as one program; those of the GPU engine are in `gpu`.

mod copies;
mod exposure;
mod files_scenes;
mod flat;
mod fuzz;
mod glass;
mod gloss;
mod gltf_scenes;
mod ground;
mod layers;
mod made_light;
mod marks;
mod matrix;
mod mirrors;
mod moving;
mod origin;
mod papers;
mod predicate;
mod referee;
mod render;
mod seams;
mod sides;
mod steady;
mod terminator;
mod textures;
mod watertight;
