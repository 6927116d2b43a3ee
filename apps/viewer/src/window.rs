//! The window itself.

use eframe::egui::{ViewportBuilder, vec2};

use crate::app::{App, Start};

/// Why there is no window.
#[derive(Debug, thiserror::Error)]
#[error("no window could be opened: {0}")]
pub struct ViewError(String);

/// Opens the window and returns once it is closed.
///
/// # Errors
/// Where there is no display, or no graphics adapter that can draw on it.
pub fn view(start: Start) -> Result<(), ViewError> {
    let options = eframe::NativeOptions {
        viewport: ViewportBuilder::default()
            .with_app_id("umbrage")
            .with_title("Umbrage")
            .with_inner_size(vec2(1280.0, 800.0))
            .with_min_inner_size(vec2(480.0, 320.0)),
        persist_window: !start.forgets,
        ..Default::default()
    };
    let made = eframe::run_native(
        "umbrage",
        options,
        Box::new(|creation| Ok(Box::new(App::new(&creation.egui_ctx, start, creation.storage)))),
    );
    made.map_err(|error| ViewError(error.to_string()))
}
