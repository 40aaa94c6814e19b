//! Adapters, and the device opened on one of them.

use crate::call_clock::CallClock;
use crate::pipeline_cache::CompiledPipelines;
use crate::shader_files::ShaderFile;
use common::{Error, Result};
use std::sync::{Arc, Mutex};

/// An adapter, as `radiosity adapters` lists it.
#[derive(Clone, Debug)]
pub struct AdapterLine {
    /// The driver's name for it.
    pub name: String,
    /// Vulkan, Metal, DX12, …
    pub backend: String,
    /// The driver and its version.
    pub driver: String,
    /// True for an adapter that runs on the CPU (lavapipe, SwiftShader, WARP).
    pub software: bool,
}

/// A device, its queue and its first failure.
#[derive(Clone)]
pub struct Gpu {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    /// The adapter.
    pub line: AdapterLine,
    pub(crate) compiled: Arc<Mutex<CompiledPipelines>>,
    /// Files that take the place of the program's shaders.
    pub(crate) shader_files: Arc<[ShaderFile]>,
    /// Clock of its calls.
    pub call_clock: Arc<CallClock>,
    failure: Arc<Mutex<Option<String>>>,
}

fn wgpu_instance() -> wgpu::Instance {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    // The shaders write indirect arguments from checked counts; wgpu's check of them is one more pass
    // before every shot's draws.
    descriptor.flags.remove(wgpu::InstanceFlags::VALIDATION_INDIRECT_CALL);
    wgpu::Instance::new(descriptor)
}

fn describe_adapter(adapter: &wgpu::Adapter) -> AdapterLine {
    let info = adapter.get_info();
    AdapterLine {
        name: info.name,
        backend: info.backend.to_string(),
        driver: format!("{} {}", info.driver, info.driver_info).trim().to_owned(),
        software: info.device_type == wgpu::DeviceType::Cpu,
    }
}

fn is_usable(adapter: &wgpu::Adapter) -> bool {
    let flags = adapter.get_downlevel_capabilities().flags;
    flags.contains(wgpu::DownlevelFlags::COMPUTE_SHADERS | wgpu::DownlevelFlags::INDIRECT_EXECUTION)
}

/// Lists all adapters that can run the shaders, hardware first.
pub fn list_adapters() -> Vec<AdapterLine> {
    usable_adapters().iter().map(describe_adapter).collect()
}

fn usable_adapters() -> Vec<wgpu::Adapter> {
    let mut found = pollster::block_on(wgpu_instance().enumerate_adapters(wgpu::Backends::all()));
    found.retain(is_usable);
    // Discrete before integrated before virtual before software; equal kinds keep their order.
    found.sort_by_key(|adapter| match adapter.get_info().device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu | wgpu::DeviceType::Other => 2,
        wgpu::DeviceType::Cpu => 3,
    });
    found
}

impl Gpu {
    /// Opens the best adapter, or the first whose name contains `name` (any case).
    ///
    /// Errors: [`Error::NoAdapter`], [`Error::Device`].
    pub fn open(name: Option<&str>) -> Result<Self> {
        let adapter = usable_adapters()
            .into_iter()
            .find(|adapter| {
                let found = adapter.get_info().name.to_lowercase();
                name.is_none_or(|name| found.contains(&name.to_lowercase()))
            })
            .ok_or_else(|| no_adapter(name))?;
        // wgpu's default limits suffice but for large scenes: they get the adapter's limits of memory.
        let has = adapter.limits();
        let required_limits = wgpu::Limits {
            max_storage_buffer_binding_size: has.max_storage_buffer_binding_size,
            max_buffer_size: has.max_buffer_size,
            max_texture_dimension_2d: has.max_texture_dimension_2d,
            ..wgpu::Limits::default()
        };
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("radiosity"),
            required_limits,
            ..Default::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|error| Error::Device(format!("{}: {error}", adapter.get_info().name)))?;
        let gpu = Self {
            device,
            queue,
            line: describe_adapter(&adapter),
            compiled: Arc::default(),
            shader_files: Arc::new([]),
            call_clock: Arc::default(),
            failure: Arc::default(),
        };
        gpu.listen_for_errors();
        Ok(gpu)
    }

    /// Returns the device with `files` in the place of shaders of the program.
    pub fn with_shader_files(self, files: Vec<ShaderFile>) -> Self {
        Self {
            shader_files: files.into(),
            ..self
        }
    }

    /// Iterates over notes on those files.
    pub fn describe_shader_files(&self) -> impl Iterator<Item = String> {
        let files = self.shader_files.iter();
        files.map(|file| format!("{} takes the place of {}.wgsl", file.path.display(), file.stage))
    }

    /// Returns the first of those files of which no pipeline was made.
    pub fn unused_shader_file(&self) -> Option<&ShaderFile> {
        self.shader_files.iter().find(|file| !file.is_used())
    }

    /// Stores the first error that arrives between calls: loss, memory, validation.
    fn listen_for_errors(&self) {
        let first = |failure: &Mutex<Option<String>>, text: String| {
            if let Ok(mut failure) = failure.lock() {
                failure.get_or_insert(text);
            }
        };
        let failure = self.failure.clone();
        self.device.set_device_lost_callback(move |reason, message| {
            if reason != wgpu::DeviceLostReason::Destroyed {
                first(&failure, format!("the device was lost: {message}"));
            }
        });
        let failure = self.failure.clone();
        self.device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            let text = match error {
                wgpu::Error::OutOfMemory { .. } => {
                    "out of GPU memory: ask for fewer texels a face or a smaller item buffer".to_owned()
                }
                other => other.to_string().replace('\n', " "),
            };
            first(&failure, text);
        }));
    }

    /// Returns the first failure as an error that names the adapter.
    pub(crate) fn check_errors(&self) -> Result<()> {
        let failure = self.failure.lock().ok().and_then(|failure| failure.clone());
        failure.map_or(Ok(()), |text| Err(self.device_error(&text)))
    }

    /// Returns an error that names the adapter. Shaders of others are at fault before the device is.
    pub fn device_error(&self, text: &str) -> Error {
        let text = format!("{}: {text}", self.line.name);
        if self.shader_files.is_empty() {
            return Error::Device(text);
        }
        let paths = self.shader_files.iter().map(|file| file.path.display().to_string());
        Error::bad_input(paths.collect::<Vec<_>>().join(", "), "", text)
    }
}

fn no_adapter(name: Option<&str>) -> Error {
    let found: Vec<String> = list_adapters().into_iter().map(|line| line.name).collect();
    Error::NoAdapter(match (name, found.is_empty()) {
        (_, true) => "no GPU adapter found: install a Vulkan driver (Linux without a GPU: the \
                      package mesa-vulkan-drivers), or let the CPU solve it"
            .to_owned(),
        (Some(name), false) => format!("no adapter is called {name:?}; there are: {}", found.join(", ")),
        (None, false) => format!("no adapter can be used: {}", found.join(", ")),
    })
}
