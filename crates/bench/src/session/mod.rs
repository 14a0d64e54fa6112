//! Measures the latency from an edit to the decoded frame, and its stages. If the CPU shades the pictures, wgpu is
//! measured too.

mod chart;

use std::path::Path;
use std::time::Instant;

use protocol::ClientMessage;
use render::Backend;
use serde::Serialize;

use crate::cases::{self, SessionCase};
pub use crate::circle::LatencyStages;
use crate::circle::{CircleDrag, GESTURE, decode, drag_in_a_circle, ms, open_view};
use crate::dragged::{DragCircle, ensure_bent_light};
use crate::frame::backends;
use crate::peers::{FEWEST_FRAMES, Peer, Peers, RUNS};
use crate::{BenchError, Client, Incoming, Progress, Quantiles, ServerProcess};

/// Options of the benchmark of a drag over the server.
#[derive(Clone, Copy, Debug)]
pub struct SessionBenchOptions<'a> {
    /// Scene that the server loads: `demo:NAME` or a glTF file.
    pub scene: &'a str,
    /// Name of the scene in the report.
    pub name: &'a str,
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Number of updates of the drag.
    pub updates: u64,
    /// Backend that draws shadows and lights; the device decides if `None`.
    pub backend: Option<Backend>,
    /// Other renderers to run for comparison.
    pub peers: Option<&'a Peers>,
}

/// Results of the benchmark of a drag over the server.
#[derive(Clone, Debug, Default, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct SessionBenchReport {
    /// `demo:NAME`, or the name of a file without its folder.
    pub scene: String,
    /// Description of the drag.
    pub what: String,
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Updates sent in each drag, one per animation frame.
    pub updates: u64,
    /// Measurements of the drag by the measured backend, followed by the same drag by wgpu if the measured backend is
    /// another. Each drag has a server of its own. The one of wgpu runs first.
    pub drags: Vec<BackendDrag>,
    /// The same drag by the measured backend, in views of two sizes, with and without other viewers.
    pub cases: Vec<SessionCase>,
    /// Other renderers; empty if none were requested.
    pub peers: Vec<PeerFrames>,
}

/// Measurements of one drag.
#[derive(Clone, Debug, Default, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct BackendDrag {
    /// Backend that drew shadows and lights.
    pub backend: &'static str,
    /// Frames decoded during the drag.
    pub frames: usize,
    pub frames_per_second: f64,
    /// Time from sending an update until the first frame that shows it, or a later update, is decoded.
    pub edit_to_decoded_ms: Quantiles,
    /// Stages of the latency of the newest update of each frame.
    pub stages_ms: LatencyStages<Quantiles>,
    /// Time from the commit of the gesture to having decoded the lossless picture.
    pub release_to_lossless_ms: f64,
    /// Median bytes of a moving frame.
    pub frame_bytes_p50: usize,
}

/// Frame times of another renderer, with a scene and size of its own. Its frames are read back, but neither encoded nor
/// sent.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct PeerFrames {
    /// Name that its script prints.
    pub name: String,
    /// Version that its script prints.
    pub version: String,
    /// Milliseconds per frame: quantiles of the medians of the runs.
    pub wall_ms: Quantiles,
    /// Median edit-to-decoded time of the first drag over the median of `wall_ms`.
    pub edit_to_decoded_over_it: f64,
}

/// Starts `program serve` with new data, drags a control point of the scene's first BendyLight in a circle, and
/// measures. If the backend is not wgpu, measures wgpu first. Measures other renderers last. Returns the report and the
/// chart in SVG.
pub fn run(
    program: &Path,
    options: &SessionBenchOptions,
    progress: &dyn Fn(Progress),
) -> Result<(SessionBenchReport, String), BenchError> {
    let backends = backends(options.backend)?;
    let of = backends.len() + 1 + RUNS * options.peers.map_or(0, Peers::count);
    let mut done = 0;
    let mut step = |what: String| {
        progress(Progress { done, of, what });
        done += 1;
    };
    let (mut what, mut measured, mut cases) = (String::new(), Vec::new(), Vec::new());
    // The measured backend runs last, followed by its cases. So little time passes between the two drags, in which
    // another process could load the machine, and each drag is the first one of its server.
    for (index, backend) in backends.into_iter().enumerate().rev() {
        step(format!("the drag by {}", backend.name()));
        let server = ServerProcess::start_with_new_data(program, options.scene, Some(backend))?;
        let made = ensure_bent_light(&server)?;
        let (circle, drag, report) = measure_drag(&server, options, backend)?;
        measured.push((drag, report));
        if index == 0 {
            step("sizes and viewers".into());
            cases = cases::measure(&server, options.updates)?;
            what = circle.what(options.name) + if made { "; its first light, bent and alone" } else { "" };
        }
    }
    measured.reverse();
    let p50_ms = measured.first().map_or(0.0, |(_, report)| report.edit_to_decoded_ms.p50);
    let peers = options.peers.map_or(Ok(Vec::new()), |peers| measure_peers(peers, p50_ms, &mut step))?;
    let (drags, reports): (Vec<CircleDrag>, Vec<BackendDrag>) = measured.into_iter().unzip();
    let report = SessionBenchReport {
        scene: options.name.into(),
        what,
        width: options.width,
        height: options.height,
        updates: options.updates,
        drags: reports,
        cases,
        peers,
    };
    let shown: Vec<_> = drags.iter().map(|drag| &*drag.shown).collect();
    let chart = chart::draw(&shown, &report)?;
    Ok((report, chart))
}

/// Measures the drag up to its lossless picture.
fn measure_drag(
    server: &ServerProcess,
    options: &SessionBenchOptions,
    backend: Backend,
) -> Result<(DragCircle, CircleDrag, BackendDrag), BenchError> {
    let mut client = Client::connect(&server.address, "main", "bench", None)?;
    open_view(&mut client, [options.width, options.height], None)?;
    let circle = DragCircle::of(&client)?;
    let base_seq = client.welcome.seq;
    let mut drag = drag_in_a_circle(&mut client, options.updates)?;
    let released = Instant::now();
    let gesture = GESTURE.into();
    client.send(&ClientMessage::GestureCommit { gesture, op_id: "bench-commit".into() })?;
    client.wait_for("the lossless picture", |incoming| match incoming {
        Incoming::Frame(header, tiles) if header.flags.is_settled && header.log_seq > base_seq => {
            Some(decode(&header, &tiles, &mut drag.picture))
        }
        _ => None,
    })??;
    let release_to_lossless_ms = ms(released.elapsed());
    let report = BackendDrag::of(&drag, backend, release_to_lossless_ms);
    Ok((circle, drag, report))
}

/// Runs each renderer in turn, and repeats all of them `RUNS` times.
fn measure_peers(peers: &Peers, p50_ms: f64, step: &mut impl FnMut(String)) -> Result<Vec<PeerFrames>, BenchError> {
    let mut lines = Vec::new();
    for _ in 0..RUNS {
        lines.extend(peers.run_all(FEWEST_FRAMES, || step("peers".into()))?);
    }
    let frames = |Peer { name, version, wall_ms }| {
        let edit_to_decoded_over_it = p50_ms / wall_ms.p50;
        PeerFrames { name, version, wall_ms, edit_to_decoded_over_it }
    };
    Ok(Peer::all(&lines).into_iter().map(frames).collect())
}

impl BackendDrag {
    fn of(drag: &CircleDrag, backend: Backend, release_to_lossless_ms: f64) -> Self {
        let stage = |of: fn(&LatencyStages<f64>) -> f64| Quantiles::of(drag.shown.iter().map(|s| of(&s.stages)));
        Self {
            backend: backend.name(),
            frames: drag.shown.len(),
            frames_per_second: drag.shown.len() as f64 / drag.seconds,
            edit_to_decoded_ms: drag.edit_to_decoded_ms(),
            stages_ms: LatencyStages {
                wait: stage(|s| s.wait),
                render: stage(|s| s.render),
                encode: stage(|s| s.encode),
                send: stage(|s| s.send),
                decode: stage(|s| s.decode),
            },
            release_to_lossless_ms,
            frame_bytes_p50: drag.frame_bytes_p50(),
        }
    }
}
