//! The host's end of the queue: submissions and read-backs.

use crate::adapter::Gpu;
use crate::bindings::BufferRange;
use bytemuck::{Pod, cast_slice, pod_collect_to_vec};
use common::Result;
use futures_channel::oneshot::{Receiver, channel};

/// Counts of submissions and read-backs.
#[derive(Clone, Copy, Debug, Default)]
pub struct QueueCounts {
    /// Queue submissions.
    pub submissions: u32,
    /// `map_async` calls.
    pub maps: u32,
}

/// The queue of a device.
pub struct DeviceQueue {
    pub gpu: Gpu,
    pub counts: QueueCounts,
}

/// A read-back of a submission under way.
pub struct PendingRead {
    staging: wgpu::Buffer,
    mapped: Receiver<std::result::Result<(), wgpu::BufferAsyncError>>,
    submission: wgpu::SubmissionIndex,
    /// Number of bytes behind the others that tell of loops without an end.
    log_bytes: u64,
}

impl DeviceQueue {
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            gpu: gpu.clone(),
            counts: QueueCounts::default(),
        }
    }

    pub fn command_encoder(&self) -> wgpu::CommandEncoder {
        self.gpu.device.create_command_encoder(&Default::default())
    }

    /// Splits `count` workgroups over two dimensions where one does not hold them.
    pub fn split_workgroups(&self, count: usize) -> [u32; 3] {
        let limits = self.gpu.device.limits();
        let x = (count as u32).min(limits.max_compute_workgroups_per_dimension);
        [x, (count as u32).div_ceil(x.max(1)), 1]
    }

    /// Writes to a buffer before the next submission.
    pub fn write<T: Pod>(&self, buffer: &wgpu::Buffer, data: &[T]) {
        self.write_at(buffer, 0, data);
    }

    /// Writes to a buffer from byte `at` on, before the next submission.
    pub fn write_at<T: Pod>(&self, buffer: &wgpu::Buffer, at: u64, data: &[T]) {
        self.gpu.queue.write_buffer(buffer, at, cast_slice(data));
    }

    /// Submits work without a read-back.
    pub fn submit_work(&mut self, encoder: wgpu::CommandEncoder) -> wgpu::SubmissionIndex {
        self.counts.submissions += 1;
        let commands = encoder.finish();
        // A software adapter may wait here for the submission before.
        self.gpu.call_clock.time_call(|| self.gpu.queue.submit([commands]))
    }

    /// Submits work, and then the read-back of these ranges of buffers.
    pub fn submit_read(&mut self, mut encoder: wgpu::CommandEncoder, ranges: &[BufferRange]) -> PendingRead {
        let log = self.gpu.watch_log.clone();
        let watched = log.as_ref().and_then(|log| log.loop_range());
        let log_bytes = watched.map_or(0, |(_, _, bytes)| bytes);
        let ranges = || ranges.iter().copied().chain(watched);
        let staging = self.staging_buffer(ranges().map(|(_, _, bytes)| bytes).sum());
        let mut at = 0;
        for (buffer, from, bytes) in ranges() {
            encoder.copy_buffer_to_buffer(buffer, from, &staging, at, bytes);
            at += bytes;
        }
        self.submit_mapping(encoder, staging, log_bytes)
    }

    fn submit_mapping(&mut self, encoder: wgpu::CommandEncoder, staging: wgpu::Buffer, log_bytes: u64) -> PendingRead {
        let submission = self.submit_work(encoder);
        let (sender, mapped) = channel();
        staging.map_async(wgpu::MapMode::Read, .., move |result| {
            // The receiver is gone only when the run was abandoned.
            let _ = sender.send(result);
        });
        self.counts.maps += 1;
        PendingRead {
            staging,
            mapped,
            submission,
            log_bytes,
        }
    }

    /// Creates a buffer to read back, filled with NaN: bytes that no copy writes are noticed.
    fn staging_buffer(&self, size: u64) -> wgpu::Buffer {
        let staging = self.gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("staging"),
            size,
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: true,
        });
        if let Ok(mut range) = staging.get_mapped_range_mut(..) {
            range.slice(..).fill(0xff);
        }
        staging.unmap();
        staging
    }

    /// Awaits the bytes of a read-back.
    ///
    /// Errors: the device fails; a loop of a watched shader has no end.
    pub async fn request_bytes(&self, pending: PendingRead) -> Result<Vec<u8>> {
        self.poll_submission(pending.submission)?;
        let lost = || self.gpu.device_error("the result could not be read back");
        // A browser runs the callback later, and so may another thread that waits for the same device.
        let mapped = pending.mapped.await;
        self.gpu.check_errors()?;
        mapped.map_err(|_| lost())?.map_err(|_| lost())?;
        let mapped = pending.staging.get_mapped_range(..).map_err(|_| lost())?;
        let mut bytes = mapped.to_vec();
        let told = bytes.split_off(bytes.len() - pending.log_bytes as usize);
        if let Some(log) = &self.gpu.watch_log {
            log.check_loops(&pod_collect_to_vec(&told))?;
        }
        Ok(bytes)
    }

    /// Waits for a submission to end.
    pub fn wait_for_submission(&self, submission: wgpu::SubmissionIndex) -> Result<()> {
        pollster::block_on(self.request_submission(submission))
    }

    /// Awaits the end of a submission.
    pub async fn request_submission(&self, submission: wgpu::SubmissionIndex) -> Result<()> {
        self.poll_submission(submission)?;
        self.gpu.request_errors().await
    }

    /// Waits for a submission to end, so that its callbacks have run; a browser does not wait.
    fn poll_submission(&self, submission: wgpu::SubmissionIndex) -> Result<()> {
        let wait = wgpu::PollType::Wait {
            submission_index: Some(submission),
            timeout: None,
        };
        let polled = self.gpu.call_clock.time_call(|| self.gpu.device.poll(wait));
        self.gpu.check_errors()?;
        polled.map_err(|error| self.gpu.device_error(&error.to_string()))?;
        Ok(())
    }

    /// Submits work, waits, and returns the values in these ranges of buffers.
    pub fn read_back<T: Pod>(&mut self, encoder: wgpu::CommandEncoder, ranges: &[BufferRange]) -> Result<Vec<T>> {
        pollster::block_on(self.request_values(encoder, ranges))
    }

    /// Submits work, and awaits the values in these ranges of buffers.
    pub async fn request_values<T: Pod>(
        &mut self,
        encoder: wgpu::CommandEncoder,
        ranges: &[BufferRange<'_>],
    ) -> Result<Vec<T>> {
        let pending = self.submit_read(encoder, ranges);
        Ok(pod_collect_to_vec(&self.request_bytes(pending).await?))
    }

    /// Awaits the first `size`² pixels of a texture of IDs, row-major.
    pub async fn request_item_buffer(&mut self, texture: &wgpu::Texture, size: u32) -> Result<Vec<u32>> {
        // Rows of a texture copy are aligned to 256 bytes.
        let row = (size * 4).next_multiple_of(256);
        let staging = self.staging_buffer(u64::from(row) * u64::from(size));
        let mut encoder = self.command_encoder();
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &staging,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(row),
                    rows_per_image: None,
                },
            },
            square_extent(size),
        );
        let pending = self.submit_mapping(encoder, staging, 0);
        Ok(self
            .request_bytes(pending)
            .await?
            .chunks(row as usize)
            .flat_map(|line| pod_collect_to_vec::<u8, u32>(&line[..size as usize * 4]))
            .collect())
    }

    /// Writes the first `size`² pixels of a texture of IDs, row-major, before the next submission.
    pub fn write_item_buffer(&self, texture: &wgpu::Texture, size: u32, ids: &[u32]) {
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(size * 4),
            rows_per_image: None,
        };
        let target = texture.as_image_copy();
        self.gpu
            .queue
            .write_texture(target, cast_slice(ids), layout, square_extent(size));
    }
}

/// Returns the extent of a square texture.
fn square_extent(size: u32) -> wgpu::Extent3d {
    wgpu::Extent3d {
        width: size,
        height: size,
        depth_or_array_layers: 1,
    }
}
