//! The window's graphics device, which the GPU engine may share.

use std::sync::Arc;

use eframe::egui_wgpu::{RenderState, WgpuConfiguration, WgpuSetup, WgpuSetupCreateNew};
use umbrage::gpu::{Adapter, DeviceLimits, Gpu, GpuError, wgpu};

use crate::surface::Surface;

/// The environment variable that sets [`Graphics::shares_software`] if it is `1`.
const SHARE_DEVICE: &str = "UMBRAGE_SHARE_DEVICE";

/// The graphics of a window.
#[derive(Clone)]
pub struct Graphics {
    /// egui's renderer and its device.
    pub state: RenderState,
    /// Whether the GPU engine shares this device even on a software adapter. The window then waits for the engine, so this
    /// is for tests.
    pub shares_software: bool,
    /// The window's surface.
    pub surface: Surface,
}

impl Graphics {
    /// The configuration of the window's device. The GPU engine of the adapter `engine` can share it, if that adapter can
    /// draw windows. Errors of drawing are reported to `surface`.
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

    /// The graphics of a window. `UMBRAGE_SHARE_DEVICE=1` in the environment sets [`Graphics::shares_software`].
    #[must_use]
    pub fn new(state: RenderState, surface: Surface) -> Self {
        let shares_software = std::env::var_os(SHARE_DEVICE).is_some_and(|value| value == "1");
        Self { state, shares_software, surface }
    }
}

/// The window's device, for an engine that shares it.
#[derive(Clone)]
pub(crate) struct WindowDevice {
    adapter: wgpu::Adapter,
    device: wgpu::Device,
    queue: wgpu::Queue,
}

impl WindowDevice {
    /// The device of a window, where it may be shared.
    pub(crate) fn of(graphics: &Graphics) -> Option<Self> {
        let RenderState { adapter, device, queue, .. } = &graphics.state;
        let is_of_use = graphics.shares_software || !Adapter::of(adapter).is_software;
        is_of_use.then(|| Self { adapter: adapter.clone(), device: device.clone(), queue: queue.clone() })
    }

    /// The engine's view of this device, if adapter `name` is this device's; `None` for another adapter, or if the device
    /// lacks a feature that the engine needs.
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

/// Sort key, lower for preferred adapters: GPUs before software, as in the engine; within each kind those with a
/// matching name.
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
