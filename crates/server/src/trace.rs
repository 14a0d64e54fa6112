//! The trace: a line of JSON for each picture, in a file written by its own thread.
//!
//! Other threads only put lines into a bounded queue. So no disk delays a picture, and none fills the memory. A line
//! without room is counted in the next one that has room.

use std::fs::File;
use std::io::Write;
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::thread;
use std::time::Duration;

use protocol::TraceLine;

use crate::ServerError;
use crate::limits::{TRACE_FLUSH_TIMEOUT, TRACE_QUEUE};
use crate::picture_stats::micros;

/// Handle to the trace file, to which a line is written for each picture. Clones share the file. The default has no
/// file and drops all lines.
#[derive(Clone, Debug, Default)]
pub struct Trace(Option<Lines>);

#[derive(Clone, Debug)]
struct Lines {
    queue: SyncSender<Entry>,
    /// Number of lines that were dropped, because the queue was full, since the last line that was queued.
    left_out: Arc<AtomicU64>,
}

#[derive(Debug)]
enum Entry {
    Line(Box<TraceLine>),
    End,
}

/// Thread that writes the trace. Dropping this writes the queued lines first, and waits for that unless the disk hangs.
#[derive(Debug)]
pub struct TraceThread {
    queue: SyncSender<Entry>,
    /// Closed when the thread has ended.
    ended: Receiver<()>,
}

impl Drop for TraceThread {
    fn drop(&mut self) {
        if self.queue.try_send(Entry::End).is_ok() {
            // The channel carries no messages. Its end is the signal.
            let _ = self.ended.recv_timeout(TRACE_FLUSH_TIMEOUT);
        }
    }
}

/// Line of a drawn picture that is not in the trace yet. It is queued when the picture is encoded, or when this is
/// dropped because the picture will not be encoded.
#[derive(Debug)]
pub struct PictureTrace {
    trace: Trace,
    line: Option<Box<TraceLine>>,
}

impl PictureTrace {
    /// Queues the line, with the time that encoding took.
    pub fn encoded(&mut self, took: Duration) {
        if let Some(line) = &mut self.line {
            line.encode_us = Some(micros(took));
        }
        self.queue();
    }

    fn queue(&mut self) {
        if let (Some(lines), Some(line)) = (&self.trace.0, self.line.take())
            && let Err(TrySendError::Full(_)) = lines.queue.try_send(Entry::Line(line))
        {
            lines.left_out.fetch_add(1, Ordering::Relaxed);
        }
    }
}

impl Drop for PictureTrace {
    fn drop(&mut self) {
        self.queue();
    }
}

impl Trace {
    /// Starts the thread that appends lines to a file. Creates the file if it is missing, readable for its owner alone.
    pub fn start(path: &Path) -> Result<(Self, TraceThread), ServerError> {
        let unusable = |reason| ServerError::Trace { path: path.into(), reason };
        let file = File::options().create(true).append(true).mode(0o600).open(path).map_err(unusable)?;
        let (queue, entries) = sync_channel(TRACE_QUEUE);
        let left_out = Arc::new(AtomicU64::new(0));
        let (ends, ended) = sync_channel(0);
        let (path, left_out_before) = (PathBuf::from(path), Arc::clone(&left_out));
        thread::spawn(move || {
            write_lines(file, &path, &entries, &left_out_before);
            drop::<SyncSender<()>>(ends);
        });
        let trace = Self(Some(Lines { queue: queue.clone(), left_out }));
        Ok((trace, TraceThread { queue, ended }))
    }

    /// Starts the line of a drawn picture. `line` is called only if there is a file.
    pub fn drawn(&self, line: impl FnOnce() -> TraceLine) -> PictureTrace {
        let line = self.0.as_ref().map(|_| Box::new(line()));
        PictureTrace { trace: self.clone(), line }
    }
}

/// Writes lines until the queue is closed or an error occurs. Each line is written at once and as a whole, so an
/// incomplete line is never followed by another one.
fn write_lines(mut file: File, path: &Path, entries: &Receiver<Entry>, left_out: &AtomicU64) {
    while let Ok(Entry::Line(mut line)) = entries.recv() {
        line.left_out = left_out.swap(0, Ordering::Relaxed);
        let mut text = serde_json::to_vec(&line).expect("plain data with string keys");
        text.push(b'\n');
        if let Err(reason) = file.write_all(&text) {
            let file = path.display();
            tracing::warn!(
                "{file}: the trace ends here, as it cannot be written ({reason}); make room and start the server again"
            );
            return;
        }
    }
    let missing = left_out.load(Ordering::Relaxed);
    if missing > 0 {
        tracing::warn!("{}: the trace lacks its last {missing} pictures, as its disk is slow", path.display());
    }
}

#[cfg(test)]
mod tests {
    use protocol::{FrameQuality, TraceWhat};

    use super::*;

    fn line(time: f64) -> TraceLine {
        TraceLine {
            time,
            session: "main".into(),
            what: TraceWhat::Still {},
            size: [64, 36],
            quality: FrameQuality::Settled,
            wait_us: 1,
            render_us: 2,
            encode_us: None,
            passes: Vec::new(),
            left_out: 0,
        }
    }

    fn lines(text: &str) -> Vec<TraceLine> {
        text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
    }

    /// Rules: TRACE-1
    #[test]
    fn a_line_tells_of_the_encoding_or_that_there_was_none() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("trace.jsonl");
        for _ in 0..2 {
            let (trace, thread) = Trace::start(&path).unwrap();
            trace.drawn(|| line(0.5)).encoded(Duration::from_millis(3));
            drop(trace.drawn(|| line(1.5)));
            drop(thread);
            // This line comes after the thread has ended.
            drop(trace.drawn(|| line(2.5)));
        }
        let written = lines(&std::fs::read_to_string(&path).unwrap());
        let encodings: Vec<_> = written.iter().map(|line| (line.time, line.encode_us)).collect();
        let of_one = [(0.5, Some(3_000)), (1.5, None)];
        assert_eq!(encodings, [of_one, of_one].concat(), "a second start goes on at its end");
        assert!(matches!(Trace::start(folder.path()), Err(ServerError::Trace { .. })));
        drop(Trace::default().drawn(|| unreachable!("nobody wants to know")));
    }

    /// A reader that takes nothing stands for a disk that hangs. Nobody waits for it, and the next line has the number
    /// of dropped lines.
    ///
    /// Rules: TRACE-1
    #[test]
    fn a_line_without_room_is_counted() {
        let (queue, entries) = sync_channel(2);
        let left_out = Arc::new(AtomicU64::new(0));
        let trace = Trace(Some(Lines { queue, left_out: Arc::clone(&left_out) }));
        for k in 0..5 {
            drop(trace.drawn(|| line(f64::from(k))));
        }
        drop(trace);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("trace.jsonl");
        write_lines(File::create(&path).unwrap(), &path, &entries, &left_out);
        let written = lines(&std::fs::read_to_string(&path).unwrap());
        assert_eq!(written.iter().map(|line| line.left_out).collect::<Vec<_>>(), [3, 0]);
    }
}
