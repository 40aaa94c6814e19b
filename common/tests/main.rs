//! Tests of the files that `common` reads and writes: imported files, bundled scenes, stored solutions.

mod import;
mod overlap;
mod scenes;
mod settings;
mod stored;
