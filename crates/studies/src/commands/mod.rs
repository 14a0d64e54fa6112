//! Arguments of each study, and output of its report.

pub mod stress;
pub mod work;

use cli::CliError;
use serde::Serialize;

/// Prints a report as JSON over several lines.
fn print_json(report: &impl Serialize) -> Result<(), CliError> {
    cli::print_answer(&serde_json::to_string_pretty(report).expect("plain data with string keys"))
}
