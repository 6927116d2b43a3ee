//! Experiments on the CPU, as one program; those on the GPU are in `gpu`.

#[path = "../../../rays/tests/rays/support/mod.rs"]
mod support;
mod triangle_tests;
