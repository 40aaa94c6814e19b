//! The device that stages run on. Whatever may never return runs in a thread of its own, which is given up at a limit.

use crate::adapters::{find_adapter, open_device, usable_adapters};
use crate::failure::{Failure, Fault};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;
use wgpu::util::{BufferInitDescriptor, DeviceExt};

/// A device; clones are the same one.
#[derive(Clone)]
pub struct Gpu {
    device: wgpu::Device,
    queue: wgpu::Queue,
    name: String,
    device_type: wgpu::DeviceType,
    /// Why it can no longer be used.
    failure: Arc<Mutex<Option<String>>>,
}

/// A buffer of a run.
pub(crate) struct RunBuffer {
    pub(crate) group: u32,
    pub(crate) binding: u32,
    pub(crate) uniform: bool,
    pub(crate) is_read_back: bool,
    pub(crate) bytes: Vec<u8>,
}

impl Gpu {
    /// Opens the best adapter, or the first whose name contains `name` (any case); software adapters come last.
    ///
    /// Errors: there is none, or it fails.
    pub fn open(name: Option<&str>) -> Result<Self, Failure> {
        pollster::block_on(Self::request(name))
    }

    async fn request(name: Option<&str>) -> Result<Self, Failure> {
        let refuse = |text: String| Failure {
            subject: "adapter".into(),
            fault: Fault::Device(text),
        };
        let Some(adapter) = find_adapter(name).await else {
            let found = usable_adapters().await;
            let names: Vec<String> = found.iter().map(|found| found.get_info().name).collect();
            return Err(refuse(format!(
                "no GPU adapter {}; there are: {}",
                name.unwrap_or("found"),
                names.join(", ")
            )));
        };
        let (device, queue) = open_device(&adapter).await.map_err(refuse)?;
        let failure: Arc<Mutex<Option<String>>> = Arc::default();
        let [lost, uncaptured] = [failure.clone(), failure.clone()];
        device
            .set_device_lost_callback(move |_, message| store_first(&lost, format!("the device was lost: {message}")));
        device.on_uncaptured_error(Arc::new(move |error| store_first(&uncaptured, error.to_string())));
        Ok(Self {
            device,
            queue,
            name: adapter.get_info().name,
            device_type: adapter.get_info().device_type,
            failure,
        })
    }

    /// Returns the adapter's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    pub(crate) fn device_type(&self) -> wgpu::DeviceType {
        self.device_type
    }

    pub(crate) fn limits(&self) -> wgpu::Limits {
        self.device.limits()
    }

    /// Does work in a thread of its own. If it does not end within the limit, thread and device are given up: every later
    /// work on the device is refused.
    pub(crate) fn work_within<T: Send + 'static>(
        &self,
        limit: Duration,
        work: impl FnOnce(&Self) -> Result<T, String> + Send + 'static,
    ) -> Result<T, Fault> {
        let named = |text: String| Fault::Device(format!("{}: {text}", self.name));
        if let Some(text) = self.failure.lock().unwrap_or_else(PoisonError::into_inner).clone() {
            return Err(named(text));
        }
        let (gpu, (sender, receiver)) = (self.clone(), channel());
        let started = thread::Builder::new().spawn(move || {
            // The receiver is gone if the work was given up.
            let _ = sender.send(work(&gpu));
        });
        started.map_err(|error| named(format!("no thread can be started: {error}")))?;
        match receiver.recv_timeout(limit) {
            Ok(done) => done.map_err(named),
            Err(RecvTimeoutError::Timeout) => {
                store_first(&self.failure, "given up, since an earlier run did not end".into());
                Err(Fault::TimeLimit(limit))
            }
            Err(RecvTimeoutError::Disconnected) => Err(named("the driver panicked".into())),
        }
    }

    /// Does work, and returns the first error that the device reports meanwhile.
    fn catch_errors<T>(&self, work: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
        let memory = self.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let validation = self.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let done = work();
        let errors = [pollster::block_on(validation.pop()), pollster::block_on(memory.pop())];
        match errors.into_iter().flatten().next() {
            Some(error) => Err(error.to_string()),
            None => done,
        }
    }

    /// Compiles an entry point.
    pub(crate) fn make_pipeline(&self, text: &str, entry: &str) -> Result<wgpu::ComputePipeline, String> {
        self.catch_errors(|| {
            let module = self.device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(entry),
                source: wgpu::ShaderSource::Wgsl(text.into()),
            });
            Ok(self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry),
                layout: None,
                module: &module,
                entry_point: Some(entry),
                compilation_options: Default::default(),
                cache: None,
            }))
        })
    }

    /// Runs a pipeline once and returns the bytes of the buffers that are read back, in order.
    pub(crate) fn run(
        &self,
        pipeline: &wgpu::ComputePipeline,
        buffers: &[RunBuffer],
        groups: [u32; 3],
    ) -> Result<Vec<Vec<u8>>, String> {
        self.catch_errors(|| {
            let made: Vec<wgpu::Buffer> = buffers.iter().map(|buffer| self.make_buffer(buffer)).collect();
            let mut encoder = self.device.create_command_encoder(&Default::default());
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(pipeline);
            let last = buffers.iter().map(|buffer| buffer.group).max().unwrap_or(0);
            for group in 0..=last {
                let own = buffers.iter().zip(&made).filter(|(buffer, _)| buffer.group == group);
                let entries: Vec<wgpu::BindGroupEntry> = own
                    .map(|(buffer, made)| wgpu::BindGroupEntry {
                        binding: buffer.binding,
                        resource: made.as_entire_binding(),
                    })
                    .collect();
                let bound = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
                    label: None,
                    layout: &pipeline.get_bind_group_layout(group),
                    entries: &entries,
                });
                pass.set_bind_group(group, &bound, &[]);
            }
            pass.dispatch_workgroups(groups[0], groups[1], groups[2]);
            drop(pass);
            let read = buffers.iter().zip(&made).filter(|(buffer, _)| buffer.is_read_back);
            let staged: Vec<wgpu::Buffer> = read
                .map(|(_, from)| {
                    let staging = self.device.create_buffer(&wgpu::BufferDescriptor {
                        label: Some("staging"),
                        size: from.size(),
                        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
                        mapped_at_creation: false,
                    });
                    encoder.copy_buffer_to_buffer(from, 0, &staging, 0, from.size());
                    staging
                })
                .collect();
            self.queue.submit([encoder.finish()]);
            for staging in &staged {
                staging.map_async(wgpu::MapMode::Read, .., |_| ());
            }
            let wait = wgpu::PollType::Wait {
                submission_index: None,
                timeout: None,
            };
            self.device.poll(wait).map_err(|error| error.to_string())?;
            let bytes = |staging: &wgpu::Buffer| match staging.get_mapped_range(..) {
                Ok(range) => Ok(range.to_vec()),
                Err(error) => Err(error.to_string()),
            };
            staged.iter().map(bytes).collect()
        })
    }

    fn make_buffer(&self, buffer: &RunBuffer) -> wgpu::Buffer {
        self.device.create_buffer_init(&BufferInitDescriptor {
            label: None,
            contents: &buffer.bytes,
            usage: match buffer.uniform {
                true => wgpu::BufferUsages::UNIFORM,
                false => wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
            },
        })
    }
}

fn store_first(failure: &Mutex<Option<String>>, text: String) {
    let mut failure = failure.lock().unwrap_or_else(PoisonError::into_inner);
    failure.get_or_insert(text);
}
