//! Texts that do what a shader does and watch it: races within a workgroup ([`crate::races`]), and loops without an end
//! ([`crate::loops`]). What they find stands in a log, one buffer more.

use crate::loops::{LOOP_WORDS, LoopHead, loop_at_fault, watch_loops};
use crate::races::{REPORT_WORDS, RaceReport, watch_accesses};
use crate::tokens::split_tokens;
use wgpu::naga::Module;

/// Name of the log in a watched text, an `array<atomic<u32>>`.
pub const WATCH_LOG: &str = "watch_log";
/// Words of the log that a watched text uses.
pub const WATCH_LOG_WORDS: usize = REPORT_WORDS + LOOP_WORDS;

/// Prefix of the names that are added to a text.
pub(crate) const PREFIX: &str = "watched_";

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

impl WatchedText {
    /// Returns the races in the words that it has left of its part of the log.
    pub fn read_races(&self, words: &[u32]) -> RaceReport {
        RaceReport::read(words, &self.variables)
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
        edits.append(accesses.edits);
        declared.push_str(&accesses.declarations);
        variables = accesses.variables;
    }
    Some(WatchedText {
        text: edits.apply(text) + &declared,
        variables,
        loops,
    })
}

/// Insertions into a text.
#[derive(Default)]
pub(crate) struct Edits(Vec<(usize, String)>);

impl Edits {
    /// Inserts before the byte `at`.
    pub(crate) fn insert(&mut self, at: usize, text: impl Into<String>) {
        self.0.push((at, text.into()));
    }

    /// Adds other insertions; at one place they come behind those before.
    pub(crate) fn append(&mut self, mut other: Self) {
        self.0.append(&mut other.0);
    }

    /// Returns the text with the insertions.
    pub(crate) fn apply(mut self, text: &str) -> String {
        // Insertions at one place keep their order.
        self.0.sort_by_key(|(at, _)| *at);
        let mut result = String::with_capacity(2 * text.len());
        let mut done = 0;
        for (at, inserted) in self.0 {
            result.push_str(&text[done..at]);
            result.push_str(&inserted);
            done = at;
        }
        result.push_str(&text[done..]);
        result
    }
}
