//! Command-line parts that `bendylights` and `bendylights-studies` share: output to files, standard output and
//! standard error, progress, and sizes of pictures.
//!
//! Output files appear whole or not at all. Notes and progress go to standard error, and `--quiet` turns them
//! off.
//!
//! The crate knows no command, no scene and no renderer. Of `protocol` it uses only the limits of pictures.
//!
//! Begin with `OutputFile`, `print_answer` and `progress`.

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

/// True if the program prints only errors to standard error.
static QUIET: AtomicBool = AtomicBool::new(false);

/// Turns off notes and progress. The program then prints only errors.
pub fn set_quiet() {
    QUIET.store(true, Ordering::Relaxed);
}

/// Returns true if notes and progress are off.
pub fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// Prints a note to standard error, unless the program is quiet.
pub fn print_note(line: &str) {
    if !is_quiet() {
        print_to_stderr(line);
    }
}

/// Prints a line to standard error, and ignores a closed one. Control characters, for instance in a name from a
/// file, become spaces, because a terminal would interpret them.
pub fn print_to_stderr(line: &str) {
    let line: String = line.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    let _ = writeln!(io::stderr(), "{line}");
}

/// Prints a command's answer to standard output. A closed pipe (`| head`) is not an error.
pub fn print_answer(text: &str) -> Result<(), CliError> {
    let mut stdout = io::stdout().lock();
    match writeln!(stdout, "{text}").and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(CliError::Stdout(error)),
        _ => Ok(()),
    }
}
