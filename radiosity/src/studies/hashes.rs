//! Hashes of what a stored result depends on: another input, or another build of the program, is measured anew.

use common::file;
use std::hash::{DefaultHasher, Hash, Hasher};

/// Returns a 64-bit hash of `value`.
pub fn hash_value(value: &impl Hash) -> u64 {
    let mut hasher = DefaultHasher::new();
    value.hash(&mut hasher);
    hasher.finish()
}

/// Returns a hash of this program, from its version and its executable file: another build measures anew.
pub fn hash_program() -> u64 {
    let path = std::env::current_exe().ok();
    let file = path.and_then(|path| file::read(&path, file::MAX_FILE_BYTES).ok());
    hash_value(&(env!("CARGO_PKG_VERSION"), file.unwrap_or_default()))
}
