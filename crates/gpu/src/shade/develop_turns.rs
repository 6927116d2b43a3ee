use crate::memory::Taken;
use crate::{Gpu, GpuError, platform};

/// Pictures as two alternating textures: one is shown while the next is made.
#[derive(Debug, Default)]
pub struct Turns {
    pictures: [Option<Picture>; 2],
    /// Index of the texture that is made next.
    next: usize,
}

#[derive(Debug)]
struct Picture {
    texture: wgpu::Texture,
    taken: Taken,
}

impl Turns {
    /// The format of the textures. Their values are already sRGB-encoded.
    pub const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

    /// The next texture to make, in this size. The one before it stays unchanged.
    ///
    /// # Errors
    /// If the device has no textures of that size, or no room for one.
    pub fn next(&mut self, gpu: &Gpu, size: [u32; 2]) -> Result<wgpu::Texture, GpuError> {
        let picture_slot = &mut self.pictures[self.next];
        let is_new = picture_slot.as_ref().is_none_or(|old| [old.texture.width(), old.texture.height()] != size);
        if is_new {
            // Released first: there may be no room for both. A caller that still draws it holds it.
            *picture_slot = None;
            *picture_slot = Some(Picture::new(gpu, size)?);
        }
        let picture = picture_slot.as_ref().map(|picture| picture.texture.clone());
        picture.ok_or_else(|| GpuError::OutOfMemory("a picture".to_owned()))
    }

    /// Ends a texture: the other one is next.
    pub fn turn(&mut self) {
        self.next = 1 - self.next;
    }

    /// Bytes of both.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.pictures.iter().flatten().map(|picture| picture.taken.bytes()).sum()
    }
}

impl Picture {
    fn new(gpu: &Gpu, [width, height]: [u32; 2]) -> Result<Self, GpuError> {
        let limit = gpu.device.limits().max_texture_dimension_2d;
        if width.max(height) > limit {
            return Err(GpuError::PictureTooLarge { width, height, limit });
        }
        let bytes = u64::from(width) * u64::from(height) * 4;
        let refused = || {
            let others = gpu.memory.taken();
            GpuError::OutOfMemory(format!("a picture needs {bytes} bytes, beside {others} bytes of everything else"))
        };
        let taken = gpu.memory.take(bytes).ok_or_else(refused)?;
        let memory = gpu.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("picture"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: Turns::FORMAT,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        if platform::is_refused(memory) { Err(refused()) } else { Ok(Self { texture, taken }) }
    }
}
