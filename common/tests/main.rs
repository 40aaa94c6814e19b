//! What `common` reads and writes: imported files, the bundled scenes, stored results.

mod import;
mod scenes;
mod stored;
