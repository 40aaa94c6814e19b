//! Cache of the pipelines that a device has compiled.

use crate::bindings::BindingLayout;
use std::collections::HashMap;

/// Compiled pipelines of a device, by the text of the shader: a second solve compiles none.
#[derive(Default)]
pub struct CompiledPipelines {
    pub computes: HashMap<(&'static str, String), (wgpu::ComputePipeline, BindingLayout)>,
    pub rasters: HashMap<String, (wgpu::RenderPipeline, BindingLayout)>,
}
