//! The pipelines that a device has compiled: it keeps them as long as it is open.

use std::collections::HashMap;

/// The pipelines of a device, each by its shader's text: solving again compiles nothing.
#[derive(Default)]
pub struct Compiled {
    pub computes: HashMap<(&'static str, String), (wgpu::ComputePipeline, wgpu::BindGroupLayout)>,
    pub rasters: HashMap<String, (wgpu::RenderPipeline, wgpu::BindGroupLayout)>,
}
