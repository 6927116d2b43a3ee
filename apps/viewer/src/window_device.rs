//! The graphics device: which one the window draws with, and whether the GPU engine works on it too.

use std::sync::Arc;

use eframe::egui_wgpu::{RenderState, WgpuConfiguration, WgpuSetup, WgpuSetupCreateNew};
use umbrage::gpu::{Adapter, DeviceLimits, Gpu, GpuError, wgpu};

use crate::surface::Surface;

/// The environment variable that stands for [`Graphics::shares_software`] where it is `1`.
const SHARE_DEVICE: &str = "UMBRAGE_SHARE_DEVICE";

/// What a window is drawn with.
#[derive(Clone)]
pub struct Graphics {
    /// Egui's renderer and its device.
    pub state: RenderState,
    /// Whether the GPU engine works on this device even where that is a program on the CPU. Then the window waits for
    /// whatever the engine does, so this is for tests.
    pub shares_software: bool,
    /// What the window is drawn on.
    pub surface: Surface,
}

impl Graphics {
    /// How the window's device is opened, so that an engine that is called so can work on it, if its adapter can draw windows.
    /// `surface` is told where there is nothing to draw on.
    #[must_use]
    pub fn configuration(engine: &str, surface: Surface) -> WgpuConfiguration {
        let mut setup = WgpuSetupCreateNew::without_display_handle();
        setup.instance_descriptor.flags = Gpu::instance_flags();
        let engine = engine.to_lowercase();
        setup.native_adapter_selector = Some(Arc::new(move |adapters, surface| {
            let can_draw =
                |adapter: &&wgpu::Adapter| surface.is_none_or(|surface| adapter.is_surface_supported(surface));
            let chosen =
                adapters.iter().filter(can_draw).min_by_key(|adapter| preference(&Adapter::of(adapter), &engine));
            chosen.cloned().ok_or_else(|| "no graphics adapter can draw on this display".to_owned())
        }));
        let by_default = Arc::clone(&setup.device_descriptor);
        setup.device_descriptor = Arc::new(move |adapter| {
            // An adapter that the engine can't use may still draw the window.
            Gpu::descriptor(adapter, DeviceLimits::Adapter).unwrap_or_else(|_| by_default(adapter))
        });
        WgpuConfiguration {
            wgpu_setup: WgpuSetup::CreateNew(setup),
            on_surface_status: Arc::new(move |status| surface.answer(status)),
            ..WgpuConfiguration::default()
        }
    }

    /// Those of a window, as the environment wants them shared: `UMBRAGE_SHARE_DEVICE=1` means
    /// [`Graphics::shares_software`].
    #[must_use]
    pub fn new(state: RenderState, surface: Surface) -> Self {
        let shares_software = std::env::var_os(SHARE_DEVICE).is_some_and(|value| value == "1");
        Self { state, shares_software, surface }
    }
}

/// The device that the window draws with, for an engine that works on it as well.
#[derive(Clone)]
pub(crate) struct WindowDevice {
    adapter: wgpu::Adapter,
    device: wgpu::Device,
    queue: wgpu::Queue,
}

impl WindowDevice {
    /// The device of a window, where it is to be shared.
    pub(crate) fn of(graphics: &Graphics) -> Option<Self> {
        let RenderState { adapter, device, queue, .. } = &graphics.state;
        let is_of_use = graphics.shares_software || !Adapter::of(adapter).is_software;
        is_of_use.then(|| Self { adapter: adapter.clone(), device: device.clone(), queue: queue.clone() })
    }

    /// The device as an engine's, where the adapter of that name is this one's; `None` where it is another's, or where the
    /// device can't do what the engine needs.
    ///
    /// # Errors
    /// Where there is no adapter of that name.
    pub(crate) fn gpu(&self, name: &str) -> Result<Option<Gpu>, GpuError> {
        if Adapter::find(name)? != Adapter::of(&self.adapter) {
            return Ok(None);
        }
        Ok(Gpu::of_device(&self.adapter, self.device.clone(), self.queue.clone()).ok())
    }
}

/// Lower for what is preferred: GPUs before software, as the engine does; of each kind what is called so.
fn preference(adapter: &Adapter, engine: &str) -> (bool, bool) {
    (adapter.is_software, !adapter.name.to_lowercase().contains(engine))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_engines_adapter_is_preferred_but_never_software_to_a_gpu() {
        let adapter = |name: &str, is_software| Adapter {
            name: name.to_owned(),
            driver: String::new(),
            backend: "Vulkan".to_owned(),
            is_software,
        };
        let [soft, small, large] = [adapter("soft", true), adapter("Small", false), adapter("Large", false)];
        let chosen = |engine: &str| {
            let all = [&soft, &small, &large];
            all.into_iter().min_by_key(|adapter| preference(adapter, engine)).expect("one of them").name.clone()
        };
        assert_eq!(["", "small", "large", "soft"].map(chosen), ["Small", "Small", "Large", "Small"]);
    }
}
