//! Texts that do what a shader does and watch it: races within a workgroup ([`crate::races`]), and loops without an end
//! ([`crate::loops`]). What they find stands in a log, one buffer more.

pub use crate::edits::WATCH_LOG;

use crate::loops::{LOOP_WORDS, LoopHead, loop_at_fault, watch_loops};
use crate::races::{REPORT_WORDS, RaceReport, watch_accesses};
use crate::tokens::split_tokens;
use wgpu::naga::Module;

/// Words of the log that a watched text uses.
pub const WATCH_LOG_WORDS: usize = REPORT_WORDS + LOOP_WORDS;

/// A shader that watches what it does.
#[derive(Clone, Debug)]
pub struct WatchedText {
    /// The WGSL, with the buffer [`WATCH_LOG`].
    pub text: String,
    /// Names of the variables whose accesses are watched.
    pub variables: Vec<String>,
    /// Loops whose turns are counted.
    pub loops: Vec<LoopHead>,
}

/// Where a watched text writes what it finds.
#[derive(Clone, Copy, Debug)]
pub struct LogPlace {
    /// Bind group of the buffer.
    pub group: u32,
    /// Binding of the buffer.
    pub binding: u32,
    /// First word.
    pub first: u32,
}

impl LogPlace {
    /// Places the log at the first binding of group 0 behind those of a module.
    pub fn behind_bindings(module: &Module, first: u32) -> Self {
        let variables = module.global_variables.iter();
        let bound = variables.filter_map(|(_, variable)| variable.binding);
        let own_group = bound.filter(|place| place.group == 0);
        Self {
            group: 0,
            binding: own_group.map(|place| place.binding + 1).max().unwrap_or(0),
            first,
        }
    }
}

impl WatchedText {
    /// Returns the races in the words that it has left of its part of the log.
    pub fn read_races(&self, words: &[u32]) -> RaceReport {
        RaceReport::from_words(words, &self.variables)
    }

    /// Returns the number of a loop without an end in those words, if there is one.
    pub fn find_endless_loop(&self, words: &[u32]) -> Option<usize> {
        let number = loop_at_fault(*words.get(REPORT_WORDS)?)?;
        (number < self.loops.len()).then_some(number)
    }
}

/// Returns a text that does what `text` does, from which naga made `module`, and watches its workgroup memory, and its loops, which
/// end after `max_turns` if given; none if there is neither. Workgroup memory is not watched if that would need more than `max_bytes` of it.
pub fn watch_shader(
    text: &str,
    module: &Module,
    place: LogPlace,
    max_bytes: u32,
    max_turns: Option<u32>,
) -> Option<WatchedText> {
    let tokens = split_tokens(text);
    let LogPlace { group, binding, first } = place;
    let accesses = watch_accesses((text, &tokens), module, first, max_bytes);
    let counted = max_turns.map(|most| watch_loops((text, &tokens), most, first + REPORT_WORDS as u32));
    let (mut edits, loops, counting) = counted.unwrap_or_default();
    if accesses.is_none() && loops.is_empty() {
        return None;
    }
    let log =
        format!("\n@group({group}) @binding({binding}) var<storage, read_write> {WATCH_LOG}: array<atomic<u32>>;\n");
    let mut declared = log + &counting;
    let mut variables = Vec::new();
    if let Some(accesses) = accesses {
        edits.append_all(accesses.edits);
        declared.push_str(&accesses.declarations);
        variables = accesses.variables;
    }
    Some(WatchedText {
        text: edits.apply_to(text) + &declared,
        variables,
        loops,
    })
}
