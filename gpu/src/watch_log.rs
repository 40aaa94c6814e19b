//! The log in which shaders for checks count races, and tell of loops without an end.

use crate::bindings::{BufferRange, STORAGE};
use crate::module_text::ModuleText;
use crate::shader_files::SHADER_STAGES;
use common::{Error, Result};
use stage_check::loops::max_loop_turns;
use stage_check::races::RaceReport;
use stage_check::watch::{LogPlace, WATCH_LOG_WORDS, WatchedText, watch_shader};
use stage_check::wgsl::compile;
use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};
use wgpu::naga::AddressSpace;

/// The log, with a part for each shader file.
pub struct WatchLog {
    pub buffer: wgpu::Buffer,
    limits: wgpu::Limits,
    max_loop_turns: u32,
    /// Text of each file of which pipelines were made.
    texts: Mutex<BTreeMap<usize, FileText>>,
}

/// The text of the module of a shader file.
struct FileText {
    watched: WatchedText,
    /// The shader in which each of its counted loops stands.
    loop_stages: Vec<&'static str>,
}

impl WatchLog {
    pub fn new(device: &wgpu::Device) -> Self {
        Self {
            buffer: device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("watch log"),
                size: (4 * WATCH_LOG_WORDS * SHADER_STAGES.len()) as u64,
                usage: STORAGE,
                mapped_at_creation: false,
            }),
            limits: device.limits(),
            max_loop_turns: max_loop_turns(device.adapter_info().device_type),
            texts: Mutex::default(),
        }
    }

    /// Returns what each shader file with workgroup memory has counted, from the words of the buffer, in the order of a solve.
    pub fn race_reports(&self, words: &[u32]) -> Vec<(&'static str, RaceReport)> {
        let parts: Vec<&[u32]> = words.chunks(WATCH_LOG_WORDS).collect();
        let texts = self.lock_texts();
        let report = |(place, text): (&usize, &FileText)| {
            let races = text.watched.read_races(parts[*place]);
            (SHADER_STAGES[*place].name, races)
        };
        texts.iter().map(report).collect()
    }

    /// Returns the range of the buffer that [`Self::check_loops`] reads; none if no loop is counted.
    pub fn loop_range(&self) -> Option<BufferRange<'_>> {
        let counts_loops = self.lock_texts().values().any(|text| !text.loop_stages.is_empty());
        counts_loops.then(|| (&self.buffer, 0, self.buffer.size()))
    }

    /// Checks that all loops have ended, from the words of [`Self::loop_range`].
    ///
    /// Errors: [`Error::Stage`] for one that has no end.
    pub fn check_loops(&self, words: &[u32]) -> Result<()> {
        let texts = self.lock_texts();
        let mut parts = words.chunks(WATCH_LOG_WORDS).enumerate();
        let endless = parts.find_map(|(place, part)| {
            let text = texts.get(&place)?;
            let number = text.watched.find_endless_loop(part)?;
            Some((text.loop_stages[number], &text.watched.loops[number]))
        });
        match endless {
            Some((stage, head)) => Err(Error::Stage {
                stage,
                message: head.to_string(),
            }),
            None => Ok(()),
        }
    }

    /// Returns the text of the module of a shader file that watches its workgroup memory, and its loops if it has a given file;
    /// none where there is neither, or where the device has no place for one more buffer.
    pub fn watch_text(&self, file: &str, module: &ModuleText) -> Option<String> {
        let place = SHADER_STAGES.iter().position(|stage| stage.name == file)?;
        let parsed = module.parse().ok()?;
        let is_storage = |space: AddressSpace| matches!(space, AddressSpace::Storage { .. });
        let buffers = parsed
            .global_variables
            .iter()
            .filter(|(_, variable)| is_storage(variable.space))
            .count();
        if buffers >= self.limits.max_storage_buffers_per_shader_stage as usize {
            return None;
        }
        let log = LogPlace::behind_bindings(&parsed, (WATCH_LOG_WORDS * place) as u32);
        let mut watched = watch_shader(
            &module.text(),
            &parsed,
            log,
            self.limits.max_compute_workgroup_storage_size,
            module.given_file().map(|_| self.max_loop_turns),
        )?;
        // A text that hides a name from its variable is not followed.
        compile(&watched.text, "").ok()?;
        let stages = watched.loops.iter_mut().map(|head| {
            let (stage, line) = module.given_line_at(head.at)?;
            head.line_number = line;
            Some(stage)
        });
        let loop_stages = stages.map(|stage| stage.unwrap_or(SHADER_STAGES[place].name)).collect();
        let made = watched.text.clone();
        self.lock_texts().insert(place, FileText { watched, loop_stages });
        Some(made)
    }

    /// Locks the texts. A panic of another thread leaves only whole ones behind.
    fn lock_texts(&self) -> MutexGuard<'_, BTreeMap<usize, FileText>> {
        self.texts.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
