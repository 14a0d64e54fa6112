//! Measures the loss of one client (the victim) to another that uses all it can: the frames of a drag and the answers
//! to drags of features, without and with each kind of other client, and the memory and threads that remain in the
//! server after the other client has left.

mod asks;
mod chart;
mod drags;
mod judge;
mod memory;
mod messages;
mod other;
mod row;
pub mod scenes;
mod setup;
mod slow_link;
mod usage;
mod victim;
mod views;

use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

use render::Backend;
use serde::Serialize;

use self::judge::{JudgedRow, MeasuredWindow};
pub use self::judge::{MissedBound, VictimPace};
use self::other::OtherClient;
pub use self::other::{OtherClientCounts, Writes};
pub use self::row::{IsolationRow, ROWS};
use self::row::{NOBODY, SLOW_LINK};
pub use self::usage::BusyThread;
use self::victim::Victim;
use crate::{BenchError, Progress, ServerProcess};

/// Duration of the victim's drag before anything is measured: its pictures have reached their final detail by then.
const WARM_UP_TIME: Duration = Duration::from_secs(3);
/// Duration of the victim's drag before each period of measurement begins.
const LEAD_IN_TIME: Duration = Duration::from_secs(1);
/// Longest time that the server may take to become idle after a row was prepared.
const SETTLE_TIMEOUT: Duration = Duration::from_mins(1);
/// Longest time for which a gap or an answer is followed that is still open at the end of a period.
const FOLLOW_TIMEOUT: Duration = Duration::from_mins(1);
const MIB: f64 = 1024.0 * 1024.0;

/// Options of the benchmark that measures how much one client loses to another.
#[derive(Clone, Debug)]
pub struct IsolationOptions {
    /// Rows to measure, each with a server of its own.
    pub rows: Vec<IsolationRow>,
    /// Width and height of the victim's view in pixels.
    pub size: [u32; 2],
    /// Duration of each of the three periods: alone, with the other client, and alone again.
    pub time: Duration,
    /// Time after the other client has left, before memory and threads are measured.
    pub rest: Duration,
    /// True if each socket of the other client has an actor of its own.
    pub many_actors: bool,
    /// Backend that draws; the server selects it if `None`.
    pub backend: Option<Backend>,
}

/// Results of the benchmark that measures how much one client loses to another.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct IsolationReport {
    /// Width of the victim's view in pixels.
    pub width: u32,
    /// Height of the victim's view in pixels.
    pub height: u32,
    /// Length of each measured period in seconds.
    pub seconds: f64,
    /// Seconds between the departure of the other client and the measurement of memory and threads.
    pub rest_s: f64,
    /// True if each socket of the other client had an actor of its own.
    pub many_actors: bool,
    /// Rows in the order in which they were measured.
    pub rows: Vec<RowReport>,
}

/// Effect of one kind of other client on the victim.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct RowReport {
    pub row: IsolationRow,
    /// Description of the other client's action.
    pub what: &'static str,
    /// True if no bound is missed.
    pub passes: bool,
    pub missed: Vec<MissedBound>,
    /// Frame rate of the victim with the other client, as a share of that without it.
    pub share: f64,
    /// Minimum that `share` may have.
    pub least_share: f64,
    /// Longest gap with the other client, as a multiple of the 95th percentile of gaps without it.
    pub longest_gap_of_usual: f64,
    /// Median time of the victim's drags of features with the other client, as a multiple of that without it.
    pub own_drag_of_usual: f64,
    /// Pace of the victim before the other client comes. Bounds compare with the faster one of this and `alone_after`.
    pub alone: VictimPace,
    /// Pace of the victim with the other client.
    pub with: VictimPace,
    /// Pace of the victim after the other client has left and the rest is over.
    pub alone_after: VictimPace,
    pub memory: MemoryReport,
    /// Threads of the server that still used the CPU after the rest.
    pub busy_threads: Vec<BusyThread>,
    /// CPU seconds that the server used per second, with the other client.
    pub server_cpu_share: f64,
    /// CPU seconds that the benchmark used per second, with the other client. Both clients run in the benchmark.
    pub bench_cpu_share: f64,
    pub other: OtherClientCounts,
    /// Bytes written per edit, if the row measures them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub writes: Option<Writes>,
    /// Reason that a connection of the victim ended.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub victim_broke: Option<String>,
}

/// Memory in MiB that the server's process held.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct MemoryReport {
    /// MiB after the victim's first drag, before the other client came.
    pub before_mib: f64,
    /// Maximum of MiB since then.
    pub peak_mib: f64,
    /// MiB after the rest.
    pub after_mib: f64,
}

impl IsolationReport {
    /// Returns the names of the rows that miss a bound.
    pub fn missed(&self) -> Vec<&'static str> {
        self.rows.iter().filter(|row| !row.passes).map(|row| row.row.name).collect()
    }
}

/// Names of the steps of a row, for progress.
const STEPS: [&str; 6] = ["starts", "prepares", "alone", "with the other", "rests", "alone again"];

/// Measures each row with a `program serve` on new data. Returns the report and the chart in SVG.
pub fn run(
    program: &Path,
    options: &IsolationOptions,
    progress: &dyn Fn(Progress),
) -> Result<(IsolationReport, String), BenchError> {
    let mut rows = Vec::new();
    for (index, row) in options.rows.iter().enumerate() {
        let of = STEPS.len() * options.rows.len();
        let step = |step: usize| {
            let done = STEPS.len() * index + step;
            progress(Progress { done, of, what: format!("{}: {}", row.name, STEPS[step]) });
        };
        rows.push(measure(program, *row, options, &step)?);
    }
    let report = IsolationReport {
        width: options.size[0],
        height: options.size[1],
        seconds: options.time.as_secs_f64(),
        rest_s: options.rest.as_secs_f64(),
        many_actors: options.many_actors,
        rows,
    };
    let chart = chart::draw(&report)?;
    Ok((report, chart))
}

fn measure(
    program: &Path,
    row: IsolationRow,
    options: &IsolationOptions,
    step: &dyn Fn(usize),
) -> Result<RowReport, BenchError> {
    step(0);
    let server = ServerProcess::start_with_new_data(program, "demo:vases", options.backend)?;
    let (address, pid) = (&server.address, server.pid());
    let link = if row.name == SLOW_LINK.name { slow_link::open(address)? } else { address.clone() };
    let victim = Victim::start(address, &link, options.size)?;
    victim.start_dragging();
    thread::sleep(WARM_UP_TIME);
    victim.stop_dragging();
    usage::wait_until_at_rest(pid, SETTLE_TIMEOUT)?;
    let before = usage::memory(pid)?;
    usage::reset_peak(pid)?;

    step(1);
    let other = OtherClient::new(address.clone(), row.name, pid, options.time, options.many_actors);
    let mut act = Some((row.prepare)(&other)?);
    usage::wait_until_at_rest(pid, SETTLE_TIMEOUT)?;

    step(2);
    let alone = alone(&victim, options.time);

    step(3);
    if row.has_views_open
        && let Some(act) = act.take()
    {
        act(&other)?;
    }
    victim.start_dragging();
    thread::sleep(LEAD_IN_TIME);
    let (server_cpu, bench_cpu) = (usage::cpu_s(pid)?, usage::cpu_s(std::process::id())?);
    let from = Instant::now();
    act.take().map_or(Ok(()), |act| act(&other))?;
    thread::sleep(options.time.saturating_sub(from.elapsed()));
    let to = Instant::now();
    let seconds = (to - from).as_secs_f64();
    let server_cpu_share = (usage::cpu_s(pid)? - server_cpu) / seconds;
    let bench_cpu_share = (usage::cpu_s(std::process::id())? - bench_cpu) / seconds;
    let with = MeasuredWindow { from, to, followed_to: victim.follow(to, FOLLOW_TIMEOUT) };
    other.leave();
    let left = Instant::now();
    victim.stop_dragging();

    step(4);
    thread::sleep(options.rest.saturating_sub(left.elapsed()));
    let busy_threads = usage::busy_threads(pid)?;
    let after = usage::memory(pid)?;

    step(5);
    let alone_after = self::alone(&victim, options.time);
    let timeline = victim.leave()?;
    let actions = other.counts();
    let (alone, with, alone_after) = (timeline.pace(alone), timeline.pace(with), timeline.pace(alone_after));
    let faster = if alone_after.frames_per_second > alone.frames_per_second { alone_after } else { alone };
    let measured = JudgedRow {
        uses_renderer: row.uses_renderer,
        alone: faster,
        with,
        grown_mib: (after.rss_bytes - before.rss_bytes) / MIB,
        busy_threads: &busy_threads,
        writes: other.writes().map(|writes| writes.ratio),
        is_connected: timeline.disconnect_reason.is_none(),
        is_other_idle: row.name != NOBODY.name && (actions.done == 0 || row.expects_answers && actions.answered == 0),
    };
    let missed = measured.missed();
    Ok(RowReport {
        row,
        what: row.what,
        passes: missed.is_empty(),
        missed,
        share: measured.share(),
        least_share: measured.least_share(),
        longest_gap_of_usual: measured.gap(),
        own_drag_of_usual: measured.own_drag(),
        alone,
        with,
        alone_after,
        memory: MemoryReport {
            before_mib: before.rss_bytes / MIB,
            peak_mib: after.peak_bytes / MIB,
            after_mib: after.rss_bytes / MIB,
        },
        busy_threads,
        server_cpu_share,
        bench_cpu_share,
        other: actions,
        writes: other.writes(),
        victim_broke: timeline.disconnect_reason,
    })
}

/// Measures a period of the victim's drag without the other client.
fn alone(victim: &Victim, time: Duration) -> MeasuredWindow {
    victim.start_dragging();
    thread::sleep(LEAD_IN_TIME);
    let from = Instant::now();
    thread::sleep(time);
    let to = Instant::now();
    let window = MeasuredWindow { from, to, followed_to: victim.follow(to, FOLLOW_TIMEOUT) };
    victim.stop_dragging();
    window
}
