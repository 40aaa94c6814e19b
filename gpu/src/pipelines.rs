//! Pipelines and their bind groups, one of each per stage of a shot.

use crate::adapter::Gpu;
use crate::buffers::Buffers;
use crate::shaders::{Fault, source};
use common::Result;
use common::settings::{Raster, Settings, Visibility};
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
    pub aim: Stage,
    pub whole: Stage,
    pub gather: Stage,
    pub escape: Stage,
    pub received: Stage,
    pub closure: Stage,
    pub deposit: Stage,
    pub power: Stage,
    /// None where visibility is by rays.
    pub item_buffer: Option<ItemBufferStages>,
}

/// What draws an item buffer.
pub struct ItemBufferStages {
    pub kind: Raster,
    pub tessellate: Stage,
    pub raster: wgpu::RenderPipeline,
    pub raster_group: wgpu::BindGroup,
}

impl ItemBufferStages {
    fn new(
        device: &wgpu::Device,
        settings: &Settings,
        b: &Buffers,
        faults: &[Fault],
    ) -> Result<Self> {
        let kind = settings.raster();
        let file = match kind {
            Raster::Pixel => "item_buffer",
            Raster::Tessellated => "item_buffer_tessellated",
        };
        let seen = [Read(&b.faces), Read(&b.shot), Uniform(&b.params)];
        let image = module(device, file, settings, faults)?;
        let (raster, raster_group) = raster(device, &image, kind, &seen);
        let lists = [
            Read(&b.faces),
            Read(&b.shot),
            Uniform(&b.params),
            Write(&b.instances),
            Write(&b.draws),
        ];
        let tessellate = module(device, "tessellate", settings, faults)?;
        Ok(Self {
            kind,
            tessellate: compute(device, &tessellate, "tessellate", &lists),
            raster,
            raster_group,
        })
    }
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
        let stage = |file, entry, slots: &[Slot]| -> Result<Stage> {
            let module = module(device, file, settings, faults)?;
            Ok(compute(device, &module, entry, slots))
        };
        let choice = [
            Uniform(&b.params),
            Read(&b.cells),
            Read(&b.sums),
            Read(&b.script),
            Read(&b.rows),
            Write(&b.shot),
            Write(&b.log),
            Write(&b.dispatches),
            Write(&b.lost),
        ];
        let view = b
            .item_buffer
            .create_view(&wgpu::TextureViewDescriptor::default());
        let rays = settings.visibility == Visibility::Rays;
        let mut linked = vec![
            Read(&b.faces),
            Read(&b.shot),
            Uniform(&b.params),
            Read(&b.texels),
            Read(&b.points),
            Write(&b.samples),
            Write(&b.links),
        ];
        if rays {
            linked.extend([Read(&b.nodes), Read(&b.primitives)]);
        } else {
            // Without objects both are the one that is drawn.
            linked.extend([
                Texture(&view),
                Texture(b.room_buffer.as_ref().unwrap_or(&view)),
            ]);
        }
        let aimed = [
            Uniform(&b.params),
            Read(&b.faces),
            Read(&b.points),
            Write(&b.shot),
            Write(&b.rectangles),
        ];
        let pipelines = Self {
            first: stage("select", "first", &choice)?,
            next: stage("select", "next", &choice)?,
            aim: stage("aim", "aim", &aimed)?,
            whole: stage("aim", "whole", &aimed)?,
            gather: stage("link", "gather", &linked)?,
            escape: stage(
                "escape",
                "escape",
                &[
                    Read(&b.faces),
                    Read(&b.shot),
                    Uniform(&b.params),
                    Read(&b.directions),
                    Write(&b.lost),
                    Read(&b.points),
                ],
            )?,
            received: stage(
                "received",
                "received",
                &[
                    Uniform(&b.params),
                    Read(&b.cells),
                    Read(&b.texels),
                    Read(&b.links),
                    Read(&b.shot),
                    Write(&b.taken),
                ],
            )?,
            closure: stage(
                "closure",
                "closure",
                &[
                    Uniform(&b.params),
                    Read(&b.taken),
                    Read(&b.lost),
                    Write(&b.rows),
                    Write(&b.shot),
                ],
            )?,
            deposit: stage(
                "deposit",
                "deposit",
                &[
                    Read(&b.shot),
                    Uniform(&b.params),
                    Read(&b.texels),
                    Read(&b.links),
                    Write(&b.radiosity),
                    Write(&b.residual),
                    Write(&b.irradiance),
                    Read(&b.samples),
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
                    Write(&b.sums),
                ],
            )?,
            item_buffer: if rays {
                None
            } else {
                Some(ItemBufferStages::new(device, settings, b, faults)?)
            },
        };
        gpu.check()?;
        Ok(pipelines)
    }
}

fn module(
    device: &wgpu::Device,
    name: &str,
    settings: &Settings,
    faults: &[Fault],
) -> Result<wgpu::ShaderModule> {
    let text = source(name, settings, faults)?;
    Ok(device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(name),
        source: wgpu::ShaderSource::Wgsl(text.into()),
    }))
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
