//! What the commands of `bendylights` and of `bendylights-studies` share: where answers and files go, and how sizes are
//! written.

mod error;
mod headless;
mod output;
mod progress;
mod size;

pub use error::CliError;
pub use headless::restart_without_window_system;
pub use output::{OutputFile, make_folder};
pub use progress::progress;
pub use size::{LIMITS, Size};

use std::io::{self, Write};
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether this program says nothing but why it fails.
static QUIET: AtomicBool = AtomicBool::new(false);

/// From here on this program says nothing but why it fails.
pub fn set_quiet() {
    QUIET.store(true, Ordering::Relaxed);
}

/// Whether it does.
pub fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// A note on standard error, unless nobody wants any.
pub fn print_note(line: &str) {
    if !is_quiet() {
        print_to_stderr(line);
    }
}

/// A line on standard error. Where that is closed there is nobody to tell. Control characters, such as a name in a file may
/// have, are spaces: they would mean something to a terminal.
pub fn print_to_stderr(line: &str) {
    let line: String = line.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    let _ = writeln!(io::stderr(), "{line}");
}

/// Writes a command's answer to standard output. A reader that has gone away (`| head`) has had enough: no error.
pub fn print_answer(text: &str) -> Result<(), CliError> {
    let mut stdout = io::stdout().lock();
    match writeln!(stdout, "{text}").and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(CliError::Stdout(error)),
        _ => Ok(()),
    }
}
