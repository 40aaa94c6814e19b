//! Parses and validates WGSL.

use crate::tokens::split_tokens;
use wgpu::naga::front::wgsl::parse_str;
use wgpu::naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use wgpu::naga::{Module, Span};

/// Largest number of operators of a statement. naga visits what they combine by recursion: a sum of ten thousand terms would
/// overflow its stack and end the program.
const MAX_OPERATORS: usize = 500;

/// An error of naga.
pub struct Diagnostic {
    /// The message alone.
    pub message: String,
    /// The places that it is about.
    pub spans: Vec<Span>,
    /// The whole message, with path, line, column and the lines that it is about.
    pub listing: String,
}

/// Parses and validates WGSL; `path` is the name in the listing.
///
/// Errors: naga's diagnostic; a statement of more than 500 operators.
pub fn compile(text: &str, path: &str) -> Result<(Module, ModuleInfo), Diagnostic> {
    check_statements(text, path)?;
    let module = parse_str(text).map_err(|error| Diagnostic {
        message: error.message().to_owned(),
        spans: error.labels().map(|(span, _)| span).collect(),
        listing: error.emit_to_string_with_path(text, path),
    })?;
    let mut validator = Validator::new(ValidationFlags::all(), Capabilities::default());
    let info = validator.validate(&module).map_err(|error| Diagnostic {
        message: error.as_inner().to_string(),
        spans: error.spans().map(|(span, _)| *span).collect(),
        listing: error.emit_to_string_with_path(text, path),
    })?;
    Ok((module, info))
}

/// Checks that no statement has more than [`MAX_OPERATORS`] operators.
///
/// Errors: it has, with its place.
fn check_statements(text: &str, path: &str) -> Result<(), Diagnostic> {
    let mut count = 0;
    for token in split_tokens(text) {
        match &text[token.range.clone()] {
            ";" | "{" | "}" => count = 0,
            sign if sign.starts_with(is_operator) => count += 1,
            _ => {}
        }
        if count > MAX_OPERATORS {
            let message = format!("a statement has more than {MAX_OPERATORS} operators: divide it");
            return Err(Diagnostic {
                listing: format!("error: {message} ({path})"),
                message,
                spans: vec![Span::new(token.range.start as u32, token.range.end as u32)],
            });
        }
    }
    Ok(())
}

fn is_operator(letter: char) -> bool {
    "+-*/%&|^<>=!~".contains(letter)
}
