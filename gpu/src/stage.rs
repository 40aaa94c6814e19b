//! Pipelines and their bind groups. A pipeline is compiled once on a device, and bound to as many
//! sets of buffers as there are.

use crate::adapter::Gpu;
use crate::compiled::Compiled;
use crate::grids::INSTANCE_BYTES;
use crate::shaders::{Fault, source};
use common::Result;
use common::settings::{Raster, Transport};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use wgpu::ShaderStages as Stages;

/// A compute stage ready to run.
pub struct Stage {
    pub pipeline: wgpu::ComputePipeline,
    pub group: wgpu::BindGroup,
}

/// One binding of a stage.
pub enum Slot<'a> {
    Uniform(&'a wgpu::Buffer),
    Read(&'a wgpu::Buffer),
    Write(&'a wgpu::Buffer),
    Texture(&'a wgpu::TextureView),
}
use Slot::{Read, Texture, Uniform, Write};

/// Where the pipelines of a solver are made.
pub struct PipelineMaker {
    device: wgpu::Device,
    transport: Transport,
    faults: Vec<Fault>,
    compiled: Arc<Mutex<Compiled>>,
}

impl PipelineMaker {
    pub fn new(gpu: &Gpu, transport: &Transport, faults: &[Fault]) -> Self {
        Self {
            device: gpu.device.clone(),
            transport: *transport,
            faults: faults.to_vec(),
            compiled: gpu.compiled.clone(),
        }
    }

    /// What is wrong with its shaders.
    pub fn faults(&self) -> &[Fault] {
        &self.faults
    }

    /// The entry point `entry` of the shader `file`, bound to `slots`.
    pub fn stage(&self, file: &str, entry: &'static str, slots: &[Slot]) -> Result<Stage> {
        let key = (entry, self.text(file)?);
        let mut compiled = self.compiled();
        let made = compiled.computes.entry(key);
        let (pipeline, layout) = made.or_insert_with_key(|(entry, text)| {
            let layout = layout(&self.device, Stages::COMPUTE, slots);
            (self.compute(text, entry, &layout), layout)
        });
        Ok(Stage {
            pipeline: pipeline.clone(),
            group: group(&self.device, layout, slots),
        })
    }

    /// The raster of faces into item buffers.
    pub fn raster(
        &self,
        kind: Raster,
        slots: &[Slot],
    ) -> Result<(wgpu::RenderPipeline, wgpu::BindGroup)> {
        let file = match kind {
            Raster::Pixel => "item_buffer",
            Raster::Tessellated => "item_buffer_tessellated",
        };
        let text = self.text(file)?;
        let mut compiled = self.compiled();
        let made = compiled.rasters.entry(text);
        let (pipeline, layout) = made.or_insert_with_key(|text| {
            let layout = layout(&self.device, Stages::VERTEX_FRAGMENT, slots);
            let module = self.module(text, file);
            (raster(&self.device, &module, kind, &layout), layout)
        });
        let group = group(&self.device, layout, slots);
        Ok((pipeline.clone(), group))
    }

    /// A panic elsewhere leaves only whole pipelines behind.
    fn compiled(&self) -> MutexGuard<'_, Compiled> {
        self.compiled.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn text(&self, file: &str) -> Result<String> {
        source(file, &self.transport, &self.faults)
    }

    fn module(&self, text: &str, name: &str) -> wgpu::ShaderModule {
        let descriptor = wgpu::ShaderModuleDescriptor {
            label: Some(name),
            source: wgpu::ShaderSource::Wgsl(text.into()),
        };
        self.device.create_shader_module(descriptor)
    }

    fn compute(
        &self,
        text: &str,
        entry: &str,
        layout: &wgpu::BindGroupLayout,
    ) -> wgpu::ComputePipeline {
        let module = self.module(text, entry);
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

fn layout(device: &wgpu::Device, stages: Stages, slots: &[Slot]) -> wgpu::BindGroupLayout {
    let entries: Vec<wgpu::BindGroupLayoutEntry> = (0u32..)
        .zip(slots)
        .map(|(binding, slot)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: stages,
            ty: match slot {
                Uniform(_) => buffer(wgpu::BufferBindingType::Uniform),
                Read(_) => buffer(wgpu::BufferBindingType::Storage { read_only: true }),
                Write(_) => buffer(wgpu::BufferBindingType::Storage { read_only: false }),
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

fn buffer(ty: wgpu::BufferBindingType) -> wgpu::BindingType {
    wgpu::BindingType::Buffer {
        ty,
        has_dynamic_offset: false,
        min_binding_size: None,
    }
}

fn group(device: &wgpu::Device, layout: &wgpu::BindGroupLayout, slots: &[Slot]) -> wgpu::BindGroup {
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

/// No culling: a back is opaque. The first of equal depths stays.
fn raster(
    device: &wgpu::Device,
    module: &wgpu::ShaderModule,
    kind: Raster,
    layout: &wgpu::BindGroupLayout,
) -> wgpu::RenderPipeline {
    // Tessellated faces come as lists of instances, the others by the number of the vertex.
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
