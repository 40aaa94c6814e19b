//! Pipelines and their bind groups, one of each per stage of a shot.

use crate::adapter::Gpu;
use crate::buffers::Buffers;
use crate::shaders::{Fault, source};
use common::Result;
use common::settings::{Raster, Settings};
use wgpu::ShaderStages as Stages;

/// A compute stage ready to run.
pub struct Stage {
    pub pipeline: wgpu::ComputePipeline,
    pub group: wgpu::BindGroup,
}

/// All stages of a shot.
pub struct Pipelines {
    pub first: Stage,
    pub next: Stage,
    pub tessellate: Stage,
    pub deposit: Stage,
    pub escape: Stage,
    pub power: Stage,
    pub raster: wgpu::RenderPipeline,
    pub raster_kind: Raster,
    /// Planes of the image; each face is drawn on each.
    pub sides: u32,
    pub raster_group: wgpu::BindGroup,
}

/// One binding of a stage.
enum Slot<'a> {
    Uniform(&'a wgpu::Buffer),
    Read(&'a wgpu::Buffer),
    Write(&'a wgpu::Buffer),
    Texture(&'a wgpu::TextureView),
}
use Slot::{Read, Texture, Uniform, Write};

impl Pipelines {
    pub fn new(gpu: &Gpu, settings: &Settings, b: &Buffers, faults: &[Fault]) -> Result<Self> {
        let device = &gpu.device;
        let module = |name| -> Result<wgpu::ShaderModule> {
            let text = source(name, settings, faults)?;
            Ok(device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(name),
                source: wgpu::ShaderSource::Wgsl(text.into()),
            }))
        };
        let stage = |file, entry, slots: &[Slot]| -> Result<Stage> {
            Ok(compute(device, &module(file)?, entry, slots))
        };
        let choice = [
            Uniform(&b.params),
            Read(&b.faces),
            Read(&b.cells),
            Read(&b.sums),
            Read(&b.script),
            Write(&b.shot),
            Write(&b.log),
            Write(&b.dispatches),
            Write(&b.lost),
        ];
        let view = b
            .item_buffer
            .create_view(&wgpu::TextureViewDescriptor::default());
        let seen = [Read(&b.faces), Read(&b.shot), Uniform(&b.params)];
        let raster_kind = settings.raster();
        let file = match raster_kind {
            Raster::Pixel => "item_buffer",
            Raster::Tessellated => "item_buffer_tessellated",
        };
        let (raster, raster_group) = raster(device, &module(file)?, raster_kind, &seen);
        let pipelines = Self {
            first: stage("select", "first", &choice)?,
            next: stage("select", "next", &choice)?,
            tessellate: stage(
                "tessellate",
                "tessellate",
                &[
                    Read(&b.faces),
                    Read(&b.shot),
                    Uniform(&b.params),
                    Write(&b.instances),
                    Write(&b.draws),
                ],
            )?,
            deposit: stage(
                "deposit",
                "deposit",
                &[
                    Read(&b.faces),
                    Read(&b.shot),
                    Uniform(&b.params),
                    Read(&b.texels),
                    Write(&b.radiosity),
                    Write(&b.residual),
                    Write(&b.irradiance),
                    Texture(&view),
                ],
            )?,
            escape: stage(
                "escape",
                "escape",
                &[
                    Read(&b.faces),
                    Read(&b.shot),
                    Uniform(&b.params),
                    Read(&b.directions),
                    Write(&b.lost),
                ],
            )?,
            power: stage(
                "power",
                "power",
                &[
                    Uniform(&b.params),
                    Read(&b.cells),
                    Read(&b.texels),
                    Read(&b.residual),
                    Read(&b.irradiance),
                    Write(&b.sums),
                ],
            )?,
            raster,
            raster_kind,
            sides: settings.visibility.sides(),
            raster_group,
        };
        gpu.check()?;
        Ok(pipelines)
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

fn compute(
    device: &wgpu::Device,
    module: &wgpu::ShaderModule,
    entry: &str,
    slots: &[Slot],
) -> Stage {
    let layout = layout(device, Stages::COMPUTE, slots);
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(entry),
        layout: Some(&pipeline_layout(device, &layout)),
        module,
        entry_point: Some(entry),
        compilation_options: Default::default(),
        cache: None,
    });
    Stage {
        pipeline,
        group: group(device, &layout, slots),
    }
}

/// No culling: a back is opaque. The first of equal depths stays.
fn raster(
    device: &wgpu::Device,
    module: &wgpu::ShaderModule,
    kind: Raster,
    slots: &[Slot],
) -> (wgpu::RenderPipeline, wgpu::BindGroup) {
    let layout = layout(device, Stages::VERTEX_FRAGMENT, slots);
    // Tessellated faces come as lists of instances, the others by the number of the vertex.
    let instances = [Some(wgpu::VertexBufferLayout {
        array_stride: 8,
        step_mode: wgpu::VertexStepMode::Instance,
        attributes: &[wgpu::VertexAttribute {
            format: wgpu::VertexFormat::Uint32x2,
            offset: 0,
            shader_location: 0,
        }],
    })];
    let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("item buffer"),
        layout: Some(&pipeline_layout(device, &layout)),
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
    });
    (pipeline, group(device, &layout, slots))
}
