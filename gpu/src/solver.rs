//! The GPU engine of the shooting loop: batches of shots, each chosen on the device.

use crate::adapter::Gpu;
use crate::batch::Recorder;
use crate::buffers::{BATCH, Buffers, LOG_BYTES};
use crate::pipelines::Pipelines;
use crate::records::{LOG_HEAD_BYTES, LogRecord, Params, TexelRecord, rule_bits};
use crate::shaders::Fault;
use bytemuck::{bytes_of, cast_slice, pod_collect_to_vec};
use common::Result;
use common::constants::{LANES, LEVELS};
use common::escape::DIRECTIONS;
use common::mesh::{Mesh, Texel};
use common::settings::Settings;
use common::shooting::{Engine, Field, Order, Rule, Shot};
use glam::{Vec3, Vec4};
use std::collections::VecDeque;
use std::ops::ControlFlow;
use std::sync::mpsc::{Receiver, channel};
use std::time::Instant;

/// A submission should take about this long: far below the seconds after which drivers kill one.
const SUBMISSION_SECONDS: f64 = 0.5;
/// Submissions of fewer shots than this pay only where a shot is slow.
const FEWEST: u32 = 64;
/// Shots of the first submission of a run.
const FIRST: u32 = 8;
/// Longer than this, even a few shots are too many for one submission.
const LONGEST_SECONDS: f64 = 1.5;
/// Batches recorded while an earlier one runs.
const IN_FLIGHT: usize = 2;

/// Progressive refinement on a GPU.
pub struct GpuSolver<'a> {
    gpu: Gpu,
    mesh: &'a Mesh,
    settings: Settings,
    buffers: Buffers,
    pipelines: Pipelines,
    /// Submissions and buffer mappings so far.
    counts: Counts,
    rule: Rule,
    /// Seconds that a shot takes, as measured so far.
    shot_seconds: Option<f64>,
}

/// How often the host talked to the device.
#[derive(Clone, Copy, Debug, Default)]
pub struct Counts {
    /// Queue submissions.
    pub submissions: u32,
    /// `map_async` calls.
    pub maps: u32,
}

/// A batch that runs.
struct Flight {
    staging: wgpu::Buffer,
    mapped: Receiver<std::result::Result<(), wgpu::BufferAsyncError>>,
    submission: wgpu::SubmissionIndex,
    shots: u32,
    start: Instant,
}

impl<'a> GpuSolver<'a> {
    /// A solver in its initial state: B = r = E.
    pub fn new(gpu: &Gpu, mesh: &'a Mesh, settings: &Settings) -> Result<Self> {
        Self::with_faults(gpu, mesh, settings, &[])
    }

    /// A solver whose shaders are wrong in stated places.
    pub fn with_faults(
        gpu: &Gpu,
        mesh: &'a Mesh,
        settings: &Settings,
        faults: &[Fault],
    ) -> Result<Self> {
        let buffers = Buffers::new(gpu, mesh, settings)?;
        let pipelines = Pipelines::new(gpu, settings, &buffers, faults)?;
        gpu.check()?;
        let solver = Self {
            gpu: gpu.clone(),
            mesh,
            settings: settings.clone(),
            buffers,
            pipelines,
            counts: Counts::default(),
            rule: Rule::PLAIN,
            shot_seconds: None,
        };
        solver.write_params(0.0, false);
        Ok(solver)
    }

    /// Submissions and mappings so far.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// The item buffer of the latest shot: face IDs + 1, row-major, 0 where nothing was drawn.
    pub fn item_buffer(&mut self) -> Result<Vec<u32>> {
        let size = self.settings.item_buffer;
        // Rows of a texture copy are aligned to 256 bytes.
        let row = (size * 4).next_multiple_of(256);
        let staging = self.staging(u64::from(row) * u64::from(size));
        let mut encoder = self.encoder();
        encoder.copy_texture_to_buffer(
            self.buffers.item_buffer.as_image_copy(),
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
        let bytes = self.finish(encoder, &staging)?;
        Ok(bytes
            .chunks(row as usize)
            .flat_map(|line| pod_collect_to_vec::<u8, u32>(&line[..size as usize * 4]))
            .collect())
    }

    /// The irradiance of every texel; w is the form factor of the latest shot where it was seen.
    pub fn irradiance(&mut self) -> Result<Vec<Vec4>> {
        let size = self.buffers.irradiance.size();
        let staging = self.staging(size);
        let mut encoder = self.encoder();
        encoder.copy_buffer_to_buffer(&self.buffers.irradiance, 0, &staging, 0, size);
        Ok(pod_collect_to_vec(&self.finish(encoder, &staging)?))
    }

    fn encoder(&self) -> wgpu::CommandEncoder {
        self.gpu.device.create_command_encoder(&Default::default())
    }

    /// A buffer to read from, poisoned: what is not copied into it reads as NaN.
    fn staging(&self, size: u64) -> wgpu::Buffer {
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

    fn submit(
        &mut self,
        encoder: wgpu::CommandEncoder,
        staging: &wgpu::Buffer,
    ) -> (
        wgpu::SubmissionIndex,
        Receiver<std::result::Result<(), wgpu::BufferAsyncError>>,
    ) {
        let submission = self.gpu.queue.submit([encoder.finish()]);
        let (sender, mapped) = channel();
        staging.map_async(wgpu::MapMode::Read, .., move |result| {
            // The receiver is gone only when the run was abandoned.
            let _ = sender.send(result);
        });
        self.counts.submissions += 1;
        self.counts.maps += 1;
        (submission, mapped)
    }

    fn finish(&mut self, encoder: wgpu::CommandEncoder, staging: &wgpu::Buffer) -> Result<Vec<u8>> {
        let (submission, mapped) = self.submit(encoder, staging);
        self.wait(submission, &mapped, staging)
    }

    fn wait(
        &self,
        submission: wgpu::SubmissionIndex,
        mapped: &Receiver<std::result::Result<(), wgpu::BufferAsyncError>>,
        staging: &wgpu::Buffer,
    ) -> Result<Vec<u8>> {
        let wait = wgpu::PollType::Wait {
            submission_index: Some(submission),
            timeout: None,
        };
        let polled = self.gpu.device.poll(wait);
        self.gpu.check()?;
        polled.map_err(|error| self.gpu.fail(&error.to_string()))?;
        let lost = || self.gpu.fail("the result could not be read back");
        mapped.try_recv().map_err(|_| lost())?.map_err(|_| lost())?;
        let bytes = staging.get_mapped_range(..).map_err(|_| lost())?.to_vec();
        staging.unmap();
        Ok(bytes)
    }

    fn write_params(&self, threshold: f32, replay: bool) {
        let params = Params {
            texels: self.mesh.texels.len() as u32,
            cells: self.mesh.cells.len() as u32,
            faces: self.mesh.faces.len() as u32,
            replay: replay.into(),
            threshold,
            unit: self.mesh.unit as f32,
            places: self.buffers.places,
            step: self.buffers.step,
            samples: self.mesh.samples,
            conserve: self.settings.conserve.into(),
            room: self.mesh.room,
            rule: rule_bits(self.rule),
            groups: [
                self.groups(self.mesh.texels.len().div_ceil(LANES)),
                self.groups(DIRECTIONS.div_ceil(LANES)),
                self.groups(self.mesh.cells.len()),
            ],
        };
        self.gpu
            .queue
            .write_buffer(&self.buffers.params, 0, bytes_of(&params));
    }

    /// Workgroups in two dimensions where one does not hold them.
    fn groups(&self, count: usize) -> [u32; 4] {
        let most = self
            .gpu
            .device
            .limits()
            .max_compute_workgroups_per_dimension;
        let x = (count as u32).min(most);
        [x, (count as u32).div_ceil(x.max(1)), 1, 0]
    }

    fn recorder(&self) -> Recorder<'_> {
        Recorder {
            buffers: &self.buffers,
            pipelines: &self.pipelines,
            mesh: self.mesh,
        }
    }

    /// How many shots the next submission holds: few at first, because nothing is known of their
    /// length and a short solve should not end in empty shots; at most doubled each time.
    fn batch_size(&self, launched: u32, left: u32) -> u32 {
        let shots = match self.shot_seconds {
            None => FIRST,
            Some(seconds) => {
                let most = if self.gpu.line.software {
                    f64::INFINITY
                } else {
                    LONGEST_SECONDS
                };
                let fewest = f64::from(FEWEST).min(most / seconds);
                (SUBMISSION_SECONDS / seconds)
                    .max(fewest)
                    .clamp(1.0, f64::from(BATCH)) as u32
            }
        };
        shots.min(launched.max(FIRST)).min(left)
    }

    /// Records and submits `shots` shots; the first batch of a run chooses its shooter itself.
    fn launch(&mut self, order: Order, done: u32, shots: u32) -> Flight {
        if let Order::Replay(log) = order {
            let from = (done as usize).min(log.len());
            let mut script = log[from..log.len().min(from + shots as usize + 1)].to_vec();
            script.resize(shots as usize + 1, u32::MAX);
            self.gpu
                .queue
                .write_buffer(&self.buffers.script, 0, cast_slice(&script));
        }
        let staging = self.staging(LOG_BYTES);
        let mut encoder = self.encoder();
        let recorder = self.recorder();
        recorder.clear_log(&mut encoder);
        if done == 0 {
            recorder.power(&mut encoder, self.groups(self.mesh.cells.len()));
            recorder.first(&mut encoder);
        }
        for _ in 0..shots {
            recorder.shot(&mut encoder);
        }
        recorder.copy_log(&mut encoder, &staging);
        let start = Instant::now();
        let (submission, mapped) = self.submit(encoder, &staging);
        Flight {
            staging,
            mapped,
            submission,
            shots,
            start,
        }
    }

    fn land(&mut self, flight: Flight, previous: &mut Instant) -> Result<Vec<Shot>> {
        let bytes = self.wait(flight.submission, &flight.mapped, &flight.staging)?;
        // A batch starts when it is submitted or when the one before it ends.
        let seconds = flight.start.max(*previous).elapsed().as_secs_f64();
        *previous = Instant::now();
        self.shot_seconds = Some((seconds / f64::from(flight.shots)).max(1e-7));
        let count = u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
        if count > flight.shots {
            return Err(self.gpu.fail("the log of the shots is damaged"));
        }
        let records: Vec<LogRecord> = pod_collect_to_vec(&bytes[LOG_HEAD_BYTES as usize..]);
        Ok(records[..count as usize].iter().map(Shot::from).collect())
    }
}

impl Engine for GpuSolver<'_> {
    fn cell_power(&mut self) -> Result<Vec<f32>> {
        let size = self.buffers.sums.size();
        let staging = self.staging(size);
        let mut encoder = self.encoder();
        self.recorder()
            .power(&mut encoder, self.groups(self.mesh.cells.len()));
        encoder.copy_buffer_to_buffer(&self.buffers.sums, 0, &staging, 0, size);
        let sums: Vec<Vec4> = pod_collect_to_vec(&self.finish(encoder, &staging)?);
        Ok(sums.iter().map(|sum| sum.w).collect())
    }

    fn shoot(&mut self, cell: u32) -> Result<Shot> {
        let mut done = None;
        self.run(Order::Replay(&[cell]), 1, &mut |shot| {
            done = Some(*shot);
            ControlFlow::Continue(())
        })?;
        done.ok_or_else(|| self.gpu.fail("a shot left no record"))
    }

    fn field(&mut self) -> Result<Field> {
        let size = self.buffers.radiosity.size();
        let staging = self.staging(3 * size);
        let mut encoder = self.encoder();
        let b = &self.buffers;
        for (k, buffer) in (0..).zip([&b.radiosity, &b.residual, &b.irradiance]) {
            encoder.copy_buffer_to_buffer(buffer, 0, &staging, k * size, size);
        }
        let values: Vec<Vec4> = pod_collect_to_vec(&self.finish(encoder, &staging)?);
        let part = |k: usize| {
            values[k * self.mesh.texels.len()..(k + 1) * self.mesh.texels.len()].to_vec()
        };
        Ok(Field {
            origin: format!("gpu: {}", self.gpu.line.name),
            radiosity: part(0),
            residual: part(1),
            irradiance: part(2),
        })
    }

    fn restart(&mut self, rule: Rule, reflectance: &[Vec3], field: &Field) -> Result<()> {
        self.rule = rule;
        let texels: Vec<TexelRecord> = self
            .mesh
            .texels
            .iter()
            .zip(reflectance)
            .map(|(texel, reflectance)| {
                TexelRecord::from(&Texel {
                    reflectance: *reflectance,
                    ..*texel
                })
            })
            .collect();
        let (queue, b) = (&self.gpu.queue, &self.buffers);
        queue.write_buffer(&b.texels, 0, cast_slice(&texels));
        queue.write_buffer(&b.radiosity, 0, cast_slice(&field.radiosity));
        queue.write_buffer(&b.residual, 0, cast_slice(&field.residual));
        queue.write_buffer(&b.irradiance, 0, cast_slice(&field.irradiance));
        self.gpu.check()
    }

    /// Two batches are always under way; the log of one is read while the next one runs.
    fn run(
        &mut self,
        order: Order,
        max_shots: u32,
        watch: &mut dyn FnMut(&Shot) -> ControlFlow<()>,
    ) -> Result<()> {
        let (threshold, max_shots) = match order {
            Order::Greedy { threshold } => (threshold, max_shots),
            Order::Replay(log) => (0.0, max_shots.min(log.len() as u32)),
        };
        self.write_params(threshold, matches!(order, Order::Replay(_)));
        let mut flights = VecDeque::new();
        let mut launched = 0;
        let mut ended = false;
        let mut previous = Instant::now();
        loop {
            while !ended && flights.len() < IN_FLIGHT && launched < max_shots {
                let shots = self.batch_size(launched, max_shots - launched);
                flights.push_back(self.launch(order, launched, shots));
                launched += shots;
            }
            let Some(flight) = flights.pop_front() else {
                return Ok(());
            };
            let asked = flight.shots;
            let shots = self.land(flight, &mut previous)?;
            ended |= (shots.len() as u32) < asked;
            for shot in &shots {
                ended |= watch(shot).is_break();
            }
        }
    }
}

// The draw arguments and the lists of instances are laid out for this many levels.
const _: () = assert!(LEVELS == 8);
