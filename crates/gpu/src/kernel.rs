use std::cell::OnceCell;
use std::collections::VecDeque;
use std::sync::{Mutex, PoisonError};

use crate::link::{link, link_text, link_with, shared_constants};
#[cfg(feature = "operations")]
use crate::operations::Counter;
use crate::pipelines::{EntryPoint, Pipeline};
use crate::{Buffer, Gpu};

/// One entry point of a shader, ready to run. A device compiles it once, for all of its kernels.
#[derive(Debug)]
pub struct Kernel {
    name: &'static str,
    pipeline: wgpu::ComputePipeline,
    layout: wgpu::BindGroupLayout,
    /// Bind groups of its last lists of buffers, the most recent at the end: frames bring the same lists again.
    bound: Mutex<VecDeque<Bound>>,
    /// Counter of the kernel's operations.
    #[cfg(feature = "operations")]
    counter: Option<Counter>,
}

/// Buffers in the order of a shader's bindings.
#[derive(Debug)]
struct Bound {
    buffers: Vec<wgpu::Buffer>,
    group: wgpu::BindGroup,
}

/// Number of bind groups that a kernel keeps: kernels that run for each light have a list of buffers for each.
const MOST_BOUND: usize = 16;

shared_constants! { "dispatch":
    /// Workgroups of a row.
    GROUPS_OF_ROW: u32 = 1 << 10;
}

/// Number of workgroups of a dispatch.
#[derive(Clone, Copy, Debug)]
pub enum Groups<'a> {
    /// This many, in rows, the last of which may have more; shaders get their number from `flat_group`.
    Flat(u32),
    /// The size is read from three u32 of a buffer, from this word on.
    Indirect(&'a Buffer, u32),
}

impl Kernel {
    /// The entry point `entry` of the crate's module `path`, with values for its `override` constants.
    #[must_use]
    pub fn new(gpu: &Gpu, path: &str, entry: &'static str, constants: &[(&str, f64)]) -> Self {
        let [kernel] = Self::all(gpu, path, [entry], constants);
        kernel
    }

    /// Several entry points of the crate's module `path`, with values for its `override` constants.
    pub(crate) fn all<const N: usize>(
        gpu: &Gpu,
        path: &str,
        entries: [&'static str; N],
        constants: &[(&str, f64)],
    ) -> [Self; N] {
        Self::of_root(gpu, path, path, || link(path), entries, constants)
    }

    /// The entry point `entry` of the module `path`, with values for its `override` constants. `modules` are those beside
    /// the crate's, pairs of a path and a text; paths name modules for a device, so each belongs to one text.
    ///
    /// # Panics
    /// If the shader isn't valid, or imports an item that doesn't exist.
    #[must_use]
    pub fn of_modules(
        gpu: &Gpu,
        modules: &[(&str, &str)],
        path: &str,
        entry: &'static str,
        constants: &[(&str, f64)],
    ) -> Self {
        let [kernel] = Self::of_root(gpu, path, path, || link_with(modules, path), [entry], constants);
        kernel
    }

    /// The entry point `entry` of a shader outside of this crate, which may import the crate's modules.
    ///
    /// # Panics
    /// If the shader isn't valid, or imports an item that doesn't exist.
    #[must_use]
    pub fn of_text(gpu: &Gpu, text: &str, entry: &'static str, constants: &[(&str, f64)]) -> Self {
        let [kernel] = Self::of_root(gpu, "text", text, || link_text(text), [entry], constants);
        kernel
    }

    /// Entry points of the shader `root`. `link` joins it with its modules, unless all entry points are compiled already.
    fn of_root<const N: usize>(
        gpu: &Gpu,
        label: &str,
        root: &str,
        link: impl Fn() -> String,
        entries: [&'static str; N],
        constants: &[(&str, f64)],
    ) -> [Self; N] {
        let shader = OnceCell::new();
        entries.map(|name| {
            let Pipeline { pipeline, layouts } = gpu.pipelines.get(EntryPoint::new(root, name, constants), || {
                shader.get_or_init(|| Shader::new(gpu, label, &link())).compile(gpu, name, constants)
            });
            Self {
                name,
                pipeline,
                layout: layouts[0].clone(),
                bound: Mutex::default(),
                #[cfg(feature = "operations")]
                counter: layouts.get(1).map(|layout| Counter::new(gpu, format!("{label}::{name}"), layout)),
            }
        })
    }

    /// Runs over `buffers`, in the order of the shader's bindings.
    ///
    /// # Panics
    /// If the kernel has another number of bindings.
    pub fn dispatch(&self, gpu: &Gpu, pass: &mut wgpu::ComputePass<'_>, buffers: &[&Buffer], groups: Groups<'_>) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.bind(gpu, buffers), &[]);
        #[cfg(feature = "operations")]
        if let Some(counter) = &self.counter {
            counter.bind(gpu, pass);
        }
        match groups {
            Groups::Flat(0) => {}
            Groups::Flat(count) => {
                pass.dispatch_workgroups(count.min(GROUPS_OF_ROW), count.div_ceil(GROUPS_OF_ROW), 1);
            }
            Groups::Indirect(counts, word) => pass.dispatch_workgroups_indirect(counts.raw(), u64::from(word) * 4),
        }
    }

    /// The bind group of these buffers.
    fn bind(&self, gpu: &Gpu, buffers: &[&Buffer]) -> wgpu::BindGroup {
        // No code panics while it holds the lock.
        let mut bound = self.bound.lock().unwrap_or_else(PoisonError::into_inner);
        let is_same = |of: &Bound| of.buffers.iter().eq(buffers.iter().map(|buffer| buffer.raw()));
        if let Some(index) = bound.iter().position(is_same)
            && let Some(same) = bound.remove(index)
        {
            let group = same.group.clone();
            bound.push_back(same);
            return group;
        }
        let entries = buffers
            .iter()
            .zip(0..)
            .map(|(buffer, binding)| wgpu::BindGroupEntry { binding, resource: buffer.raw().as_entire_binding() });
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(self.name),
            layout: &self.layout,
            entries: &entries.collect::<Vec<_>>(),
        });
        if bound.len() == MOST_BOUND {
            bound.pop_front();
        }
        let buffers = buffers.iter().map(|buffer| buffer.raw().clone()).collect();
        bound.push_back(Bound { buffers, group: group.clone() });
        group
    }
}

/// A linked shader, whose entry points can be compiled.
#[derive(Debug)]
struct Shader {
    module: wgpu::ShaderModule,
    /// The bindings of each group.
    layouts: Vec<wgpu::BindGroupLayout>,
    pipeline_layout: wgpu::PipelineLayout,
}

impl Shader {
    fn new(gpu: &Gpu, label: &str, text: &str) -> Self {
        let device = &gpu.device;
        let label = Some(label);
        let (read, source) = source(gpu, text);
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label, source });
        let layouts = layouts(&read).map(|entries| {
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label, entries: &entries })
        });
        let layouts: Vec<_> = layouts.collect();
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label,
            bind_group_layouts: &layouts.iter().map(Some).collect::<Vec<_>>(),
            immediate_size: 0,
        });
        Self { module, layouts, pipeline_layout }
    }

    fn compile(&self, gpu: &Gpu, entry: &'static str, constants: &[(&str, f64)]) -> Pipeline {
        let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(entry),
            layout: Some(&self.pipeline_layout),
            module: &self.module,
            entry_point: Some(entry),
            compilation_options: wgpu::PipelineCompilationOptions { constants, ..Default::default() },
            cache: None,
        });
        Pipeline { pipeline, layouts: self.layouts.clone() }
    }
}

/// The shader to compile, and its naga module for the bindings.
#[cfg_attr(not(feature = "operations"), expect(unused_variables, reason = "only counting devices have another"))]
fn source<'a>(gpu: &Gpu, text: &'a str) -> (naga::Module, wgpu::ShaderSource<'a>) {
    #[cfg(feature = "operations")]
    if let Some(module) = gpu.operations.instrumented(text) {
        return (module.clone(), wgpu::ShaderSource::Naga(std::borrow::Cow::Owned(module)));
    }
    let read = naga::front::wgsl::parse_str(text).unwrap_or_else(|error| panic!("{}", error.emit_to_string(text)));
    (read, wgpu::ShaderSource::Wgsl(text.into()))
}

/// The bindings that a shader declares in each group: all are in group 0, except those of counters.
fn layouts(module: &naga::Module) -> impl Iterator<Item = Vec<wgpu::BindGroupLayoutEntry>> {
    let declared =
        || module.global_variables.iter().filter_map(|(_, variable)| variable.binding.zip(Some(variable.space)));
    let last = declared().map(|(resource, _)| resource.group).max().unwrap_or(0);
    let entry = |(resource, space): (naga::ResourceBinding, _)| wgpu::BindGroupLayoutEntry {
        binding: resource.binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer {
            ty: match space {
                naga::AddressSpace::Storage { access } => {
                    wgpu::BufferBindingType::Storage { read_only: !access.contains(naga::StorageAccess::STORE) }
                }
                _ => wgpu::BufferBindingType::Uniform,
            },
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    };
    (0..=last).map(move |group| declared().filter(|(resource, _)| resource.group == group).map(entry).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use wgpu::BufferBindingType::{Storage, Uniform};

    #[test]
    fn bindings_are_those_of_the_shader() {
        let text = "@group(0) @binding(0)\nvar<uniform> a: vec4<u32>;\n\
                    @binding(1) @group(0) var<storage> b: array<u32>;\n\
                    var<workgroup> shared_by_group: u32;\n\
                    @group(0) @binding(2) var<storage, read_write> c: array<atomic<u32>>;";
        let module = naga::front::wgsl::parse_str(text).expect("valid");
        let groups: Vec<_> = layouts(&module).collect();
        let [entries] = &groups[..] else { panic!("{groups:?}") };
        let found: Vec<_> = entries.iter().map(|entry| (entry.binding, entry.ty)).collect();
        let expected = [Uniform, Storage { read_only: true }, Storage { read_only: false }]
            .map(|ty| wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None });
        assert_eq!(found, [0, 1, 2].into_iter().zip(expected).collect::<Vec<_>>());
    }
}
