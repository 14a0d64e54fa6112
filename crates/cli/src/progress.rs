//! Progress of long work on standard error: a bar on a terminal, else a line per second.

use std::fmt::{self, Write};
use std::io::{self, IsTerminal};
use std::mem;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle, TermLike};

use crate::{is_quiet, print_note};

/// Interval at which the bar is redrawn without progress.
const REDRAW_INTERVAL: Duration = Duration::from_millis(200);
/// Interval between lines, and before the first.
const LINE_INTERVAL: Duration = Duration::from_secs(1);
/// Columns of a line that goes to a file.
const WIDTH: u16 = 100;

/// Returns a progress bar for work in `total` parts, or in parts whose number follows later if `total` is 0
/// ([`ProgressBar::set_length`]). It shows the finished share, the remaining time and the bar's message. Work
/// of less than a second prints no line, and `--quiet` prints none.
pub fn progress(total: u64) -> ProgressBar {
    let is_terminal = io::stderr().is_terminal();
    let target = match (is_quiet(), is_terminal) {
        (true, _) => ProgressDrawTarget::hidden(),
        (false, true) => ProgressDrawTarget::stderr(),
        (false, false) => ProgressDrawTarget::term_like(Box::new(LineTerminal::default())),
    };
    let template = if is_terminal { "{bar:30} {percent} %{left} {msg}" } else { "{percent} %{left} {msg}" };
    let style = ProgressStyle::with_template(template).expect("a sound template").with_key("left", write_time_left);
    let bar = ProgressBar::with_draw_target((total > 0).then_some(total), target).with_style(style);
    bar.enable_steady_tick(REDRAW_INTERVAL);
    bar
}

/// Prints the remaining time, at the average speed so far. indicatif's own estimate grows to days during a long
/// part. Before the first part is finished nothing is printed.
fn write_time_left(state: &ProgressState, text: &mut dyn Write) {
    if let (done @ 1.., Some(all)) = (state.pos(), state.len()) {
        let rest = all.saturating_sub(done) as f64 / done as f64;
        let _: fmt::Result = write!(text, ", {:#} left", HumanDuration(state.elapsed().mul_f64(rest)));
    }
}

/// Terminal for indicatif that prints the text of the bar as lines, at most one per second.
#[derive(Debug, Default)]
struct LineTerminal {
    drawn: Mutex<LineThrottle>,
}

#[derive(Debug)]
struct LineThrottle {
    text: String,
    last: Instant,
}

impl Default for LineThrottle {
    fn default() -> Self {
        Self { text: String::new(), last: Instant::now() }
    }
}

impl LineThrottle {
    /// Returns the text to print at `now`, or `None` if the last line is less than a second old.
    fn line(&mut self, now: Instant) -> Option<String> {
        let text = mem::take(&mut self.text);
        let text = text.trim();
        if text.is_empty() || now.saturating_duration_since(self.last) < LINE_INTERVAL {
            return None;
        }
        self.last = now;
        Some(text.to_owned())
    }
}

impl TermLike for LineTerminal {
    fn width(&self) -> u16 {
        WIDTH
    }

    fn move_cursor_up(&self, _: usize) -> io::Result<()> {
        Ok(())
    }

    fn move_cursor_down(&self, _: usize) -> io::Result<()> {
        Ok(())
    }

    fn move_cursor_right(&self, _: usize) -> io::Result<()> {
        Ok(())
    }

    fn move_cursor_left(&self, _: usize) -> io::Result<()> {
        Ok(())
    }

    fn write_line(&self, text: &str) -> io::Result<()> {
        self.write_str(text)
    }

    fn write_str(&self, text: &str) -> io::Result<()> {
        self.drawn.lock().unwrap_or_else(PoisonError::into_inner).text.push_str(text);
        Ok(())
    }

    fn clear_line(&self) -> io::Result<()> {
        Ok(())
    }

    fn flush(&self) -> io::Result<()> {
        if let Some(line) = self.drawn.lock().unwrap_or_else(PoisonError::into_inner).line(Instant::now()) {
            print_note(&line);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_comes_once_a_second_and_tells_the_latest() {
        let mut drawn = LineThrottle::default();
        let began = drawn.last;
        let lines: Vec<String> = (1..=25)
            .filter_map(|tenth: u32| {
                drawn.text = format!(" {tenth} % ");
                drawn.line(began + tenth * LINE_INTERVAL / 10)
            })
            .collect();
        assert_eq!(lines, ["10 %", "20 %"]);
        assert_eq!(drawn.line(began + 9 * LINE_INTERVAL), None, "nothing was drawn since");
    }
}
