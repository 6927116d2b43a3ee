//! Where the picture is drawn from: a texture of the window's.

use eframe::egui::{Color32, ColorImage, Context, TextureHandle, TextureId, TextureOptions};
use eframe::egui_wgpu::RenderState;
use umbrage::gpu::wgpu;

/// The picture's pixels, wherever they are.
pub(crate) enum Pixels {
    /// In rows from the upper left corner.
    Copied(Vec<Color32>),
    /// A texture of the device that the window draws with, sRGB-encoded but not marked so, as egui takes it.
    OnDevice(wgpu::Texture),
    /// The canvas has them.
    Shown,
}

/// Textures that the window draws, in memory that is used again.
#[derive(Default)]
pub(crate) struct Canvas {
    /// What the window draws with; `None` where only egui knows.
    state: Option<RenderState>,
    copied: Option<TextureHandle>,
    on_device: Option<TextureId>,
}

impl Canvas {
    pub(crate) fn new(state: Option<RenderState>) -> Self {
        Self { state, ..Self::default() }
    }

    /// Takes over a picture. What the window draws it from, until there is another.
    ///
    /// `None` where a picture is on a device that the window doesn't draw with.
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
