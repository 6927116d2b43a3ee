//! The window's textures, from which the picture is drawn.

use eframe::egui::{Color32, ColorImage, Context, TextureHandle, TextureId, TextureOptions};
use eframe::egui_wgpu::RenderState;
use umbrage::gpu::wgpu;

/// The picture's pixels, in memory or on a device.
pub(crate) enum Pixels {
    /// In rows from the upper left corner.
    Copied(Vec<Color32>),
    /// A texture on the window's device, sRGB-encoded in a linear format, as egui expects.
    OnDevice(wgpu::Texture),
    /// Already on the canvas.
    Shown,
}

/// Textures that the window draws, in reused memory.
#[derive(Default)]
pub(crate) struct Canvas {
    /// The window's graphics; `None` where only egui knows them.
    state: Option<RenderState>,
    copied: Option<TextureHandle>,
    on_device: Option<TextureId>,
}

impl Canvas {
    pub(crate) fn new(state: Option<RenderState>) -> Self {
        Self { state, ..Self::default() }
    }

    /// Takes over a picture, and returns the texture from which the window draws it until the next one.
    ///
    /// Returns `None` where the picture is on another device than the window's.
    pub(crate) fn show(&mut self, context: &Context, size: [usize; 2], pixels: Pixels) -> Option<TextureId> {
        match pixels {
            Pixels::Copied(pixels) => Some(self.show_copied(context, ColorImage::new(size, pixels))),
            Pixels::OnDevice(texture) => self.show_on_device(&texture),
            Pixels::Shown => self.copied.as_ref().map(TextureHandle::id),
        }
    }

    fn show_copied(&mut self, context: &Context, image: ColorImage) -> TextureId {
        match &mut self.copied {
            Some(texture) => texture.set(image, TextureOptions::NEAREST),
            None => self.copied = Some(context.load_texture("picture", image, TextureOptions::NEAREST)),
        }
        self.copied.as_ref().map_or(TextureId::default(), TextureHandle::id)
    }

    fn show_on_device(&mut self, texture: &wgpu::Texture) -> Option<TextureId> {
        let RenderState { device, renderer, .. } = self.state.as_ref()?;
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let (mut renderer, nearest) = (renderer.write(), wgpu::FilterMode::Nearest);
        match self.on_device {
            Some(id) => renderer.update_egui_texture_from_wgpu_texture(device, &view, nearest, id),
            None => self.on_device = Some(renderer.register_native_texture(device, &view, nearest)),
        }
        self.on_device
    }
}
