//! How long a submission takes: by the device's own clock where it has one, else by the host's.

use crate::adapter::{Gpu, TIMESTAMPS};
use crate::host::Host;
use common::Result;
use std::time::Instant;

/// Measures one submission at a time.
pub enum Clock {
    Host,
    Device(wgpu::QuerySet),
}

impl Clock {
    /// Timestamps where [`Gpu::open_timed`] got them.
    pub fn new(gpu: &Gpu) -> Self {
        if !gpu.device.features().contains(TIMESTAMPS) {
            return Self::Host;
        }
        let descriptor = wgpu::QuerySetDescriptor {
            label: Some("clock"),
            ty: wgpu::QueryType::Timestamp,
            count: 2,
        };
        Self::Device(gpu.device.create_query_set(&descriptor))
    }

    /// Seconds of what `record` records.
    pub fn seconds(
        &self,
        host: &mut Host,
        record: impl FnOnce(&mut wgpu::CommandEncoder),
    ) -> Result<f64> {
        let mut encoder = host.encoder();
        let Self::Device(queries) = self else {
            record(&mut encoder);
            let start = Instant::now();
            let submission = host.send(encoder);
            host.until(submission)?;
            return Ok(start.elapsed().as_secs_f64());
        };
        let resolved = host.gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("timestamps"),
            size: 16,
            usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        encoder.write_timestamp(queries, 0);
        record(&mut encoder);
        encoder.write_timestamp(queries, 1);
        encoder.resolve_query_set(queries, 0..2, &resolved, 0);
        let staging = host.staging(16);
        encoder.copy_buffer_to_buffer(&resolved, 0, &staging, 0, 16);
        let ticks: Vec<u64> = bytemuck::pod_collect_to_vec(&host.finish(encoder, staging)?);
        let period = f64::from(host.gpu.queue.get_timestamp_period());
        Ok(ticks[1].saturating_sub(ticks[0]) as f64 * period * 1e-9)
    }
}
