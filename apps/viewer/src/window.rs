//! The window.

use eframe::egui::{ViewportBuilder, vec2};

use crate::app::{App, Start};
use crate::choices::EngineChoice;
use crate::surface::Surface;
use crate::window_device::Graphics;

/// The error that no window could be opened.
#[derive(Debug, thiserror::Error)]
#[error("no window could be opened: {0}")]
pub struct ViewError(String);

/// Opens the window and returns once it is closed.
///
/// Where the GPU engine's adapter draws the window as well, both share one device, and pictures stay on it. On a software
/// adapter each has its own device and pictures are copied, since in one queue the window would wait for the engine.
/// `UMBRAGE_SHARE_DEVICE=1` in the environment shares it there too, for tests.
///
/// # Errors
/// Where there is no display, or no graphics adapter that can draw on it.
pub fn view(start: Start) -> Result<(), ViewError> {
    let engine = match &start.engine {
        Some(EngineChoice::Gpu(name)) => name.as_str(),
        Some(EngineChoice::Cpu) | None => "",
    };
    let surface = Surface::default();
    let options = eframe::NativeOptions {
        wgpu_options: Graphics::configuration(engine, surface.clone()),
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
        Box::new(|creation| {
            let graphics = creation.wgpu_render_state.clone().map(|state| Graphics::new(state, surface));
            Ok(Box::new(App::new(&creation.egui_ctx, start, creation.storage, graphics)))
        }),
    );
    made.map_err(|error| ViewError(error.to_string()))
}
