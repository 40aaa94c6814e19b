//! Pipelines and their bind groups. A pipeline is compiled once on a device and bound to any number of sets of buffers.
//! Shots, passes and the linker make all their stages by it.

use crate::adapter::Gpu;
use crate::bindings::{BindingLayout, BindingTable};
use crate::function_calls::{CALL_ENTRY, FunctionCall};
use crate::module_text::ModuleText;
use crate::pipeline_cache::CompiledPipelines;
use crate::shader_files::ShaderFile;
use crate::shaders::{ShaderFault, assemble_call, assemble_module};
use crate::watch_log::WatchLog;
use common::Result;
use common::settings::{ItemBufferProjection, Transport};
use stage_check::watch::WATCH_LOG;
use std::borrow::Cow;
use std::collections::hash_map::Entry;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use wgpu::ShaderStages as Stages;
use wgpu::naga::front::wgsl::parse_str;

/// A compute pipeline with its bind group.
pub struct ComputeStage {
    pipeline: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
}

impl ComputeStage {
    /// Dispatches these workgroups.
    pub fn dispatch_groups(&self, pass: &mut wgpu::ComputePass, [x, y, z]: [u32; 3]) {
        self.set_on(pass);
        pass.dispatch_workgroups(x, y, z);
    }

    /// Dispatches the workgroups that the device has written to `arguments` at byte `at`.
    pub fn dispatch_counted(&self, pass: &mut wgpu::ComputePass, arguments: &wgpu::Buffer, at: u64) {
        self.set_on(pass);
        pass.dispatch_workgroups_indirect(arguments, at);
    }

    fn set_on(&self, pass: &mut wgpu::ComputePass) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group, &[]);
    }
}

/// Factory of the pipelines of a solver.
pub struct PipelineMaker {
    device: wgpu::Device,
    pub transport: Transport,
    /// Faults planted in its shaders.
    pub faults: Vec<ShaderFault>,
    shader_files: Arc<[ShaderFile]>,
    watch_log: Option<Arc<WatchLog>>,
    compiled: Arc<Mutex<CompiledPipelines>>,
}

impl PipelineMaker {
    pub fn new(gpu: &Gpu, transport: &Transport, faults: &[ShaderFault]) -> Self {
        Self {
            device: gpu.device.clone(),
            transport: *transport,
            faults: faults.to_vec(),
            shader_files: gpu.shader_files.clone(),
            watch_log: gpu.watch_log.clone(),
            compiled: gpu.compiled.clone(),
        }
    }

    /// Returns the entry point `entry` of the shader `file`, bound to what `table` has under its names.
    pub fn make_stage(&self, file: &str, entry: &'static str, table: &BindingTable) -> Result<ComputeStage> {
        let module = self.module_text(file)?;
        let watched = self
            .watch_log
            .as_ref()
            .and_then(|log| Some((log, log.watch_text(file, &module)?)));
        let (text, table) = match watched {
            Some((log, text)) => (text, Cow::Owned(table.with(WATCH_LOG, &log.buffer))),
            None => (module.text(), Cow::Borrowed(table)),
        };
        self.make_compute(&module, (entry, text), &table)
    }

    /// Returns the entry point that calls a function, bound to what `table` has under its names.
    pub fn make_call(&self, call: &FunctionCall, table: &BindingTable) -> Result<ComputeStage> {
        let module = assemble_call(call, &self.transport, &self.faults, &self.shader_files)?;
        self.make_compute(&module, (CALL_ENTRY, module.text()), table)
    }

    /// Returns the entry point of a text that is made of `module`.
    fn make_compute(
        &self,
        module: &ModuleText,
        (entry, text): (&'static str, String),
        table: &BindingTable,
    ) -> Result<ComputeStage> {
        let mut compiled = self.lock_compiled();
        let (pipeline, layout) = match compiled.computes.entry((entry, text)) {
            Entry::Occupied(made) => made.into_mut(),
            Entry::Vacant(place) => {
                module.require_entries(&module.parse()?, [entry])?;
                let text = place.key().1.clone();
                let parsed = parse_str(&text).map_err(|error| module.refuse(&error.emit_to_string(&text)))?;
                place.insert(self.catch_refusal(module, || {
                    let layout = BindingLayout::new(&self.device, Stages::COMPUTE, &parsed);
                    let pipeline = self.compute_pipeline(&text, entry, &layout);
                    (pipeline, layout)
                })?)
            }
        };
        Ok(ComputeStage {
            pipeline: pipeline.clone(),
            group: self.bind_module(module, layout, table)?,
        })
    }

    /// Returns the pipeline that rasterises faces into item buffers, and its bind group.
    pub fn make_raster(
        &self,
        projection: ItemBufferProjection,
        table: &BindingTable,
    ) -> Result<(wgpu::RenderPipeline, wgpu::BindGroup)> {
        let file = match projection {
            ItemBufferProjection::Paper => "item_buffer_paper",
            _ => "item_buffer",
        };
        let module = self.module_text(file)?;
        let mut compiled = self.lock_compiled();
        let (pipeline, layout) = match compiled.rasters.entry(module.text()) {
            Entry::Occupied(made) => made.into_mut(),
            Entry::Vacant(place) => {
                let parsed = module.parse()?;
                module.require_entries(&parsed, ["draw_vertex", "draw_fragment"])?;
                place.insert(self.catch_refusal(&module, || {
                    let layout = BindingLayout::new(&self.device, Stages::VERTEX_FRAGMENT, &parsed);
                    let pipeline = self.raster_pipeline(&module.text(), &layout);
                    (pipeline, layout)
                })?)
            }
        };
        Ok((pipeline.clone(), self.bind_module(&module, layout, table)?))
    }

    fn module_text(&self, file: &str) -> Result<ModuleText<'_>> {
        assemble_module(file, &self.transport, &self.faults, &self.shader_files)
    }

    fn bind_module(
        &self,
        module: &ModuleText,
        layout: &BindingLayout,
        table: &BindingTable,
    ) -> Result<wgpu::BindGroup> {
        module.mark_used();
        self.catch_refusal(module, || layout.bind_table(&self.device, table))?
            .map_err(|reason| module.refuse(&reason))
    }

    /// Makes something of a module; names the given file if the device refuses it. A page may not wait for that: there a
    /// refusal is the device's first failure, which names the given files too.
    fn catch_refusal<T>(&self, module: &ModuleText, make: impl FnOnce() -> T) -> Result<T> {
        if module.given_file().is_none() || cfg!(target_arch = "wasm32") {
            return Ok(make());
        }
        let scope = self.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let made = make();
        match pollster::block_on(scope.pop()) {
            Some(error) => Err(module.refuse(&error.to_string().replace('\n', " "))),
            None => Ok(made),
        }
    }

    /// Locks the compiled pipelines. A panic of another thread leaves only complete ones behind.
    fn lock_compiled(&self) -> MutexGuard<'_, CompiledPipelines> {
        self.compiled.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn shader_module(&self, text: &str, name: &str) -> wgpu::ShaderModule {
        let descriptor = wgpu::ShaderModuleDescriptor {
            label: Some(name),
            source: wgpu::ShaderSource::Wgsl(text.into()),
        };
        self.device.create_shader_module(descriptor)
    }

    fn pipeline_layout(&self, bindings: &BindingLayout) -> wgpu::PipelineLayout {
        self.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: None,
            bind_group_layouts: &[Some(&bindings.layout)],
            immediate_size: 0,
        })
    }

    fn compute_pipeline(&self, text: &str, entry: &str, bindings: &BindingLayout) -> wgpu::ComputePipeline {
        let descriptor = wgpu::ComputePipelineDescriptor {
            label: Some(entry),
            layout: Some(&self.pipeline_layout(bindings)),
            module: &self.shader_module(text, entry),
            entry_point: Some(entry),
            compilation_options: Default::default(),
            cache: None,
        };
        self.device.create_compute_pipeline(&descriptor)
    }

    /// Returns the raster pipeline. It does not cull, as backs are opaque; the first of equal depths stays.
    fn raster_pipeline(&self, text: &str, bindings: &BindingLayout) -> wgpu::RenderPipeline {
        let module = &self.shader_module(text, "item buffer");
        self.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("item buffer"),
            layout: Some(&self.pipeline_layout(bindings)),
            vertex: wgpu::VertexState {
                module,
                entry_point: Some("draw_vertex"),
                compilation_options: Default::default(),
                buffers: &[],
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
                entry_point: Some("draw_fragment"),
                compilation_options: Default::default(),
                targets: &[Some(wgpu::TextureFormat::R32Uint.into())],
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}
