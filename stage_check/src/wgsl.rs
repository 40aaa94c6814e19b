//! Parses and validates WGSL.

use wgpu::naga::front::wgsl::parse_str;
use wgpu::naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use wgpu::naga::{Module, Span};

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
/// Errors: naga's diagnostic.
pub fn compile(text: &str, path: &str) -> Result<(Module, ModuleInfo), Diagnostic> {
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
