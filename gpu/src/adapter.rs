//! Adapters, and the device on one of them.

use crate::compiled::Compiled;
use common::{Error, Result};
use std::sync::{Arc, Mutex};

/// What timestamps between passes need.
pub const TIMESTAMPS: wgpu::Features =
    wgpu::Features::TIMESTAMP_QUERY.union(wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS);

/// What `radiosity adapters` lists.
#[derive(Clone, Debug)]
pub struct AdapterLine {
    /// The driver's name for it.
    pub name: String,
    /// Vulkan, Metal, DX12, …
    pub backend: String,
    /// The driver and its version.
    pub driver: String,
    /// Runs on the CPU (lavapipe, SwiftShader, WARP).
    pub software: bool,
}

/// A device, its queue and what went wrong on it.
#[derive(Clone)]
pub struct Gpu {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    /// The adapter.
    pub line: AdapterLine,
    pub(crate) compiled: Arc<Mutex<Compiled>>,
    failure: Arc<Mutex<Option<String>>>,
}

fn instance() -> wgpu::Instance {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    // Our indirect arguments are written by our own shaders from checked counts; wgpu's check of
    // them is one more pass before every shot's draws.
    descriptor
        .flags
        .remove(wgpu::InstanceFlags::VALIDATION_INDIRECT_CALL);
    wgpu::Instance::new(descriptor)
}

fn describe(adapter: &wgpu::Adapter) -> AdapterLine {
    let info = adapter.get_info();
    AdapterLine {
        name: info.name,
        backend: info.backend.to_string(),
        driver: format!("{} {}", info.driver, info.driver_info)
            .trim()
            .to_owned(),
        software: info.device_type == wgpu::DeviceType::Cpu,
    }
}

fn usable(adapter: &wgpu::Adapter) -> bool {
    let flags = adapter.get_downlevel_capabilities().flags;
    flags.contains(wgpu::DownlevelFlags::COMPUTE_SHADERS | wgpu::DownlevelFlags::INDIRECT_EXECUTION)
}

/// All adapters that can run the shaders, hardware first.
pub fn adapters() -> Vec<AdapterLine> {
    enumerate().iter().map(describe).collect()
}

fn enumerate() -> Vec<wgpu::Adapter> {
    let mut found = pollster::block_on(instance().enumerate_adapters(wgpu::Backends::all()));
    found.retain(usable);
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
    pub fn open(name: Option<&str>) -> Result<Self> {
        Self::open_with(name, wgpu::Features::empty())
    }

    /// The same with the device's clock, where it has one. Software adapters are not asked: on
    /// lavapipe timestamps corrupt memory.
    pub fn open_timed(name: Option<&str>) -> Result<Self> {
        Self::open_with(name, TIMESTAMPS)
    }

    fn open_with(name: Option<&str>, wanted: wgpu::Features) -> Result<Self> {
        let adapter = enumerate()
            .into_iter()
            .find(|adapter| {
                let found = adapter.get_info().name.to_lowercase();
                name.is_none_or(|name| found.contains(&name.to_lowercase()))
            })
            .ok_or_else(|| no_adapter(name))?;
        // The defaults suffice but for large scenes: take what the adapter has of memory.
        let has = adapter.limits();
        let required_limits = wgpu::Limits {
            max_storage_buffer_binding_size: has.max_storage_buffer_binding_size,
            max_buffer_size: has.max_buffer_size,
            max_texture_dimension_2d: has.max_texture_dimension_2d,
            ..wgpu::Limits::default()
        };
        let line = describe(&adapter);
        let required_features = if line.software || !adapter.features().contains(wanted) {
            wgpu::Features::empty()
        } else {
            wanted
        };
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("radiosity"),
            required_features,
            required_limits,
            ..Default::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|error| Error::Device(format!("{}: {error}", adapter.get_info().name)))?;
        let gpu = Self {
            device,
            queue,
            line,
            compiled: Arc::default(),
            failure: Arc::default(),
        };
        gpu.listen();
        Ok(gpu)
    }

    /// Remembers the first error that arrives between calls: loss, memory, validation.
    fn listen(&self) {
        let first = |failure: &Mutex<Option<String>>, text: String| {
            if let Ok(mut failure) = failure.lock() {
                failure.get_or_insert(text);
            }
        };
        let failure = self.failure.clone();
        self.device
            .set_device_lost_callback(move |reason, message| {
                if reason != wgpu::DeviceLostReason::Destroyed {
                    first(&failure, format!("the device was lost: {message}"));
                }
            });
        let failure = self.failure.clone();
        self.device
            .on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
                let text = match error {
                    wgpu::Error::OutOfMemory { .. } => {
                        "out of GPU memory: ask for fewer texels a face or a smaller item buffer"
                            .to_owned()
                    }
                    other => other.to_string().replace('\n', " "),
                };
                first(&failure, text);
            }));
    }

    /// The failure that has been seen, as an error that names the adapter.
    pub(crate) fn check(&self) -> Result<()> {
        let failure = self.failure.lock().ok().and_then(|failure| failure.clone());
        failure.map_or(Ok(()), |text| Err(self.fail(&text)))
    }

    /// An error that names the adapter.
    pub(crate) fn fail(&self, text: &str) -> Error {
        Error::Device(format!("{}: {text}", self.line.name))
    }
}

fn no_adapter(name: Option<&str>) -> Error {
    let found: Vec<String> = adapters().into_iter().map(|line| line.name).collect();
    Error::NoAdapter(match (name, found.is_empty()) {
        (_, true) => "no GPU adapter found: install a Vulkan driver (Linux without a GPU: the \
                      package mesa-vulkan-drivers), or let the CPU solve it"
            .to_owned(),
        (Some(name), false) => format!(
            "no adapter is called {name:?}; there are: {}",
            found.join(", ")
        ),
        (None, false) => format!("no adapter can be used: {}", found.join(", ")),
    })
}
