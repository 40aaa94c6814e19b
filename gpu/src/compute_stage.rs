//! Pipelines and their bind groups. A pipeline is compiled once on a device and bound to any number of
//! sets of buffers.

use crate::adapter::Gpu;
use crate::pipeline_cache::CompiledPipelines;
use crate::shaders::{ShaderFault, module_source};
use crate::tessellation_grids::INSTANCE_BYTES;
use common::Result;
use common::settings::{Raster, Transport};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use wgpu::ShaderStages as Stages;

/// A compute pipeline with its bind group.
pub struct ComputeStage {
    pub pipeline: wgpu::ComputePipeline,
    pub group: wgpu::BindGroup,
}

/// One binding of a stage.
pub enum BindingSlot<'a> {
    Uniform(&'a wgpu::Buffer),
    Read(&'a wgpu::Buffer),
    Write(&'a wgpu::Buffer),
    Texture(&'a wgpu::TextureView),
}
use BindingSlot::{Read, Texture, Uniform, Write};

/// Factory of the pipelines of a solver.
pub struct PipelineMaker {
    device: wgpu::Device,
    transport: Transport,
    faults: Vec<ShaderFault>,
    compiled: Arc<Mutex<CompiledPipelines>>,
}

impl PipelineMaker {
    pub fn new(gpu: &Gpu, transport: &Transport, faults: &[ShaderFault]) -> Self {
        Self {
            device: gpu.device.clone(),
            transport: *transport,
            faults: faults.to_vec(),
            compiled: gpu.compiled.clone(),
        }
    }

    /// Returns the faults planted in its shaders.
    pub fn planted_faults(&self) -> &[ShaderFault] {
        &self.faults
    }

    /// Returns the entry point `entry` of the shader `file`, bound to `slots`.
    pub fn make_stage(&self, file: &str, entry: &'static str, slots: &[BindingSlot]) -> Result<ComputeStage> {
        let key = (entry, self.module_text(file)?);
        let mut compiled = self.lock_compiled();
        let made = compiled.computes.entry(key);
        let (pipeline, layout) = made.or_insert_with_key(|(entry, text)| {
            let layout = bind_group_layout(&self.device, Stages::COMPUTE, slots);
            (self.compute_pipeline(text, entry, &layout), layout)
        });
        Ok(ComputeStage {
            pipeline: pipeline.clone(),
            group: bind_group(&self.device, layout, slots),
        })
    }

    /// Returns the pipeline that rasterises faces into item buffers, and its bind group.
    pub fn make_raster(&self, kind: Raster, slots: &[BindingSlot]) -> Result<(wgpu::RenderPipeline, wgpu::BindGroup)> {
        let file = match kind {
            Raster::Pixel => "item_buffer",
            Raster::Tessellated => "item_buffer_tessellated",
        };
        let text = self.module_text(file)?;
        let mut compiled = self.lock_compiled();
        let made = compiled.rasters.entry(text);
        let (pipeline, layout) = made.or_insert_with_key(|text| {
            let layout = bind_group_layout(&self.device, Stages::VERTEX_FRAGMENT, slots);
            let module = self.shader_module(text, file);
            (raster_pipeline(&self.device, &module, kind, &layout), layout)
        });
        let group = bind_group(&self.device, layout, slots);
        Ok((pipeline.clone(), group))
    }

    /// Locks the compiled pipelines. A panic of another thread leaves only complete ones behind.
    fn lock_compiled(&self) -> MutexGuard<'_, CompiledPipelines> {
        self.compiled.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn module_text(&self, file: &str) -> Result<String> {
        module_source(file, &self.transport, &self.faults)
    }

    fn shader_module(&self, text: &str, name: &str) -> wgpu::ShaderModule {
        let descriptor = wgpu::ShaderModuleDescriptor {
            label: Some(name),
            source: wgpu::ShaderSource::Wgsl(text.into()),
        };
        self.device.create_shader_module(descriptor)
    }

    fn compute_pipeline(&self, text: &str, entry: &str, layout: &wgpu::BindGroupLayout) -> wgpu::ComputePipeline {
        let module = self.shader_module(text, entry);
        let descriptor = wgpu::ComputePipelineDescriptor {
            label: Some(entry),
            layout: Some(&pipeline_layout(&self.device, layout)),
            module: &module,
            entry_point: Some(entry),
            compilation_options: Default::default(),
            cache: None,
        };
        self.device.create_compute_pipeline(&descriptor)
    }
}

fn bind_group_layout(device: &wgpu::Device, stages: Stages, slots: &[BindingSlot]) -> wgpu::BindGroupLayout {
    let entries: Vec<wgpu::BindGroupLayoutEntry> = (0u32..)
        .zip(slots)
        .map(|(binding, slot)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: stages,
            ty: match slot {
                Uniform(_) => buffer_binding(wgpu::BufferBindingType::Uniform),
                Read(_) => buffer_binding(wgpu::BufferBindingType::Storage { read_only: true }),
                Write(_) => buffer_binding(wgpu::BufferBindingType::Storage { read_only: false }),
                Texture(_) => wgpu::BindingType::Texture {
                    sample_type: wgpu::TextureSampleType::Uint,
                    view_dimension: wgpu::TextureViewDimension::D2,
                    multisampled: false,
                },
            },
            count: None,
        })
        .collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: None,
        entries: &entries,
    })
}

fn buffer_binding(ty: wgpu::BufferBindingType) -> wgpu::BindingType {
    wgpu::BindingType::Buffer {
        ty,
        has_dynamic_offset: false,
        min_binding_size: None,
    }
}

fn bind_group(device: &wgpu::Device, layout: &wgpu::BindGroupLayout, slots: &[BindingSlot]) -> wgpu::BindGroup {
    let entries: Vec<wgpu::BindGroupEntry> = (0u32..)
        .zip(slots)
        .map(|(binding, slot)| wgpu::BindGroupEntry {
            binding,
            resource: match slot {
                Uniform(b) | Read(b) | Write(b) => b.as_entire_binding(),
                Texture(view) => wgpu::BindingResource::TextureView(view),
            },
        })
        .collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout,
        entries: &entries,
    })
}

fn pipeline_layout(device: &wgpu::Device, layout: &wgpu::BindGroupLayout) -> wgpu::PipelineLayout {
    device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: &[Some(layout)],
        immediate_size: 0,
    })
}

/// Returns the raster pipeline. It does not cull, as backs are opaque; the first of equal depths stays.
fn raster_pipeline(
    device: &wgpu::Device,
    module: &wgpu::ShaderModule,
    kind: Raster,
    layout: &wgpu::BindGroupLayout,
) -> wgpu::RenderPipeline {
    // Tessellated faces are instances from a list; the others follow from the number of the vertex.
    let instances = [Some(wgpu::VertexBufferLayout {
        array_stride: INSTANCE_BYTES,
        step_mode: wgpu::VertexStepMode::Instance,
        attributes: &[wgpu::VertexAttribute {
            format: wgpu::VertexFormat::Uint32x2,
            offset: 0,
            shader_location: 0,
        }],
    })];
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("item buffer"),
        layout: Some(&pipeline_layout(device, layout)),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some("vertex"),
            compilation_options: Default::default(),
            buffers: match kind {
                Raster::Pixel => &[],
                Raster::Tessellated => &instances,
            },
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: wgpu::TextureFormat::Depth32Float,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Less),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some("fragment"),
            compilation_options: Default::default(),
            targets: &[Some(wgpu::TextureFormat::R32Uint.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}
