use bytemuck::{Pod, Zeroable};
use umbrage_rays::{Camera, Projection, View};

use umbrage_gpu::wgpu;

use super::link;
use umbrage_gpu::{Buffer, Geometry, Gpu, GpuError, Recorder};

/// The stage `raster`: the triangle at each pixel's centre, by rasterisation with a depth test.
#[derive(Debug)]
pub(super) struct Raster {
    pipeline: wgpu::RenderPipeline,
    layout: wgpu::BindGroupLayout,
    view: Buffer,
    /// Triangles and depths of an image's pixels.
    textures: Option<[wgpu::Texture; 2]>,
    /// Each pixel's triangle plus one, row after row.
    seen: Buffer,
}

/// Uniform of `raster.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct KdRaster {
    position: [f32; 3],
    half_width: f32,
    right: [f32; 3],
    half_height: f32,
    up: [f32; 3],
    near: f32,
    forward: [f32; 3],
    far: f32,
}

impl KdRaster {
    /// `reach` is the scene's largest coordinate.
    fn new(view: &View, reach: f32) -> Self {
        let Camera { position, right, up, forward, projection } = view.camera;
        let aspect = view.width as f32 / view.height as f32;
        let (half_height, far) = match projection {
            Projection::Perspective { tan_half_height } => (tan_half_height, 0.0),
            Projection::Orthographic { half_height } => (half_height, 2.0 * (reach + position.length())),
        };
        // Floating-point depth is as exact near by as far away, so a near plane costs nothing but the triangles before it.
        let near = reach.max(f32::MIN_POSITIVE) / f32::from(1_u16 << 15);
        Self {
            position: position.to_array(),
            half_width: half_height * aspect,
            right: right.to_array(),
            half_height,
            up: up.to_array(),
            near,
            forward: forward.to_array(),
            far,
        }
    }
}

const IDS: wgpu::TextureFormat = wgpu::TextureFormat::R32Uint;
const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

impl Raster {
    pub(super) fn new(gpu: &Gpu) -> Self {
        let device = &gpu.device;
        let text = link("kdtree::raster");
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("raster"),
            source: wgpu::ShaderSource::Wgsl(text.into()),
        });
        let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::VERTEX,
            ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
            count: None,
        };
        let storage = wgpu::BufferBindingType::Storage { read_only: true };
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("raster"),
            entries: &[entry(0, wgpu::BufferBindingType::Uniform), entry(1, storage), entry(2, storage)],
        });
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("raster"),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("raster"),
            layout: Some(&pipeline_layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("raster_vertex"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[],
            },
            // Triangles have two sides.
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: Some(wgpu::DepthStencilState {
                format: DEPTH,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::Greater),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("raster_fragment"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(IDS.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        Self {
            pipeline,
            layout,
            view: Buffer::uniform(gpu, "view to rasterise"),
            textures: None,
            seen: Buffer::storage(gpu, "rasterised triangles"),
        }
    }

    /// Bytes of a row of [`Raster::seen`].
    pub(super) fn row_bytes(width: u32) -> u32 {
        (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT)
    }

    pub(super) fn prepare(&mut self, gpu: &Gpu, view: &View, reach: f32) -> Result<(), GpuError> {
        let limit = gpu.device.limits().max_texture_dimension_2d;
        let View { width, height, .. } = *view;
        if width.max(height) > limit {
            return Err(GpuError::PictureTooLarge { width, height, limit });
        }
        self.view.write(gpu, &[KdRaster::new(view, reach)])?;
        self.seen.reserve(gpu, u64::from(Self::row_bytes(width)) * u64::from(height))?;
        let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
        if self.textures.as_ref().is_none_or(|[ids, _]| ids.size() != size) {
            let texture = |label, format, usage| {
                gpu.device.create_texture(&wgpu::TextureDescriptor {
                    label: Some(label),
                    size,
                    mip_level_count: 1,
                    sample_count: 1,
                    dimension: wgpu::TextureDimension::D2,
                    format,
                    usage: wgpu::TextureUsages::RENDER_ATTACHMENT | usage,
                    view_formats: &[],
                })
            };
            let ids = texture("rasterised triangles", IDS, wgpu::TextureUsages::COPY_SRC);
            self.textures = Some([ids, texture("rasterised depth", DEPTH, wgpu::TextureUsages::empty())]);
        }
        Ok(())
    }

    /// # Panics
    /// If it wasn't prepared.
    pub(super) fn record(&self, gpu: &Gpu, recorder: &mut Recorder<'_>, geometry: &Geometry) {
        let [ids, depth] = self.textures.as_ref().expect("prepared");
        let buffers = [&self.view, geometry.triangles(), geometry.positions()];
        let entries: Vec<_> = buffers
            .iter()
            .zip(0..)
            .map(|(buffer, binding)| wgpu::BindGroupEntry { binding, resource: buffer.raw().as_entire_binding() })
            .collect();
        let bind_group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("raster"),
            layout: &self.layout,
            entries: &entries,
        });
        let views = [ids, depth].map(|texture| texture.create_view(&wgpu::TextureViewDescriptor::default()));
        let (encoder, queries) = recorder.begin_stage("raster");
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("raster"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &views[0],
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &views[1],
                // The nearest is the largest.
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Discard }),
                stencil_ops: None,
            }),
            timestamp_writes: queries.map(|(query_set, first)| wgpu::RenderPassTimestampWrites {
                query_set,
                beginning_of_pass_write_index: Some(first),
                end_of_pass_write_index: Some(first + 1),
            }),
            ..Default::default()
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &bind_group, &[]);
        pass.draw(0..3 * geometry.triangle_count(), 0..1);
        drop(pass);
        let bytes_per_row = Some(Self::row_bytes(ids.width()));
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row, rows_per_image: None };
        let to = wgpu::TexelCopyBufferInfo { buffer: self.seen.raw(), layout };
        encoder.copy_texture_to_buffer(ids.as_image_copy(), to, ids.size());
    }

    pub(super) fn seen(&self) -> &Buffer {
        &self.seen
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::{differences, layout, module};

    #[test]
    fn the_view_is_that_of_the_shader() {
        let layout = layout!(KdRaster { position, half_width, right, half_height, up, near, forward, far });
        assert_eq!(differences(&module(&link("kdtree::raster")), &layout), [""; 0]);
    }
}
