use crate::link::{link, link_text};
use crate::{Buffer, Gpu};

/// One entry point of a shader, ready to run.
#[derive(Debug)]
pub struct Kernel {
    name: &'static str,
    pipeline: wgpu::ComputePipeline,
    layout: wgpu::BindGroupLayout,
}

/// How many workgroups run.
#[derive(Clone, Copy, Debug)]
pub enum Groups<'a> {
    /// So many, in as many rows as the device needs; shaders get their place from `flat_group`.
    Flat(u32),
    /// So many, in rows as above, for each of so many layers.
    Layers(u32, u32),
    /// As the three u32 say that start at a word of a buffer.
    Indirect(&'a Buffer, u32),
}

impl Kernel {
    /// The entry point `entry` of the crate's module `path`, with values for its `override` constants.
    #[must_use]
    pub fn new(gpu: &Gpu, path: &str, entry: &'static str, constants: &[(&str, f64)]) -> Self {
        Self::of_linked(gpu, &link(path), entry, constants)
    }

    /// The entry point `entry` of a shader that isn't the crate's own but may import its modules.
    #[must_use]
    pub fn of_text(gpu: &Gpu, text: &str, entry: &'static str, constants: &[(&str, f64)]) -> Self {
        Self::of_linked(gpu, &link_text(text), entry, constants)
    }

    fn of_linked(gpu: &Gpu, text: &str, entry: &'static str, constants: &[(&str, f64)]) -> Self {
        let device = &gpu.device;
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(entry),
            source: wgpu::ShaderSource::Wgsl(text.into()),
        });
        let entries: Vec<_> = bindings(text).into_iter().map(layout_entry).collect();
        let layout =
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(entry), entries: &entries });
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(entry),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(entry),
            layout: Some(&pipeline_layout),
            module: &module,
            entry_point: Some(entry),
            compilation_options: wgpu::PipelineCompilationOptions { constants, ..Default::default() },
            cache: None,
        });
        Self { name: entry, pipeline, layout }
    }

    /// Runs over `buffers`, which stand in the order of the shader's bindings.
    ///
    /// # Panics
    /// If the kernel has another number of bindings.
    pub fn dispatch(&self, gpu: &Gpu, pass: &mut wgpu::ComputePass<'_>, buffers: &[&Buffer], groups: Groups<'_>) {
        let entries: Vec<_> = buffers
            .iter()
            .enumerate()
            .map(|(place, buffer)| wgpu::BindGroupEntry {
                binding: place as u32,
                resource: buffer.raw().as_entire_binding(),
            })
            .collect();
        let bind_group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(self.name),
            layout: &self.layout,
            entries: &entries,
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &bind_group, &[]);
        match groups {
            Groups::Flat(count) => dispatch_layers(gpu, pass, count, 1),
            Groups::Layers(count, layers) => dispatch_layers(gpu, pass, count, layers),
            Groups::Indirect(counts, word) => pass.dispatch_workgroups_indirect(counts.raw(), u64::from(word) * 4),
        }
    }
}

fn dispatch_layers(gpu: &Gpu, pass: &mut wgpu::ComputePass<'_>, count: u32, layers: u32) {
    if count > 0 {
        let rows = count.div_ceil(gpu.device.limits().max_compute_workgroups_per_dimension);
        pass.dispatch_workgroups(count.div_ceil(rows), rows, layers);
    }
}

/// How a shader sees a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Access {
    Uniform,
    Read,
    ReadWrite,
}

/// The number and access of each binding that a shader's text declares, all in group 0.
fn bindings(text: &str) -> Vec<(u32, Access)> {
    let declared = text.lines().filter_map(|line| line.strip_prefix("@group(0) @binding("));
    declared
        .filter_map(|line| {
            let (number, rest) = line.split_once(')')?;
            let access = if rest.contains("var<uniform>") {
                Access::Uniform
            } else if rest.contains("var<storage, read>") {
                Access::Read
            } else {
                Access::ReadWrite
            };
            Some((number.parse().ok()?, access))
        })
        .collect()
}

fn layout_entry((binding, access): (u32, Access)) -> wgpu::BindGroupLayoutEntry {
    let ty = match access {
        Access::Uniform => wgpu::BufferBindingType::Uniform,
        Access::Read => wgpu::BufferBindingType::Storage { read_only: true },
        Access::ReadWrite => wgpu::BufferBindingType::Storage { read_only: false },
    };
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
        count: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bindings_are_read_from_the_text() {
        let text = "@group(0) @binding(0) var<uniform> a: A;\n\
                    @group(0) @binding(1) var<storage, read> b: array<u32>;\n\
                    fn f() {}\n\
                    @group(0) @binding(2) var<storage, read_write> c: array<atomic<u32>>;";
        assert_eq!(bindings(text), [(0, Access::Uniform), (1, Access::Read), (2, Access::ReadWrite)]);
    }
}
