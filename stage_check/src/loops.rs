//! Loops without an end, found by a text of the same shader that counts the turns of each lane and leaves all loops after too
//! many. A software adapter may leave them by itself, so that a faulty shader ends with the values of a sound one.
//!
//! Of several loops that are left, such as a loop and the one around it, the one of most turns since its start is at fault. All
//! lanes of a workgroup take the same turns of a loop with a barrier, and must leave it together: it is left after too many of
//! its own.

use crate::edits::{NAME_PREFIX, TextInsertions, WATCH_LOG};
use crate::races::{STORAGE_BARRIER, UNIFORM_LOAD, WORKGROUP_BARRIER};
use crate::tokens::Token;
use std::fmt;

/// Turns of a lane after which a software adapter leaves its loops: half of those that lavapipe allows in all loops of eight lanes.
pub const MAX_SOFTWARE_TURNS: u32 = 1 << 15;
/// Turns of a lane after which hardware leaves its loops: less than a second, as drivers end a longer call.
pub const MAX_HARDWARE_TURNS: u32 = 1 << 22;

/// Words of the log that counted loops take.
pub(crate) const LOOP_WORDS: usize = 1;
/// Bits of that word that hold the number of a loop, and 1; those above hold its turns, 65 535 at most.
const LOOP_NUMBER_BITS: u32 = 16;

/// Turns of a lane in all loops without a barrier.
const ALL_TURNS: &str = "watched_turns";
/// Statements that are loops.
const LOOP_STATEMENTS: [&str; 3] = ["for", "while", "loop"];
/// Calls at which lanes wait for each other.
const BARRIER_CALLS: [&str; 3] = [WORKGROUP_BARRIER, STORAGE_BARRIER, UNIFORM_LOAD];

/// A loop whose turns are counted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LoopHead {
    /// Its first byte in the text.
    pub at: usize,
    /// The number of its line, from 1.
    pub line_number: usize,
    /// The rest of that line.
    pub line: String,
    /// Turns after which it is left.
    pub max_turns: u32,
}

impl fmt::Display for LoopHead {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Self {
            line_number,
            line,
            max_turns,
            ..
        } = self;
        write!(
            f,
            "line {line_number}: the loop `{line}` does not end within {max_turns} turns"
        )
    }
}

/// Returns the turns of a lane after which an adapter of this kind leaves its loops.
pub fn max_loop_turns(kind: wgpu::DeviceType) -> u32 {
    match kind {
        wgpu::DeviceType::Cpu => MAX_SOFTWARE_TURNS,
        _ => MAX_HARDWARE_TURNS,
    }
}

/// Counts the turns of the loops of a text, which a lane leaves after `max_turns`. Returns the insertions, the loops, and what the
/// text declares beside its own; word `word` of the log tells of the loops that were left.
pub(crate) fn watch_loops(
    (text, tokens): (&str, &[Token]),
    max_turns: u32,
    word: u32,
) -> (TextInsertions, Vec<LoopHead>, String) {
    let mut edits = TextInsertions::default();
    let mut loops = Vec::new();
    let is = |token: &Token, words: &[&str]| words.contains(&&text[token.range.clone()]);
    for (k, head) in tokens.iter().enumerate() {
        let at = head.range.start;
        if !is(head, &LOOP_STATEMENTS) {
            continue;
        }
        let find_sign = |sign: &str| {
            let mut rest = tokens[k..].iter();
            rest.position(|token| token.depth == head.depth && is(token, &[sign]))
        };
        let (Some(open), Some(close)) = (find_sign("{"), find_sign("}")) else {
            continue;
        };
        let number = loops.len();
        let body = &tokens[k + open..k + close.max(open)];
        let own = format!("{NAME_PREFIX}turns_{number}");
        let (count, limited) = match body.iter().any(|token| is(token, &BARRIER_CALLS)) {
            true => (String::new(), own.as_str()),
            false => (format!(" {ALL_TURNS}++;"), ALL_TURNS),
        };
        edits.insert_text(at, format!("var {own} = 0u; "));
        edits.insert_text(
            tokens[k + open].range.end,
            format!(
                " {own}++;{count} if {limited} > {max_turns}u {{ {NAME_PREFIX}leave_loop({number}u, {own}); break; }}"
            ),
        );
        let line = text[at..].lines().next().unwrap_or_default().trim_end();
        loops.push(LoopHead {
            at,
            line_number: text[..at].matches('\n').count() + 1,
            line: line.trim_end_matches('{').trim_end().to_owned(),
            max_turns,
        });
    }
    let declarations = format!(
        "var<private> {ALL_TURNS}: u32;
fn {NAME_PREFIX}leave_loop(number: u32, turns: u32) {{
    atomicMax(&{WATCH_LOG}[{word}u], (min(turns, 0xffffu) << {LOOP_NUMBER_BITS}u) + number + 1u);
}}
"
    );
    (edits, loops, declarations)
}

/// Returns the number of the loop at fault from the word of a log, if one was left.
pub(crate) fn loop_at_fault(word: u32) -> Option<usize> {
    let number = word % (1 << LOOP_NUMBER_BITS);
    number.checked_sub(1).map(|k| k as usize)
}
