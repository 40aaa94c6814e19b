//! Adapters, and the device opened on one of them.

use crate::call_clock::CallClock;
use crate::pipeline_cache::CompiledPipelines;
use crate::shader_files::ShaderFile;
use crate::watch_log::WatchLog;
use common::{Error, Result};
use stage_check::adapters::{find_adapter, open_device, usable_adapters};
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
    /// Where its shaders count races; none but of a device for checks.
    pub(crate) watch_log: Option<Arc<WatchLog>>,
    /// Clock of its calls.
    pub call_clock: Arc<CallClock>,
    failure: Arc<Mutex<Option<String>>>,
}

fn describe_adapter(adapter: &wgpu::Adapter) -> AdapterLine {
    let info = adapter.get_info();
    let backend = info.backend.to_string();
    AdapterLine {
        // A browser need not tell the name.
        name: match info.name.is_empty() {
            true => backend.clone(),
            false => info.name,
        },
        backend,
        driver: format!("{} {}", info.driver, info.driver_info).trim().to_owned(),
        software: info.device_type == wgpu::DeviceType::Cpu,
    }
}

/// Lists all adapters that can run the shaders, hardware first.
pub fn list_adapters() -> Vec<AdapterLine> {
    pollster::block_on(request_adapters())
}

async fn request_adapters() -> Vec<AdapterLine> {
    usable_adapters().await.iter().map(describe_adapter).collect()
}

impl Gpu {
    /// Opens the best adapter, or the first whose name contains `name` (any case).
    ///
    /// Errors: [`Error::NoAdapter`], [`Error::Device`].
    pub fn open(name: Option<&str>) -> Result<Self> {
        pollster::block_on(Self::request(name))
    }

    /// Awaits the best adapter, or the first whose name contains `name` (any case), opened. A page may not wait: there
    /// this function takes the place of [`Self::open`].
    ///
    /// Errors: those of [`Self::open`].
    pub async fn request(name: Option<&str>) -> Result<Self> {
        let Some(adapter) = find_adapter(name).await else {
            return Err(no_adapter(name, &request_adapters().await));
        };
        let (device, queue) = open_device(&adapter).await.map_err(Error::Device)?;
        let gpu = Self {
            device,
            queue,
            line: describe_adapter(&adapter),
            compiled: Arc::default(),
            shader_files: Arc::new([]),
            watch_log: None,
            call_clock: Arc::default(),
            failure: Arc::default(),
        };
        gpu.listen_for_errors();
        Ok(gpu)
    }

    /// Returns the device with `files` in the place of shaders of the program.
    pub fn with_shader_files(self, files: Vec<ShaderFile>) -> Self {
        self.call_clock.suspect_stage(match &files[..] {
            [file] => Some(file.stage),
            _ => None,
        });
        Self {
            shader_files: files.into(),
            ..self
        }
    }

    /// Returns the same device for checks of stages: pipelines that are made for it count the races of their workgroup memory
    /// and the turns of loops in given files, and its solvers work as [`crate::buffer_ends`] says, with sums over patches in more
    /// than one part.
    pub fn for_checks(&self) -> Self {
        Self {
            watch_log: Some(Arc::new(WatchLog::new(&self.device))),
            ..self.clone()
        }
    }

    /// Returns the same device for work whose read-backs do not look at the log.
    pub(crate) fn without_log(&self) -> Self {
        Self {
            watch_log: None,
            ..self.clone()
        }
    }

    /// Returns whether it is a device for checks.
    pub(crate) fn is_for_checks(&self) -> bool {
        self.watch_log.is_some()
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

    /// Iterates over the stages of those files of which pipelines were made.
    pub fn used_shaders(&self) -> impl Iterator<Item = &'static str> {
        let used = self.shader_files.iter().filter(|file| file.is_used());
        used.map(|file| file.stage)
    }

    /// Returns whether the device failed: all later work on it fails too.
    pub fn has_failed(&self) -> bool {
        self.check_errors().is_err()
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

    /// Awaits what the device says of the work so far: a browser reports failures later than the calls return.
    ///
    /// Errors: the first failure.
    pub(crate) async fn request_errors(&self) -> Result<()> {
        #[cfg(target_arch = "wasm32")]
        {
            let (sender, done) = futures_channel::oneshot::channel();
            self.queue.on_submitted_work_done(move || {
                // The receiver is gone only when the work was abandoned.
                let _ = sender.send(());
            });
            // A device that is lost has failed.
            let _ = done.await;
        }
        self.check_errors()
    }

    /// Returns the first failure as an error that names the adapter.
    pub(crate) fn check_errors(&self) -> Result<()> {
        let failure = self.failure.lock().ok().and_then(|failure| failure.clone());
        failure.map_or(Ok(()), |text| Err(self.device_error(&text)))
    }

    /// Returns an error that names the adapter. Shaders of others are at fault before the device is.
    pub fn device_error(&self, text: &str) -> Error {
        self.error_maker()(text)
    }

    /// Returns a function that makes such errors, also when the device is gone.
    pub fn error_maker(&self) -> impl Fn(&str) -> Error + Send + use<> {
        let (name, paths) = (self.line.name.clone(), self.shader_paths());
        move |text| {
            let text = format!("{name}: {text}");
            match &paths {
                None => Error::Device(text),
                Some(paths) => Error::bad_input(paths, "", text),
            }
        }
    }

    /// Returns an error of a result that a shader has not left, or that cannot be; it names the files of others.
    pub(crate) fn stage_error(&self, stage: &'static str, text: &str) -> Error {
        let files = self.shader_paths().map_or(String::new(), |paths| format!("{paths}: "));
        Error::Stage {
            stage,
            message: format!("{files}{}: {text}", self.line.name),
        }
    }

    /// Returns the paths of the files that take the place of shaders, if there are any.
    fn shader_paths(&self) -> Option<String> {
        let paths = self.shader_files.iter().map(|file| file.path.display().to_string());
        Some(paths.collect::<Vec<_>>().join(", ")).filter(|paths| !paths.is_empty())
    }
}

fn no_adapter(name: Option<&str>, found: &[AdapterLine]) -> Error {
    let found: Vec<&str> = found.iter().map(|line| line.name.as_str()).collect();
    Error::NoAdapter(match (name, found.is_empty()) {
        (_, true) if cfg!(target_arch = "wasm32") => "no GPU adapter found: the browser has no WebGPU".to_owned(),
        (_, true) => "no GPU adapter found: install a Vulkan driver (Linux without a GPU: the \
                      package mesa-vulkan-drivers), or let the CPU solve it"
            .to_owned(),
        (Some(name), false) => format!("no adapter is called {name:?}; there are: {}", found.join(", ")),
        (None, false) => format!("no adapter can be used: {}", found.join(", ")),
    })
}
