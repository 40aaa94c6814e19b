//! The host's end of the queue: submissions, and what is read back from them.

use crate::adapter::Gpu;
use bytemuck::{Pod, cast_slice, pod_collect_to_vec};
use common::Result;
use std::sync::mpsc::{Receiver, channel};

/// How often the host talked to the device.
#[derive(Clone, Copy, Debug, Default)]
pub struct Counts {
    /// Queue submissions.
    pub submissions: u32,
    /// `map_async` calls.
    pub maps: u32,
}

/// Who submits and reads back.
pub struct Host {
    pub gpu: Gpu,
    pub counts: Counts,
}

/// What a submission will have written.
pub struct Pending {
    staging: wgpu::Buffer,
    mapped: Receiver<std::result::Result<(), wgpu::BufferAsyncError>>,
    submission: wgpu::SubmissionIndex,
}

impl Host {
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            gpu: gpu.clone(),
            counts: Counts::default(),
        }
    }

    pub fn encoder(&self) -> wgpu::CommandEncoder {
        self.gpu.device.create_command_encoder(&Default::default())
    }

    /// A buffer to read from, poisoned: what is not copied into it reads as NaN.
    pub fn staging(&self, size: u64) -> wgpu::Buffer {
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

    /// Workgroups in two dimensions where one does not hold them.
    pub fn groups(&self, count: usize) -> [u32; 4] {
        let limits = self.gpu.device.limits();
        let x = (count as u32).min(limits.max_compute_workgroups_per_dimension);
        [x, (count as u32).div_ceil(x.max(1)), 1, 0]
    }

    /// Writes to a buffer before the next submission.
    pub fn write<T: Pod>(&self, buffer: &wgpu::Buffer, data: &[T]) {
        self.write_at(buffer, 0, data);
    }

    /// The same from so many bytes on.
    pub fn write_at<T: Pod>(&self, buffer: &wgpu::Buffer, at: u64, data: &[T]) {
        self.gpu.queue.write_buffer(buffer, at, cast_slice(data));
    }

    /// Submits work that nobody reads back.
    pub fn send(&mut self, encoder: wgpu::CommandEncoder) -> wgpu::SubmissionIndex {
        self.counts.submissions += 1;
        self.gpu.queue.submit([encoder.finish()])
    }

    /// Submits work that writes `staging`.
    pub fn submit(&mut self, encoder: wgpu::CommandEncoder, staging: wgpu::Buffer) -> Pending {
        let submission = self.send(encoder);
        let (sender, mapped) = channel();
        staging.map_async(wgpu::MapMode::Read, .., move |result| {
            // The receiver is gone only when the run was abandoned.
            let _ = sender.send(result);
        });
        self.counts.maps += 1;
        Pending {
            staging,
            mapped,
            submission,
        }
    }

    /// The bytes that were written.
    pub fn wait(&self, pending: Pending) -> Result<Vec<u8>> {
        self.until(pending.submission)?;
        let lost = || self.gpu.fail("the result could not be read back");
        // Another thread that waits for the same device may be the one that is told.
        pending
            .mapped
            .recv()
            .map_err(|_| lost())?
            .map_err(|_| lost())?;
        let bytes = pending.staging.get_mapped_range(..).map_err(|_| lost())?;
        Ok(bytes.to_vec())
    }

    /// Waits for a submission.
    pub fn until(&self, submission: wgpu::SubmissionIndex) -> Result<()> {
        let wait = wgpu::PollType::Wait {
            submission_index: Some(submission),
            timeout: None,
        };
        let polled = self.gpu.device.poll(wait);
        self.gpu.check()?;
        polled.map_err(|error| self.gpu.fail(&error.to_string()))?;
        Ok(())
    }

    /// Submits and waits.
    pub fn finish(
        &mut self,
        encoder: wgpu::CommandEncoder,
        staging: wgpu::Buffer,
    ) -> Result<Vec<u8>> {
        let pending = self.submit(encoder, staging);
        self.wait(pending)
    }

    /// The first `size`² pixels of a texture of IDs, row-major.
    pub fn ids(&mut self, texture: &wgpu::Texture, size: u32) -> Result<Vec<u32>> {
        // Rows of a texture copy are aligned to 256 bytes.
        let row = (size * 4).next_multiple_of(256);
        let staging = self.staging(u64::from(row) * u64::from(size));
        let mut encoder = self.encoder();
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
            wgpu::Extent3d {
                width: size,
                height: size,
                depth_or_array_layers: 1,
            },
        );
        let bytes = self.finish(encoder, staging)?;
        Ok(bytes
            .chunks(row as usize)
            .flat_map(|line| pod_collect_to_vec::<u8, u32>(&line[..size as usize * 4]))
            .collect())
    }
}
