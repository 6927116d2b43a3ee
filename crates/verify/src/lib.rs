//! What the tests measure the other crates by: the oracle, test meshes and real scenes.
#![forbid(unsafe_code)]

mod forms;
mod meshes;
mod oracle;
mod random;
mod scenes;
mod sheet;

pub use forms::{Shot, Truth};
pub use meshes::TestMesh;
pub use oracle::Oracle;
pub use random::Random;
pub use scenes::real_scene;
pub use sheet::{Seams, Sheet, SheetShape};
