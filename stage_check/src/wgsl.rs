//! Parses and validates WGSL.

use crate::tokens::split_tokens;
use wgpu::naga::front::wgsl::parse_str;
use wgpu::naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use wgpu::naga::{Module, Span};

/// Largest number of operators that one expression combines. naga visits them by recursion: a sum of ten thousand terms would
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
/// Errors: naga's diagnostic; an expression of more than 500 operators.
pub fn compile(text: &str, path: &str) -> Result<(Module, ModuleInfo), Diagnostic> {
    check_expressions(text, path)?;
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

/// Checks that no expression has more than [`MAX_OPERATORS`] operators, those of the brackets around it included. The elements
/// of a list do not count together.
///
/// Errors: one has, with its place.
fn check_expressions(text: &str, path: &str) -> Result<(), Diagnostic> {
    let mut count = 0;
    let mut counts_before_brackets = Vec::new();
    for token in split_tokens(text) {
        match &text[token.range.clone()] {
            ";" | "{" | "}" => {
                count = 0;
                counts_before_brackets.clear();
            }
            "(" | "[" => counts_before_brackets.push(count),
            ")" | "]" => count = counts_before_brackets.pop().unwrap_or(0),
            "," => count = counts_before_brackets.last().copied().unwrap_or(0),
            sign if sign.starts_with(is_operator) => count += 1,
            _ => {}
        }
        if count > MAX_OPERATORS {
            let message = format!("an expression has more than {MAX_OPERATORS} operators: divide it");
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_sums_are_refused_and_long_lists_are_not() {
        let message = |expression: &str| {
            let text = format!("fn f() -> f32 {{ return {expression}; }}");
            compile(&text, "f.wgsl").err().map(|error| error.message)
        };
        let terms = |count: usize, term: &str, sign: &str| vec![term; count].join(sign);
        let refusal = Some("an expression has more than 500 operators: divide it".to_owned());
        assert_eq!(message(&terms(20_000, "1.0", "+")), refusal);
        assert_eq!(message(&terms(20_000, "min(1.0, 2.0)", "+")), refusal);
        assert_eq!(message(&terms(500, "(1.0 + 2.0)", "+")), None);
        assert_eq!(
            message(&format!("array<f32, 2000>({})[0]", terms(2000, "-1.0", ", "))),
            None
        );
    }
}
