//! What the tests measure the other crates by.
#![forbid(unsafe_code)]

mod scenes;

pub use scenes::real_scene;
