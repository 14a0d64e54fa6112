//! Progress of a measurement.

/// Number of finished steps of a measurement, and the step that begins.
#[derive(Clone, Debug)]
pub struct Progress {
    pub done: usize,
    /// Total number of steps.
    pub of: usize,
    /// Name of the step that begins.
    pub what: String,
}
