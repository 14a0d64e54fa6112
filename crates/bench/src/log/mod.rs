//! Measures the edit log: edits acknowledged, undone and replayed per second, and the time to open a session.

mod chart;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command as Process;
use std::time::{Duration, Instant};

use protocol::{ClientMessage, Scope};
use serde::Serialize;

use crate::circle::ms;
use crate::dragged::DragCircle;
use crate::{BenchError, Client, Progress, Quantiles, ServerProcess};

/// Number of requests in flight, if the client does not wait for each answer before the next request.
pub const IN_FLIGHT: usize = 64;

/// Number of edits that are sent one at a time.
const ONE_AT_A_TIME: usize = 200;

/// Number of times that a session of each length is opened. The fastest time counts, because other work of the machine
/// only adds time.
const OPENINGS: usize = 3;

/// Maximum number of log lengths at which opening is measured.
const LENGTHS: usize = 7;

/// Results of the benchmark of the edit log.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct LogBenchReport {
    /// Description of the edits.
    pub what: &'static str,
    /// Rate of edits if each edit is sent after the one before was acknowledged. An edit is acknowledged when it is on
    /// disk.
    pub acknowledged_one_at_a_time: EditRate,
    /// Rate of edits with up to 64 requests in flight.
    pub acknowledged: EditRate,
    /// Rate of undos with up to 64 requests in flight.
    pub undone: EditRate,
    /// Rate of records in `bendylights replay` of a log file, which applies every record and compares the hash of every
    /// checkpoint.
    pub replayed: EditRate,
    /// Opening times by the length of the log, ascending.
    pub opening: Vec<OpeningTime>,
}

/// Number and rate of requests or records.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct EditRate {
    /// Number of edits or records.
    pub count: usize,
    pub per_second: f64,
    /// Latency from a request to its answer; null for replay, which has no answers.
    pub latency_ms: Option<Quantiles>,
}

/// Time until a server answers for a session that it has not opened yet.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct OpeningTime {
    /// Records in the log.
    pub records: u64,
    /// Bytes of the log file.
    pub log_bytes: u64,
    /// Milliseconds until the answer if the log has no checkpoint, so that the server replays all records.
    pub without_checkpoint_ms: f64,
    /// Milliseconds until the answer in a second server on the same folder. It starts from the checkpoint that the
    /// first server wrote, if the log has a thousand records or more; else it replays all records.
    pub reopened_ms: f64,
}

/// Starts `program serve` with new data, and measures while the log grows by `edits` edits. Returns the report and the
/// chart in SVG.
pub fn run(program: &Path, edits: usize, progress: impl Fn(Progress)) -> Result<(LogBenchReport, String), BenchError> {
    let folder = tempfile::tempdir()?;
    let data = folder.path().join("data");
    let lengths = lengths(edits);
    let (one_at_a_time, undos) = (ONE_AT_A_TIME.min(edits), edits.min(1_000));
    let of = one_at_a_time + edits + undos + lengths.len() * (1 + 3 * OPENINGS);
    let say = |done: usize, what: &str| progress(Progress { done, of, what: what.into() });

    let mut logs = Vec::new();
    let server = ServerProcess::start(program, &data, &["--scene", "demo:vases"])?;
    server.wait_until_ready()?;
    let mut client = Client::connect(&server.address, "main", "bench", None)?;
    let mut light = LightEdits::new(&client)?;
    let mut latencies = RequestTimes::default();
    for &length in &lengths {
        let done = light.count;
        latencies.add(light.send(&mut client, length - done, IN_FLIGHT, |k| say(done + k, "edits"))?);
        let log = folder.path().join(format!("{length}.jsonl"));
        let [from, to] = [&data, &log].map(|path| path.display().to_string());
        answer(program, &["export", "main", "--data", &from, "-o", &to])?;
        logs.push(ExportedLog { records: light.seq, file: log });
    }
    let done = edits;
    let slow = light.send(&mut client, one_at_a_time, 1, |k| say(done + k, "edits, one at a time"))?;
    let done = done + one_at_a_time;
    let undone = light.undo(&mut client, undos, |k| say(done + k, "undo"))?;
    server.kill()?;

    let done = done + undos;
    let replayed = replay(program, &logs[logs.len() - 1].file)?;
    let opened = folder.path().join("opened");
    let opening = openings(program, &opened, &logs, |k, doing| say(done + k, doing))?;
    let report = LogBenchReport {
        what: "a control point of demo:vases' light, set again and again by one client, on loopback",
        acknowledged_one_at_a_time: slow.rate(),
        acknowledged: latencies.rate(),
        undone: undone.rate(),
        replayed,
        opening,
    };
    let chart = chart::draw(&report)?;
    Ok((report, chart))
}

/// Numbers of edits up to `edits`, each about three times the one before it.
fn lengths(edits: usize) -> Vec<usize> {
    let mut lengths: Vec<usize> = (0..LENGTHS as u32).map(|k| edits / 3_usize.pow(k)).collect();
    lengths.retain(|length| *length > 0);
    lengths.reverse();
    lengths.dedup();
    lengths
}

/// Latencies of answered requests, and the seconds during which they were sent and answered.
#[derive(Clone, Debug, Default)]
struct RequestTimes {
    latencies_ms: Vec<f64>,
    seconds: f64,
}

impl RequestTimes {
    fn add(&mut self, more: Self) {
        self.latencies_ms.extend(more.latencies_ms);
        self.seconds += more.seconds;
    }

    fn rate(self) -> EditRate {
        let count = self.latencies_ms.len();
        let latency_ms = (count > 0).then(|| Quantiles::of(self.latencies_ms));
        EditRate { count, per_second: count as f64 / self.seconds.max(1e-9), latency_ms }
    }
}

/// Edits of one light by one client.
struct LightEdits {
    circle: DragCircle,
    /// Number of edits made.
    count: usize,
    /// Latest record.
    seq: u64,
    /// Number of requests made.
    requests: usize,
}

impl LightEdits {
    fn new(client: &Client) -> Result<Self, BenchError> {
        Ok(Self { circle: DragCircle::of(client)?, count: 0, seq: client.welcome.seq, requests: 0 })
    }

    /// Makes `count` edits, each to another position, with at most `in_flight` requests in flight. `progress` gets the
    /// number of answered ones.
    fn send(
        &mut self,
        client: &mut Client,
        count: usize,
        in_flight: usize,
        progress: impl Fn(usize),
    ) -> Result<RequestTimes, BenchError> {
        let first = self.count;
        self.count += count;
        let (circle, base_seq) = (self.circle.clone(), self.seq);
        self.answered(client, count, in_flight, progress, |op_id, number| {
            // Never the same position twice: that would be no edit.
            let command = circle.command((first + number) as f64);
            ClientMessage::Edit { op_id, base_seq, command }
        })
    }

    /// Undoes `count` edits, with at most `IN_FLIGHT` requests in flight.
    fn undo(
        &mut self,
        client: &mut Client,
        count: usize,
        progress: impl Fn(usize),
    ) -> Result<RequestTimes, BenchError> {
        let scope = Scope::Mine;
        self.answered(client, count, IN_FLIGHT, progress, |op_id, _| ClientMessage::Undo { op_id, scope })
    }

    fn answered(
        &mut self,
        client: &mut Client,
        count: usize,
        in_flight: usize,
        progress: impl Fn(usize),
        request: impl Fn(String, usize) -> ClientMessage,
    ) -> Result<RequestTimes, BenchError> {
        let mut sent = BTreeMap::new();
        let mut latencies_ms = Vec::with_capacity(count);
        let began = Instant::now();
        let mut number = 0;
        while latencies_ms.len() < count {
            while number < count && sent.len() < in_flight {
                self.requests += 1;
                let op_id = format!("bench-{}", self.requests);
                sent.insert(op_id.clone(), Instant::now());
                client.send(&request(op_id, number))?;
                number += 1;
            }
            let result = client.wait_for_edit(|_| true)?;
            BenchError::check(result.outcome.problem())?;
            self.seq = self.seq.max(result.outcome.seq().unwrap_or_default());
            latencies_ms.extend(sent.remove(&result.op_id).map(|sent| ms(sent.elapsed())));
            progress(latencies_ms.len());
        }
        Ok(RequestTimes { latencies_ms, seconds: began.elapsed().as_secs_f64() })
    }
}

/// Log file of a number of records.
struct ExportedLog {
    records: u64,
    file: PathBuf,
}

/// Imports the logs as sessions and opens them twice: in a first server without checkpoints, then in a second one, from
/// the checkpoints that the first wrote. `progress` gets the number of finished steps.
fn openings(
    program: &Path,
    data: &Path,
    logs: &[ExportedLog],
    progress: impl Fn(usize, &'static str),
) -> Result<Vec<OpeningTime>, BenchError> {
    let mut done = logs.len();
    let names = |records: u64| (0..OPENINGS).map(move |copy| format!("log-{records}-{copy}"));
    for ExportedLog { records, file } in logs {
        for name in names(*records) {
            let [log, to] = [file, data].map(|path| path.display().to_string());
            answer(program, &["import", &log, "--data", &to, "--name", &name])?;
            done += 1;
            progress(done, "import");
        }
    }
    let mut times = [const { Vec::new() }; 2];
    for times in &mut times {
        // Opening its main session decodes the scene that all sessions share.
        let server = ServerProcess::start(program, data, &["--scene", "demo:vases"])?;
        server.wait_until_ready()?;
        opened(&server, "main")?;
        for ExportedLog { records, .. } in logs {
            let mut fastest = Duration::MAX;
            for name in names(*records) {
                fastest = fastest.min(opened(&server, &name)?);
                done += 1;
                progress(done, "open");
            }
            times.push(ms(fastest));
        }
        server.kill()?;
    }
    let [without, reopened] = times;
    let all = logs.iter().zip(without.into_iter().zip(reopened));
    all.map(|(ExportedLog { records, file }, (without_checkpoint_ms, reopened_ms))| {
        let log_bytes = std::fs::metadata(file)?.len();
        Ok(OpeningTime { records: *records, log_bytes, without_checkpoint_ms, reopened_ms })
    })
    .collect()
}

/// Measures the time until a server answers for a session.
fn opened(server: &ServerProcess, session: &str) -> Result<Duration, BenchError> {
    let began = Instant::now();
    let response = server.get(&format!("/sessions/{session}"))?;
    let took = began.elapsed();
    if response.status == 200 { Ok(took) } else { Err(BenchError::Refused(response.text())) }
}

/// Runs `bendylights replay` on a log and returns its rate.
fn replay(program: &Path, log: &Path) -> Result<EditRate, BenchError> {
    let text = answer(program, &["replay", &log.display().to_string()])?;
    let said: serde_json::Value =
        serde_json::from_str(&text).map_err(|_| BenchError::Refused(format!("`replay` answered {text}")))?;
    let (Some(records), Some(seconds)) = (said["records"].as_u64(), said["seconds"].as_f64()) else {
        return Err(BenchError::Refused(format!("`replay` answered {text}")));
    };
    let per_second = records as f64 / seconds.max(1e-3);
    Ok(EditRate { count: records as usize, per_second, latency_ms: None })
}

/// Runs a command of the program and returns its standard output.
fn answer(program: &Path, args: &[&str]) -> Result<String, BenchError> {
    let done = Process::new(program).args(args).output()?;
    if done.status.success() {
        return Ok(String::from_utf8_lossy(&done.stdout).into_owned());
    }
    Err(BenchError::Refused(String::from_utf8_lossy(&done.stderr).trim().to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_grow_up_to_all_edits() {
        assert_eq!(lengths(5_000), [6, 20, 61, 185, 555, 1_666, 5_000]);
        assert_eq!(lengths(5), [1, 5]);
        assert_eq!(lengths(1), [1]);
    }
}
