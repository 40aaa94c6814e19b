//! Errors of the workspace. Each message is one line that names the file and the place. The program takes its exit code
//! from their kind.

use crate::text::escape_control;
use std::path::{Path, PathBuf};

/// Every failure of the workspace. The program maps each kind to its exit code.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Unusable input; `place` is a line, face, material or node, or empty.
    #[error("{}{}{place}: {message}", path.display(), if place.is_empty() { "" } else { ": " })]
    Input {
        /// The file that was read.
        path: PathBuf,
        /// Place in the file.
        place: String,
        /// The fault and its remedy.
        message: String,
    },
    /// A shader of the user's that is no WGSL, or does not fit the others.
    #[error("{place}: {message}")]
    Shader {
        /// File, line and column.
        place: String,
        /// The fault.
        message: String,
        /// The lines of the file that it is about, marked: several lines of text.
        listing: String,
    },
    /// Options that contradict each other or the scene.
    #[error("{0}")]
    Usage(String),
    /// A result could not be written.
    #[error("{}: cannot be written: {source}", path.display())]
    Write {
        /// The file or directory.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// A GPU was asked for and there is none.
    #[error("{0}")]
    NoAdapter(String),
    /// Ctrl-C before there was a result to write.
    #[error("interrupted: nothing was written")]
    Interrupted,
    /// The GPU failed, was lost, or is too small for the scene.
    #[error("{0}")]
    Device(String),
    /// A shader left no result, or one that cannot be.
    #[error("{message}")]
    Stage {
        /// Name of the shader.
        stage: &'static str,
        /// The adapter, and what is wrong.
        message: String,
    },
    /// A violated invariant of the program.
    #[error("a fault in this program: {0}")]
    Fault(String),
}

impl Error {
    /// Makes [`Error::Input`] at `place` (may be empty) of `path`. Control characters, which names in a file may have, are
    /// escaped.
    pub fn bad_input(path: impl AsRef<Path>, place: impl Into<String>, message: impl Into<String>) -> Self {
        Self::Input {
            path: path.as_ref().to_path_buf(),
            place: escape_control(&place.into()),
            message: escape_control(&message.into()),
        }
    }
}

/// Result with the workspace's error.
pub type Result<T> = std::result::Result<T, Error>;
