//! Races within a workgroup, found by a text of the same shader that watches its accesses: whatever order an adapter runs
//! the lanes in, two lanes that use an element without a barrier between, one of them to write, leave a trace.
//!
//! Beside each array of workgroup memory, [`watch_shader`](crate::watch::watch_shader) declares who wrote and who read each element last, and since
//! which barrier. Elements of storage buffers with a literal index are watched likewise where a shader has a barrier. What
//! the text cannot follow is not watched: pointers, atomics, writes of single components, arrays in structs, and storage
//! that several workgroups share.

use crate::edits::{NAME_PREFIX, TextInsertions, WATCH_LOG};
use crate::tokens::Token;
use std::fmt;
use std::fmt::Write;
use wgpu::naga::{
    AddressSpace, ArraySize, Binding, BuiltIn, EntryPoint, Handle, Module, StorageAccess, StructMember, Type, TypeInner,
};

/// Words of the log that a report takes.
pub(crate) const REPORT_WORDS: usize = 7;

/// Elements of a storage buffer that are watched: those of the lowest literal indices.
const STORAGE_ELEMENTS: u32 = 16;
/// Lanes of a workgroup at most, by WebGPU's limits of 256 and those of adapters: a power of two.
const MAX_LANES: u32 = 1024;

/// Operators that write to what stands before them, beside `=`.
const UPDATES: [&str; 12] = ["+=", "-=", "*=", "/=", "%=", "&=", "|=", "^=", "<<=", ">>=", "++", "--"];
/// Barriers that order workgroup memory.
pub(crate) const WORKGROUP_BARRIER: &str = "workgroupBarrier";
/// A barrier with a value, which is not followed.
pub(crate) const UNIFORM_LOAD: &str = "workgroupUniformLoad";
/// Barriers that order storage buffers.
pub(crate) const STORAGE_BARRIER: &str = "storageBarrier";

/// Two accesses of an element of which one is a write, without a barrier between.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Race {
    /// Name of the variable.
    pub variable: String,
    /// Number of the element.
    pub element: u32,
    /// The lanes; what the first does stands in `writes`.
    pub lanes: [u32; 2],
    /// True if the first lane writes; the second then reads or writes. Otherwise the second writes.
    pub writes: bool,
}

/// What a watched text has found.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RaceReport {
    /// Number of accesses.
    pub accesses: u32,
    /// Number of accesses that race with another.
    pub races: u32,
    /// The first race.
    pub first: Option<Race>,
}

impl Race {
    /// Returns the name of the element in WGSL.
    pub fn element_label(&self) -> String {
        format!("{}[{}]", self.variable, self.element)
    }

    /// Returns what the lanes do to the element.
    pub fn describe_lanes(&self) -> String {
        let [a, b] = self.lanes;
        match self.writes {
            true => format!("written by lane {a} and used by lane {b} without a barrier between"),
            false => format!("read by lane {a} and written by lane {b} without a barrier between"),
        }
    }
}

impl fmt::Display for RaceReport {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match &self.first {
            None => write!(f, "none of {} accesses races with another", self.accesses),
            Some(first) => write!(
                f,
                "{} of {} accesses race with another: {} is {}",
                self.races,
                self.accesses,
                first.element_label(),
                first.describe_lanes()
            ),
        }
    }
}

impl RaceReport {
    /// Reads the words of a log that a text with these watched variables has left.
    pub(crate) fn from_words(words: &[u32], variables: &[String]) -> Self {
        let word = |k: usize| words.get(k).copied().unwrap_or_default();
        let race = || Race {
            variable: (variables.get(word(2) as usize))
                .cloned()
                .unwrap_or_else(|| "a variable".into()),
            element: word(3),
            lanes: [word(4), word(5)],
            writes: word(6) != 0,
        };
        Self {
            accesses: word(0),
            races: word(1),
            first: (word(1) > 0).then(race),
        }
    }
}

/// A variable whose elements are watched.
struct Watched {
    name: String,
    /// Elements of each dimension, the last of which lies closest.
    sizes: Vec<u32>,
    /// True for workgroup memory, false for a storage buffer.
    in_workgroup: bool,
    /// True if the variable is no array, and becomes one of one element.
    single: bool,
}

/// The accesses of a shader, watched.
pub(crate) struct WatchedAccesses {
    pub edits: TextInsertions,
    /// Names of the watched variables.
    pub variables: Vec<String>,
    /// What the text declares beside its own.
    pub declarations: String,
}

/// Watches the accesses of a text, from which naga made `module`; a report begins at word `first` of the log. None if there is
/// nothing that can be watched, or if that would need more than `max_bytes` of workgroup memory.
pub(crate) fn watch_accesses(
    (text, tokens): (&str, &[Token]),
    module: &Module,
    first: u32,
    max_bytes: u32,
) -> Option<WatchedAccesses> {
    let has_word = |word: &str| tokens.iter().any(|token| &text[token.range.clone()] == word);
    if has_word(UNIFORM_LOAD) {
        return None;
    }
    let has_barrier = has_word(WORKGROUP_BARRIER) || has_word(STORAGE_BARRIER);
    let variables = module.global_variables.iter().filter_map(|(_, variable)| {
        let name = variable.name.clone()?;
        let in_workgroup = match variable.space {
            AddressSpace::WorkGroup => true,
            AddressSpace::Storage { access } if has_barrier && access.contains(StorageAccess::STORE) => false,
            _ => return None,
        };
        let (sizes, single) = array_sizes(module, variable.ty, in_workgroup)?;
        Some(Watched {
            name,
            sizes,
            in_workgroup,
            single,
        })
    });
    let mut edits = TextInsertions::default();
    let mut watched = Vec::new();
    for variable in variables {
        let mut own = TextInsertions::default();
        if watch_variable(&mut own, (text, tokens), &variable).is_some_and(|accesses| accesses > 0) {
            edits.append_all(own);
            watched.push(variable);
        }
    }
    let elements = |variable: &Watched| -> u64 { variable.sizes.iter().map(|size| u64::from(*size)).product() };
    let watched_words: u64 = watched.iter().map(|variable| 3 * elements(variable)).sum();
    let sizes = module
        .global_variables
        .iter()
        .filter(|(_, v)| v.space == AddressSpace::WorkGroup);
    let own_bytes = sizes.map(|(_, v)| u64::from(module.types[v.ty].inner.size(module.to_ctx())));
    let enters_memory = watched.iter().any(|variable| variable.in_workgroup);
    if !enters_memory || own_bytes.sum::<u64>() + 4 * watched_words > max_bytes.into() {
        return None;
    }
    for entry in &module.entry_points {
        set_lane(&mut edits, (text, tokens), module, entry)?;
    }
    for token in tokens {
        let word = &text[token.range.clone()];
        if [WORKGROUP_BARRIER, STORAGE_BARRIER].contains(&word) {
            edits.insert_text(token.range.start, NAME_PREFIX);
        }
    }
    Some(WatchedAccesses {
        edits,
        declarations: declare_watches(&watched, first),
        variables: watched.into_iter().map(|variable| variable.name).collect(),
    })
}

/// Returns the elements of each dimension of a variable that can be watched, and whether it is a single value.
fn array_sizes(module: &Module, ty: Handle<Type>, in_workgroup: bool) -> Option<(Vec<u32>, bool)> {
    let mut sizes = Vec::new();
    let mut inner = &module.types[ty].inner;
    while let TypeInner::Array { base, size, .. } = inner {
        sizes.push(match size {
            ArraySize::Constant(count) if in_workgroup => count.get(),
            ArraySize::Pending(_) => return None,
            _ if !in_workgroup && sizes.is_empty() => STORAGE_ELEMENTS,
            _ => return None,
        });
        inner = &module.types[*base].inner;
    }
    let is_plain = |inner: &TypeInner| {
        matches!(
            inner,
            TypeInner::Scalar(_) | TypeInner::Vector { .. } | TypeInner::Matrix { .. }
        )
    };
    let holds_values = match inner {
        TypeInner::Struct { members, .. } => members.iter().all(|member| is_plain(&module.types[member.ty].inner)),
        inner => is_plain(inner),
    };
    match sizes.is_empty() {
        _ if !holds_values => None,
        true => in_workgroup.then_some((vec![1], true)),
        false => Some((sizes, false)),
    }
}

/// Watches the accesses of a variable and returns their number; none if one of them cannot be followed.
fn watch_variable(edits: &mut TextInsertions, (text, tokens): (&str, &[Token]), variable: &Watched) -> Option<usize> {
    let word = |k: usize| tokens.get(k).map_or("", |token| &text[token.range.clone()]);
    let mut accesses = 0;
    let before = |k: usize| k.checked_sub(1).map_or("", word);
    for k in (0..tokens.len()).filter(|k| word(*k) == variable.name) {
        match before(k) {
            // A member of that name.
            "." => continue,
            // The declaration: depth 0, behind `var<...>`.
            ">" if tokens[k].depth == 0 => {
                if variable.single {
                    declare_array(edits, (text, tokens), k)?;
                }
                continue;
            }
            // A local name that hides the variable; a pointer.
            "let" | "var" | "const" | "&" => return None,
            _ if word(k + 1) == ":" => return None,
            _ => {}
        }
        accesses += usize::from(watch_access(edits, (text, tokens), k, variable)?);
    }
    Some(accesses)
}

/// Declares the variable of token `k`, a single value, as an array.
fn declare_array(edits: &mut TextInsertions, (text, tokens): (&str, &[Token]), k: usize) -> Option<()> {
    let is = |k: usize, sign: &str| tokens.get(k).is_some_and(|token| &text[token.range.clone()] == sign);
    let end = (k + 1..tokens.len()).find(|n| is(*n, ";"))?;
    if !is(k + 1, ":") {
        return None;
    }
    edits.insert_text(tokens[k + 2].range.start, "array<");
    edits.insert_text(tokens[end].range.start, ", 1>");
    Some(())
}

/// Watches the access whose name is token `k`; returns false if it is to an element that is not watched, and none if it cannot be
/// followed.
fn watch_access(
    edits: &mut TextInsertions,
    (text, tokens): (&str, &[Token]),
    k: usize,
    variable: &Watched,
) -> Option<bool> {
    let word = |k: usize| tokens.get(k).map_or("", |token| &text[token.range.clone()]);
    // The bytes within each pair of brackets.
    let mut indices = Vec::new();
    let mut next = k + 1;
    while !variable.single && indices.len() < variable.sizes.len() && word(next) == "[" {
        let depth = tokens[next].depth;
        let close = (next + 1..tokens.len()).find(|n| tokens[*n].depth == depth && word(*n) == "]")?;
        indices.push(tokens[next].range.end..tokens[close].range.start);
        next = close + 1;
    }
    let element = next;
    while matches!(word(next), "." | "[") {
        let depth = tokens[next].depth;
        next = match word(next) {
            "." => next + 2,
            _ => (next + 1..tokens.len()).find(|n| tokens[*n].depth == depth && word(*n) == "]")? + 1,
        };
    }
    let (writes, reads) = match word(next) {
        "=" => (true, false),
        sign if UPDATES.contains(&sign) => (true, true),
        _ => (false, true),
    };
    if writes && next > element {
        return None;
    }
    let kind = u32::from(reads) + 2 * u32::from(writes);
    let name = format!("{NAME_PREFIX}{}", variable.name);
    if variable.single {
        edits.insert_text(tokens[k].range.end, format!("[{name}(0u, {kind}u)]"));
        return Some(true);
    }
    if indices.len() < variable.sizes.len() {
        return None;
    }
    if !variable.in_workgroup {
        let literal = text[indices[0].clone()]
            .trim()
            .trim_end_matches(['u', 'i'])
            .parse::<u32>();
        match literal {
            Ok(index) if index < STORAGE_ELEMENTS => {}
            // Another element of the buffer.
            _ => return Some(false),
        }
    }
    let (last, outer) = indices.split_last()?;
    let mut linear = String::new();
    for (index, (n, _)) in outer.iter().zip(variable.sizes.iter().enumerate()) {
        let below: u32 = variable.sizes[n + 1..].iter().product();
        let _ = write!(linear, "u32({}) * {below}u + ", &text[index.clone()]);
    }
    edits.insert_text(last.start, format!("{name}({linear}u32("));
    let wrap = match outer.is_empty() {
        true => String::new(),
        false => format!(" % {}u", variable.sizes.last()?),
    };
    edits.insert_text(last.end, format!("), {kind}u){wrap}"));
    Some(true)
}

/// Stores the lane's number at the begin of an entry point; none if it has none.
fn set_lane(
    edits: &mut TextInsertions,
    (text, tokens): (&str, &[Token]),
    module: &Module,
    entry: &EntryPoint,
) -> Option<()> {
    let word = |k: usize| tokens.get(k).map_or("", |token| &text[token.range.clone()]);
    let [wide, high, _] = entry.workgroup_size;
    let of_binding = |name: &str, binding: &Option<Binding>| match binding {
        Some(Binding::BuiltIn(BuiltIn::LocalInvocationIndex)) => Some(name.to_owned()),
        Some(Binding::BuiltIn(BuiltIn::LocalInvocationId)) => {
            Some(format!("{name}.x + {wide}u * ({name}.y + {high}u * {name}.z)"))
        }
        _ => None,
    };
    let lane = entry.function.arguments.iter().find_map(|argument| {
        let name = argument.name.as_deref()?;
        let members = match &module.types[argument.ty].inner {
            TypeInner::Struct { members, .. } => members.as_slice(),
            _ => &[],
        };
        let of_member =
            |member: &StructMember| of_binding(&format!("{name}.{}", member.name.as_deref()?), &member.binding);
        of_binding(name, &argument.binding).or_else(|| members.iter().find_map(of_member))
    })?;
    let is_entry = |k: &usize| word(*k) == "fn" && word(*k + 1) == entry.name;
    let start = (0..tokens.len()).find(is_entry)?;
    let open = (start..tokens.len()).find(|k| tokens[*k].depth == 0 && word(*k) == "{")?;
    edits.insert_text(tokens[open].range.end, format!(" {NAME_PREFIX}lane = {lane};"));
    Some(())
}

/// Returns what a watched text declares beside its own.
fn declare_watches(watched: &[Watched], first: u32) -> String {
    let mut text = format!(
        "
var<private> {NAME_PREFIX}lane: u32;
// Barriers of workgroup memory and of storage that the lane has passed, and 1.
var<private> {NAME_PREFIX}phases: vec2u = vec2u(1u);
fn {NAME_PREFIX}{WORKGROUP_BARRIER}() {{ {NAME_PREFIX}phases.x++; {WORKGROUP_BARRIER}(); }}
fn {NAME_PREFIX}{STORAGE_BARRIER}() {{ {NAME_PREFIX}phases.y++; {STORAGE_BARRIER}(); }}
// Compares an access with an earlier one, both as phase and lane.
fn {NAME_PREFIX}compare(variable: u32, element: u32, own: u32, other: u32, writes: u32) {{
    if own == other || own / {MAX_LANES}u != other / {MAX_LANES}u {{ return; }}
    if atomicAdd(&{WATCH_LOG}[{first}u + 1u], 1u) == 0u {{
        atomicStore(&{WATCH_LOG}[{first}u + 2u], variable);
        atomicStore(&{WATCH_LOG}[{first}u + 3u], element);
        atomicStore(&{WATCH_LOG}[{first}u + 4u], own % {MAX_LANES}u);
        atomicStore(&{WATCH_LOG}[{first}u + 5u], other % {MAX_LANES}u);
        atomicStore(&{WATCH_LOG}[{first}u + 6u], writes);
    }}
}}
"
    );
    for (k, variable) in watched.iter().enumerate() {
        let (name, count) = (&variable.name, variable.sizes.iter().product::<u32>());
        let phase = if variable.in_workgroup { "x" } else { "y" };
        // A lane leaves its trace before it looks for those of others, so that of two one sees the other.
        let _ = write!(
            text,
            "
var<workgroup> {NAME_PREFIX}{name}_written: array<atomic<u32>, {count}>;
var<workgroup> {NAME_PREFIX}{name}_read: array<atomic<u32>, {count}>;
// Who read an element before its last reader, another lane.
var<workgroup> {NAME_PREFIX}{name}_read_before: array<atomic<u32>, {count}>;
fn {NAME_PREFIX}{name}(index: u32, kind: u32) -> u32 {{
    let k = min(index, {last}u);
    let phase = {NAME_PREFIX}phases.{phase};
    let own = phase * {MAX_LANES}u + {NAME_PREFIX}lane;
    atomicAdd(&{WATCH_LOG}[{first}u], 1u);
    if (kind & 1u) != 0u {{
        let before = atomicExchange(&{NAME_PREFIX}{name}_read[k], own);
        if before != own && before / {MAX_LANES}u == phase {{
            atomicStore(&{NAME_PREFIX}{name}_read_before[k], before);
        }}
        {NAME_PREFIX}compare({k}u, k, own, atomicLoad(&{NAME_PREFIX}{name}_written[k]), 0u);
    }}
    if (kind & 2u) != 0u {{
        {NAME_PREFIX}compare({k}u, k, own, atomicExchange(&{NAME_PREFIX}{name}_written[k], own), 1u);
        {NAME_PREFIX}compare({k}u, k, own, atomicLoad(&{NAME_PREFIX}{name}_read[k]), 1u);
        {NAME_PREFIX}compare({k}u, k, own, atomicLoad(&{NAME_PREFIX}{name}_read_before[k]), 1u);
    }}
    return index;
}}
",
            last = count - 1,
        );
    }
    text
}
