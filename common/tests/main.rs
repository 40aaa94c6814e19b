//! What `common` reads and writes: imported files, the bundled scenes, stored results.

mod import;
mod overlap;
mod scenes;
mod settings;
mod stored;
