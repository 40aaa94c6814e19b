//! Insertions into the text of a shader that watch what it does.

/// Name of the log in a watched text, an `array<atomic<u32>>`.
pub const WATCH_LOG: &str = "watch_log";

/// Prefix of the other names that are added to a text.
pub(crate) const NAME_PREFIX: &str = "watched_";

/// Insertions into a text.
#[derive(Default)]
pub(crate) struct TextInsertions(Vec<(usize, String)>);

impl TextInsertions {
    /// Inserts before the byte `at`.
    pub(crate) fn insert_text(&mut self, at: usize, text: impl Into<String>) {
        self.0.push((at, text.into()));
    }

    /// Adds other insertions; at one place they come behind those before.
    pub(crate) fn append_all(&mut self, mut other: Self) {
        self.0.append(&mut other.0);
    }

    /// Returns the text with the insertions.
    pub(crate) fn apply_to(mut self, text: &str) -> String {
        // Insertions at one place keep their order.
        self.0.sort_by_key(|(at, _)| *at);
        let mut result = String::with_capacity(2 * text.len());
        let mut done = 0;
        for (at, inserted) in self.0 {
            result.push_str(&text[done..at]);
            result.push_str(&inserted);
            done = at;
        }
        result.push_str(&text[done..]);
        result
    }
}
