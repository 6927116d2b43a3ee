//! The window of `umbrage`: plays a scene with exact shadows, lets its lights be dragged, and shows where the time goes.
//!
//! [`view`] opens it. [`App`] is all of it but the window itself, for tests that press its buttons.
#![forbid(unsafe_code)]

mod app;
mod canvas;
mod choices;
mod coarseness;
mod command;
mod dialogs;
mod focus;
mod framing;
mod free_camera;
mod heat;
mod history;
mod interface;
mod light_grid;
mod light_list;
mod notices;
mod order;
mod pace;
mod probe;
mod projection;
mod recording;
mod show;
mod studio;
mod subject;
mod surface;
mod timeline;
mod watch;
mod window;
mod window_device;
mod worker;

pub use app::{App, Start};
pub use choices::EngineChoice;
pub use command::CommandLine;
pub use surface::Surface;
pub use window::{ViewError, view};
pub use window_device::Graphics;
