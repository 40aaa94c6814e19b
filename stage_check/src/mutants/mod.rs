//! Mutants of WGSL: texts with one small mistake each. naga's typed module says where one is possible, its spans say
//! which characters change, so that a mutant shows its line of the file.
//!
//! A check of a shader is as good as the mutants it finds. [`list_mutations`] walks expressions and statements; the
//! caller compiles each mutant, since naga folds constants and a span may hide a rule of the grammar.

mod expressions;
mod statements;

use crate::tokens::{arguments_length, find_arguments, trim_range};
use std::collections::BTreeSet;
use std::ops::Range;
use wgpu::naga::compact::{KeepUnused, compact};
use wgpu::naga::valid::{FunctionInfo, ModuleInfo};
use wgpu::naga::{Expression, Function, Handle, Module, Span};

/// Kinds of mutations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum MutationOperator {
    /// `+` for `-`, `/` for `*`, `|` for `&`.
    Arithmetic,
    /// `||` for `&&`.
    Logic,
    /// `>` for `<`, `<=` for `<`, `!=` for `==`.
    Comparison,
    /// A number doubled, 1 for 0, an integer plus 1.
    Constant,
    /// `min`, `max`, `clamp`, `saturate` or `abs` dropped.
    Clamp,
    /// A condition under which a block is left, dropped.
    Guard,
    /// An index plus or minus 1.
    Index,
    /// Another component of a vector.
    Swizzle,
    /// A condition negated.
    Condition,
    /// A minus sign dropped.
    Sign,
    /// A statement removed.
    Statement,
    /// A barrier removed.
    Barrier,
    /// Two arguments of one type swapped.
    Arguments,
}

impl MutationOperator {
    /// Returns the name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Arithmetic => "arithmetic",
            Self::Logic => "logic",
            Self::Comparison => "comparison",
            Self::Constant => "constant",
            Self::Clamp => "clamp dropped",
            Self::Guard => "guard dropped",
            Self::Index => "index",
            Self::Swizzle => "swizzle",
            Self::Condition => "condition negated",
            Self::Sign => "sign dropped",
            Self::Statement => "statement removed",
            Self::Barrier => "barrier removed",
            Self::Arguments => "arguments swapped",
        }
    }
}

/// A change of a text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mutation {
    /// Kind.
    pub operator: MutationOperator,
    /// Bytes of the text that change.
    pub range: Range<usize>,
    /// Their new text.
    pub replacement: String,
}

impl Mutation {
    /// Returns the mutant of a text.
    pub fn apply(&self, text: &str) -> String {
        let mut mutant = text.to_owned();
        mutant.replace_range(self.range.clone(), &self.replacement);
        mutant
    }
}

/// Returns the mutations within the bytes `part` of `text`, from which naga made `module`; their ranges count from the
/// beginning of the part.
pub fn list_mutations(text: &str, part: Range<usize>, module: &Module, info: &ModuleInfo) -> Vec<Mutation> {
    let mut sites = Vec::new();
    let functions = module
        .functions
        .iter()
        .map(|(handle, function)| (function, &info[handle]));
    let entries = module.entry_points.iter().enumerate();
    let entries = entries.map(|(k, entry)| (&entry.function, info.get_entry_point(k)));
    for (function, info) in functions.chain(entries) {
        let mut finder = SiteFinder {
            text,
            module,
            function,
            info,
            found: Vec::new(),
        };
        finder.visit_expressions();
        finder.visit_block(&function.body, None);
        sites.append(&mut finder.found);
    }
    sites.retain(|site| site.range.start >= part.start && site.range.end <= part.end);
    sites.sort_by_key(|site| (site.range.start, site.range.end, site.operator));
    let mut seen = BTreeSet::new();
    sites.retain(|site| seen.insert((site.range.start, site.range.end, site.replacement.clone())));
    for site in &mut sites {
        site.range = site.range.start - part.start..site.range.end - part.start;
    }
    sites
}

/// Returns whether two valid modules are equal but for names and unused items.
pub fn are_same_modules(a: &Module, b: &Module) -> bool {
    let [a, b] = [a, b].map(|module| {
        let mut module = module.clone();
        compact(&mut module, KeepUnused::No);
        format!("{:?} {:?} {:?}", module.functions, module.entry_points, module.types)
    });
    a == b
}

/// Finds mutations in one function.
struct SiteFinder<'m> {
    text: &'m str,
    module: &'m Module,
    function: &'m Function,
    info: &'m FunctionInfo,
    found: Vec<Mutation>,
}

impl<'m> SiteFinder<'m> {
    /// Adds a mutation that changes its text.
    fn add(&mut self, operator: MutationOperator, range: Range<usize>, replacement: impl Into<String>) {
        let replacement = replacement.into();
        if self.text.get(range.clone()).is_some_and(|text| text != replacement) {
            self.found.push(Mutation {
                operator,
                range,
                replacement,
            });
        }
    }

    /// Returns the bytes of an expression.
    fn range_of(&self, expression: Handle<Expression>) -> Option<Range<usize>> {
        self.trim(self.function.expressions.get_span(expression))
    }

    /// Returns the bytes of a span without white space at its ends. That of a call is its name alone: its arguments are
    /// added.
    fn trim(&self, span: Span) -> Option<Range<usize>> {
        let range = trim_range(self.text, span.to_range()?)?;
        let is_name = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'_';
        let arguments = match self.text_at(&range).bytes().all(is_name) {
            true => arguments_length(self.text.get(range.end..)?),
            false => 0,
        };
        Some(range.start..range.end + arguments)
    }

    fn text_at(&self, range: &Range<usize>) -> &'m str {
        self.text.get(range.clone()).unwrap_or_default()
    }

    /// Swaps neighbours of one type among the arguments of the call in these bytes.
    fn swap_arguments(&mut self, call: &Range<usize>, arguments: &[Handle<Expression>]) {
        let types = &self.module.types;
        let places = find_arguments(self.text_at(call));
        if places.len() != arguments.len() {
            return;
        }
        for (pair, places) in arguments.windows(2).zip(places.windows(2)) {
            let [a, b] = [pair[0], pair[1]].map(|argument| self.info[argument].ty.inner_with(types));
            if a == b {
                let [first, second] = [&places[0], &places[1]].map(|at| call.start + at.start..call.start + at.end);
                let [a, between, b] = [&first, &(first.end..second.start), &second].map(|range| self.text_at(range));
                self.add(
                    MutationOperator::Arguments,
                    first.start..second.end,
                    format!("{b}{between}{a}"),
                );
            }
        }
    }
}

#[cfg(test)]
mod tests;
