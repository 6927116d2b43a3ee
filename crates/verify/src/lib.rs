//! Tools of the other crates' tests: the oracle, test meshes with cameras and lights, and real scenes.
#![forbid(unsafe_code)]

mod case;
mod differences;
pub mod lights;
mod meshes;
mod oracle;
mod plates;
mod random;
pub mod referee;
mod scenes;
mod seam_trial;
mod sheet;
pub mod structures;
pub mod views;

pub use case::{Case, MIXED_SIDES, Truth, stops_light};
pub use differences::Differences;
pub use meshes::{TestMesh, meshes_in_bad_places};
pub use oracle::Oracle;
pub use plates::Plates;
pub use random::Random;
pub use scenes::real_scene;
pub use seam_trial::SeamTrial;
pub use sheet::{Seams, Sheet, SheetShape};
