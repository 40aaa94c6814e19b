//! Processor time: a measure of work that, unlike wall time, does not depend on what else the machine does.

/// Returns the processor time in seconds that the calling thread has used (Linux; 0 elsewhere).
pub fn thread_processor_seconds() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let nanoseconds = text.split(' ').next().and_then(|word| word.parse::<f64>().ok());
    nanoseconds.unwrap_or(0.0) * 1e-9
}
