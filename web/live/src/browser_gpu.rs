//! The browser's GPU, with the shaders that a reader has changed.

use common::Result;
use gpu::Gpu;
use gpu::shader_files::{SHADER_STAGES, ShaderFile, ShaderStage};
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::sync::OnceLock;

/// Files whose faults a solve shot by shot shows.
const SHOT_SHADERS: [&str; 15] = [
    "form_factor",
    "frame",
    "hemicube",
    "projection",
    "image_bound",
    "item_buffer",
    "lookup",
    "bvh",
    "rays",
    "view",
    "link",
    "closure",
    "deposit",
    "unshot_power",
    "select",
];

/// What the browser tells of its adapter: see [`describe_adapter`].
static ADAPTER: OnceLock<(String, bool)> = OnceLock::new();

/// A shader that takes the place of the program's.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct LiveShader {
    /// File name in `gpu/src/shaders`, without ending.
    pub name: String,
    /// The WGSL.
    pub text: String,
}

/// Returns the shaders that a page can change, as they are.
pub fn list_shaders() -> Vec<LiveShader> {
    let shown = SHADER_STAGES.iter().filter(|stage| SHOT_SHADERS.contains(&stage.name));
    let shaders = shown.map(|stage| LiveShader {
        name: stage.name.to_owned(),
        text: stage.text.to_owned(),
    });
    shaders.collect()
}

/// Says what the browser tells of its adapter: the name, and whether the CPU stands in for a GPU.
pub fn describe_adapter(name: String, software: bool) {
    // The first stays: a worker is started once.
    let _ = ADAPTER.set((name, software));
}

/// Opens the browser's GPU with shaders of others in the place of the program's.
///
/// Errors: those of the device; that of an unknown shader.
pub async fn open_gpu(shaders: &[LiveShader]) -> Result<Gpu> {
    let mut files = Vec::new();
    for LiveShader { name, text } in shaders {
        let stage = ShaderStage::find(name)?.name;
        files.push(ShaderFile::new(stage, Path::new(&format!("{name}.wgsl")), text.clone()));
    }
    let mut gpu = Gpu::request(None).await?;
    if let Some((name, software)) = ADAPTER.get() {
        name.clone_into(&mut gpu.line.name);
        gpu.line.software = *software;
    }
    Ok(gpu.with_shader_files(files))
}
