//! CPU, memory and disk use of the server's process, from Linux's `/proc`.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use serde::Serialize;

use crate::BenchError;

/// Clock ticks per second in `/proc/PID/stat`: Linux has the same `USER_HZ` on every CPU that Rust supports.
const TICKS_PER_SECOND: f64 = 100.0;
/// Share of a core, over a second, above which a thread counts as busy. It is low, because dozens of threads may share
/// few cores.
const BUSY_SHARE: f64 = 0.015;
/// Share of a core below which a process is at rest.
const REST_SHARE: f64 = 0.1;
/// Period over which the CPU use of a process is measured to see if it is at rest.
const REST_CHECK_SPAN: Duration = Duration::from_millis(500);

/// Memory of a process in bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Memory {
    pub rss_bytes: f64,
    /// Peak of the memory since [`reset_peak`].
    pub peak_bytes: f64,
}

/// Thread of the server that keeps using the CPU.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct BusyThread {
    /// Name that the server gives the thread.
    pub name: String,
    /// Share of a core that the thread used during one second.
    pub share: f64,
}

pub(super) fn memory(pid: u32) -> Result<Memory, BenchError> {
    let status = read(pid, "status")?;
    let kib = |name: &str| {
        let line = status.lines().find_map(|line| line.strip_prefix(name));
        let number = line.and_then(|rest| rest.split_whitespace().next()?.parse::<f64>().ok());
        number.ok_or_else(|| unreadable(pid, "status", format!("it has no {name}")))
    };
    Ok(Memory { rss_bytes: 1024.0 * kib("VmRSS:")?, peak_bytes: 1024.0 * kib("VmHWM:")? })
}

/// Resets the peak of the memory.
pub(super) fn reset_peak(pid: u32) -> Result<(), BenchError> {
    // 5 resets only the peak.
    std::fs::write(path(pid, "clear_refs"), "5").map_err(|error| unreadable(pid, "clear_refs", error.to_string()))
}

/// Returns the CPU seconds of all threads since the process began.
pub(super) fn cpu_s(pid: u32) -> Result<f64, BenchError> {
    let stat = read(pid, "stat")?;
    ticks(&stat)
        .map(|(_, ticks)| ticks / TICKS_PER_SECOND)
        .ok_or_else(|| unreadable(pid, "stat", "it is shorter than expected".into()))
}

/// Returns the bytes that the process wrote to disk; 0 if its data is not on one.
pub(super) fn written_bytes(pid: u32) -> Result<u64, BenchError> {
    let io = read(pid, "io")?;
    let line = io.lines().find_map(|line| line.strip_prefix("write_bytes: "));
    line.and_then(|number| number.parse().ok()).ok_or_else(|| unreadable(pid, "io", "it has no write_bytes".into()))
}

/// Returns the threads that use the CPU during the next second, the busiest first.
pub(super) fn busy_threads(pid: u32) -> Result<Vec<BusyThread>, BenchError> {
    let (began, before) = (Instant::now(), thread_ticks(pid)?);
    std::thread::sleep(Duration::from_secs(1));
    let (after, seconds) = (thread_ticks(pid)?, began.elapsed().as_secs_f64());
    Ok(busy(&before, &after, seconds))
}

fn busy(before: &Threads, after: &Threads, seconds: f64) -> Vec<BusyThread> {
    let share_of = |id: &u64, ticks: f64| {
        let since = before.get(id).map_or(0.0, |(_, ticks)| *ticks);
        (ticks - since) / (TICKS_PER_SECOND * seconds)
    };
    let threads = after.iter().map(|(id, (name, ticks))| {
        let share = share_of(id, *ticks);
        BusyThread { name: name.clone(), share }
    });
    let mut busy: Vec<_> = threads.filter(|thread| thread.share > BUSY_SHARE).collect();
    busy.sort_by(|a, b| b.share.total_cmp(&a.share));
    busy
}

/// Waits until a process is at rest, for at most `within`.
pub(super) fn wait_until_at_rest(pid: u32, within: Duration) -> Result<(), BenchError> {
    let until = Instant::now() + within;
    while Instant::now() < until {
        let before = cpu_s(pid)?;
        std::thread::sleep(REST_CHECK_SPAN);
        if cpu_s(pid)? - before < REST_SHARE * REST_CHECK_SPAN.as_secs_f64() {
            break;
        }
    }
    Ok(())
}

/// Name and ticks of each thread, by its id.
type Threads = BTreeMap<u64, (String, f64)>;

fn thread_ticks(pid: u32) -> Result<Threads, BenchError> {
    let folder = std::fs::read_dir(path(pid, "task")).map_err(|error| unreadable(pid, "task", error.to_string()))?;
    let ids = folder.flatten().filter_map(|entry| entry.file_name().to_str()?.parse::<u64>().ok());
    // A thread that ends meanwhile is left out.
    let thread = |id: u64| {
        let stat = std::fs::read_to_string(path(pid, &format!("task/{id}/stat"))).ok()?;
        Some((id, ticks(&stat)?))
    };
    Ok(ids.filter_map(thread).collect())
}

/// Returns the name, and ticks in user and in system mode, from a line of `stat`.
fn ticks(stat: &str) -> Option<(String, f64)> {
    // A name may contain spaces and brackets.
    let (name, rest) = stat.split_once('(')?.1.rsplit_once(')')?;
    let mut numbers = rest.split_whitespace().skip(11).map_while(|number| number.parse::<f64>().ok());
    Some((name.into(), numbers.next()? + numbers.next()?))
}

fn path(pid: u32, file: &str) -> PathBuf {
    format!("/proc/{pid}/{file}").into()
}

fn read(pid: u32, file: &str) -> Result<String, BenchError> {
    std::fs::read_to_string(path(pid, file)).map_err(|error| unreadable(pid, file, error.to_string()))
}

fn unreadable(pid: u32, file: &str, reason: String) -> BenchError {
    BenchError::Usage { file: path(pid, file), reason }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_those_of_user_and_system_mode() {
        let stat = "12 (a (b) c) S 1 12 12 0 -1 4194304 99 0 0 0 7 5 1 1 20 0 6 0 100";
        assert_eq!(ticks(stat), Some(("a (b) c".into(), 12.0)));
        assert_eq!(ticks("12 (short) S 1"), None);
    }

    #[test]
    fn a_thread_is_busy_that_takes_more_than_a_tick_or_two() {
        let thread = |id: u64, name: &str, ticks: f64| (id, (name.to_owned(), ticks));
        let before = Threads::from([thread(1, "rests", 500.0), thread(2, "solves", 500.0)]);
        let after = Threads::from([thread(1, "rests", 501.0), thread(2, "solves", 600.0), thread(3, "new", 50.0)]);
        let named: Vec<_> = busy(&before, &after, 1.0).into_iter().map(|t| (t.name, t.share)).collect();
        assert_eq!(named, [("solves".to_owned(), 1.0), ("new".to_owned(), 0.5)]);
    }

    #[test]
    fn this_process_is_seen() {
        let pid = std::process::id();
        assert!(memory(pid).expect("told").rss_bytes > 1e6);
        assert!(cpu_s(pid).expect("told") >= 0.0);
        assert!(matches!(memory(u32::MAX), Err(BenchError::Usage { .. })));
    }
}
