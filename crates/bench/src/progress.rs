//! The progress of a measurement.

/// How many steps of a measurement are done.
#[derive(Clone, Debug)]
pub struct Progress {
    pub done: usize,
    /// Number of all steps.
    pub of: usize,
    /// The step that begins.
    pub what: String,
}
