//! How far long work is, on standard error: a bar on a terminal, elsewhere a line a second.

use std::fmt::{self, Write};
use std::io::{self, IsTerminal};
use std::mem;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle, TermLike};

use crate::{is_quiet, print_note};

/// How often the bar is drawn anew where nothing comes on.
const REDRAW_INTERVAL: Duration = Duration::from_millis(200);
/// From one line to the next, and to the first.
const LINE_INTERVAL: Duration = Duration::from_secs(1);
/// Columns of a line that goes to a file.
const WIDTH: u16 = 100;

/// Progress of work in `total` parts; 0 where that is said later ([`ProgressBar::set_length`]). It shows the share that is
/// done, the time left and the bar's message. What takes less than a second writes no line, and `--quiet` writes none.
pub fn progress(total: u64) -> ProgressBar {
    let is_terminal = io::stderr().is_terminal();
    let target = match (is_quiet(), is_terminal) {
        (true, _) => ProgressDrawTarget::hidden(),
        (false, true) => ProgressDrawTarget::stderr(),
        (false, false) => ProgressDrawTarget::term_like(Box::new(LineTerminal::default())),
    };
    let template = if is_terminal { "{bar:30} {percent} %{left} {msg}" } else { "{percent} %{left} {msg}" };
    let style =
        ProgressStyle::with_template(template).expect("a sound template").with_key("left", write_time_left);
    let bar = ProgressBar::with_draw_target((total > 0).then_some(total), target).with_style(style);
    bar.enable_steady_tick(REDRAW_INTERVAL);
    bar
}

/// The rest takes as long a part as what is done took: indicatif's own estimate runs into days while a long part goes on. Nothing is
/// known before the first part is done.
fn write_time_left(state: &ProgressState, text: &mut dyn Write) {
    if let (done @ 1.., Some(all)) = (state.pos(), state.len()) {
        let rest = all.saturating_sub(done) as f64 / done as f64;
        let _: fmt::Result = write!(text, ", {:#} left", HumanDuration(state.elapsed().mul_f64(rest)));
    }
}

/// Takes a bar as indicatif draws it, and gives its text on as a line, one a second at most.
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
    /// The text to write at `now`, or `None` where the last line is no second old.
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
