//! Text of a shader module: the files that it is put together from, and the file and line of an error.
//!
//! WGSL may use a name before it is declared, so the parts may stand in any order. Files of others come first, so that
//! their lines keep their numbers.

use crate::shader_files::ShaderFile;
use common::{Error, Result};
use stage_check::wgsl::{Diagnostic, compile};
use wgpu::naga::front::wgsl::parse_str;
use wgpu::naga::valid::ModuleInfo;
use wgpu::naga::{Module, Span};

/// Parts of a module.
pub struct ModuleText<'f> {
    parts: Vec<Part<'f>>,
}

struct Part<'f> {
    /// The path of a given file, or the name of the program's.
    name: String,
    text: String,
    given: Option<&'f ShaderFile>,
}

impl<'f> ModuleText<'f> {
    /// Makes a module of constants alone.
    pub fn new(constants: String) -> Self {
        let constants = Part {
            name: "the program's constants".into(),
            text: constants,
            given: None,
        };
        Self { parts: vec![constants] }
    }

    /// Adds the text of a shader, which may be `given`.
    pub fn add_part(&mut self, stage: &str, mut text: String, given: Option<&'f ShaderFile>) {
        if !text.ends_with('\n') {
            text.push('\n');
        }
        let own = || format!("{stage}.wgsl of the program");
        let name = given.map_or_else(own, |file| file.path.display().to_string());
        let part = Part { name, text, given };
        match part.given {
            // The last one, which has the entry points, is the first.
            Some(_) => self.parts.insert(0, part),
            None => self.parts.push(part),
        }
    }

    /// Returns the whole text.
    pub fn text(&self) -> String {
        self.parts.iter().map(|part| part.text.as_str()).collect()
    }

    /// Returns the given file of the module; the one with the entry points if there are several.
    pub fn given_file(&self) -> Option<&'f ShaderFile> {
        self.parts[0].given
    }

    /// Returns the stage of the given file in which a byte of the text lies, and the line in that file, from 1; none in a file of
    /// the program's.
    pub fn given_line_at(&self, at: usize) -> Option<(&'static str, usize)> {
        let parts: Vec<&Part> = self.parts.iter().collect();
        let (part, start) = part_at(&parts, Span::new(at as u32, at as u32 + 1));
        let file = self.parts[part].given?;
        Some((file.stage, self.text()[start..at].matches('\n').count() + 1))
    }

    /// Records that a pipeline is made of the given files.
    pub fn mark_used(&self) {
        self.parts
            .iter()
            .filter_map(|part| part.given)
            .for_each(ShaderFile::mark_used);
    }

    /// Returns an error that names the given file; without one, that of a fault of the program.
    pub fn refuse(&self, message: &str) -> Error {
        match self.given_file() {
            Some(file) => Error::bad_input(&file.path, "", message),
            None => Error::Device(message.to_owned()),
        }
    }

    /// Parses the module, and validates it if it has a given file.
    ///
    /// Errors: [`Error::Shader`] in a given file; [`Error::Device`] in the program's own.
    pub fn parse(&self) -> Result<Module> {
        let text = self.text();
        if self.given_file().is_none() {
            return parse_str(&text).map_err(|error| Error::Device(error.emit_to_string(&text)));
        }
        self.compile().map(|(module, _)| module)
    }

    /// Parses and validates the module.
    ///
    /// Errors: [`Error::Shader`], in the given file if there is one.
    pub fn compile(&self) -> Result<(Module, ModuleInfo)> {
        compile(&self.text(), &self.parts[0].name).map_err(|found| self.locate(found))
    }

    /// Checks that the module has these entry points.
    ///
    /// Errors: it lacks one.
    pub fn require_entries<'e>(&self, module: &Module, entries: impl IntoIterator<Item = &'e str>) -> Result<()> {
        let lacks = |entry: &&str| !module.entry_points.iter().any(|found| found.name == *entry);
        match entries.into_iter().find(lacks) {
            Some(entry) => Err(self.refuse(&format!("has no entry point `fn {entry}`"))),
            None => Ok(()),
        }
    }

    /// Converts a diagnostic of the whole text to an error with the lines of the file in which it lies: a given file if
    /// one is concerned.
    fn locate(&self, found: Diagnostic) -> Error {
        let (parts, found) = self.find_open_end().unwrap_or_else(|| self.put_wrong_part_first(found));
        let text = joined_text(&parts);
        let first = found.spans.iter().find(|span| part_at(&parts, **span).0 == 0);
        let place = first.map_or_else(|| parts[0].name.clone(), |span| describe_place(parts[0], *span));
        // The first line is the message, the second the place: of the first span, which may be in another file.
        let is_head = |line: &&str| line.starts_with("error: ") || line.trim_start().starts_with("┌─ ");
        let (heads, rest): (Vec<&str>, Vec<&str>) = found.listing.lines().partition(is_head);
        let head = heads.iter().find_map(|line| line.split_once("┌─ "));
        let head = head.map(|(margin, _)| format!("{margin}┌─ {place}"));
        let foreign = |span: &Span| describe_foreign_line(&parts, *span, &text);
        let rest = rest.into_iter().map(str::to_owned);
        let listing: Vec<String> = head
            .into_iter()
            .chain(rest)
            .chain(found.spans.iter().filter_map(foreign))
            .collect();
        let message = match (parts[0].given, self.given_file()) {
            (None, Some(file)) => format!("does not fit {}: {}", file.path.display(), found.message),
            _ => found.message,
        };
        Error::Shader {
            place,
            message,
            listing: listing.join("\n"),
        }
    }

    /// Returns a given file that ends too early, with its error: in the module that would be one of the next file.
    fn find_open_end(&self) -> Option<(Vec<&Part<'f>>, Diagnostic)> {
        let mut given = self.parts.iter().filter(|part| part.given.is_some());
        given.find_map(|part| {
            let found = compile(&part.text, &part.name).err()?;
            let at = found.spans.first()?.to_range()?.start;
            (at >= part.text.trim_end().len()).then(|| (vec![part], found))
        })
    }

    /// Returns the parts in the order in which the one that is wrong comes first, and the diagnostic of that order.
    fn put_wrong_part_first(&self, found: Diagnostic) -> (Vec<&Part<'f>>, Diagnostic) {
        let parts: Vec<&Part> = self.parts.iter().collect();
        let concerned: Vec<usize> = found.spans.iter().map(|span| part_at(&parts, *span).0).collect();
        let given = concerned.iter().find(|part| parts[**part].given.is_some());
        let wrong = given.or(concerned.first()).map_or(0, |part| *part);
        let mut order = parts.clone();
        order[..=wrong].rotate_right(1);
        // A directive stands in the first file only, so the other order may have no error.
        match compile(&joined_text(&order), &order[0].name) {
            Err(found) => (order, found),
            Ok(_) => (parts, found),
        }
    }
}

/// Returns the text of these parts.
fn joined_text(parts: &[&Part]) -> String {
    parts.iter().map(|part| part.text.as_str()).collect()
}

/// Returns file, line and column of a span in the first part of a text.
fn describe_place(part: &Part, span: Span) -> String {
    let place = span.location(&part.text);
    let before = &part.text[..place.offset as usize];
    let column = before.chars().rev().take_while(|letter| *letter != '\n').count() + 1;
    format!("{}:{}:{column}", part.name, place.line_number)
}

/// Returns a note on a line of a listing that is not in its first part.
fn describe_foreign_line(parts: &[&Part], span: Span, text: &str) -> Option<String> {
    let (part, start) = part_at(parts, span);
    let line = span.location(text).line_number;
    let before = text[..start].matches('\n').count() as u32;
    (part > 0).then(|| format!("  = line {line} is line {} of {}", line - before, parts[part].name))
}

/// Returns the number of the part in which a span begins, and the first byte of the part.
fn part_at(parts: &[&Part], span: Span) -> (usize, usize) {
    let at = span.to_range().map_or(0, |range| range.start);
    let mut start = 0;
    for (k, part) in parts.iter().enumerate() {
        if at < start + part.text.len() {
            return (k, start);
        }
        start += part.text.len();
    }
    (0, 0)
}
