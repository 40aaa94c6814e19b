//! The log in which shaders that watch their workgroup memory count races.

use crate::bindings::STORAGE;
use crate::module_text::ModuleText;
use crate::shader_files::SHADER_STAGES;
use stage_check::races::{LogPlace, RACE_LOG_WORDS, RaceReport, WatchedText, watch_accesses};
use stage_check::wgsl::compile;
use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};
use wgpu::naga::AddressSpace;

/// The log, with a part for each shader file.
pub struct RaceLog {
    pub buffer: wgpu::Buffer,
    limits: wgpu::Limits,
    /// Text of each file of which pipelines were made.
    texts: Mutex<BTreeMap<usize, WatchedText>>,
}

impl RaceLog {
    pub fn new(device: &wgpu::Device) -> Self {
        Self {
            buffer: device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("race log"),
                size: (4 * RACE_LOG_WORDS * SHADER_STAGES.len()) as u64,
                usage: STORAGE,
                mapped_at_creation: false,
            }),
            limits: device.limits(),
            texts: Mutex::default(),
        }
    }

    /// Returns what each shader file with workgroup memory has counted, from the words of the buffer, in the order of a solve.
    pub fn reports(&self, words: &[u32]) -> Vec<(&'static str, RaceReport)> {
        let parts: Vec<&[u32]> = words.chunks(RACE_LOG_WORDS).collect();
        let texts = self.texts.lock().unwrap_or_else(PoisonError::into_inner);
        let report = |(place, text): (&usize, &WatchedText)| (SHADER_STAGES[*place].name, text.read_log(parts[*place]));
        texts.iter().map(report).collect()
    }

    /// Returns the text of the module of a shader file that watches its accesses; none where it has no workgroup memory that can
    /// be watched, or where the device has no place for one more buffer.
    pub fn watch_text(&self, file: &str, module: &ModuleText) -> Option<String> {
        let place = SHADER_STAGES.iter().position(|stage| stage.name == file)?;
        let parsed = module.parse().ok()?;
        let bound = || parsed.global_variables.iter().map(|(_, variable)| variable);
        let is_storage = |space: AddressSpace| matches!(space, AddressSpace::Storage { .. });
        let buffers = bound().filter(|variable| is_storage(variable.space)).count();
        if buffers >= self.limits.max_storage_buffers_per_shader_stage as usize {
            return None;
        }
        let last = bound()
            .filter_map(|variable| variable.binding)
            .map(|place| place.binding)
            .max();
        let log = LogPlace {
            group: 0,
            binding: last.map_or(0, |last| last + 1),
            first: (RACE_LOG_WORDS * place) as u32,
        };
        let watched = watch_accesses(
            &module.text(),
            &parsed,
            log,
            self.limits.max_compute_workgroup_storage_size,
        )?;
        // A text that hides a name from its variable is not followed.
        compile(&watched.text, "").ok()?;
        let mut texts = self.texts.lock().unwrap_or_else(PoisonError::into_inner);
        Some(texts.entry(place).insert_entry(watched).get().text.clone())
    }
}
