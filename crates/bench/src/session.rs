//! How long it takes until an edit is on the screen, and where the time goes.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::{Duration, Instant};

use light::CheckedLight;
use plotters::prelude::*;
use protocol::{Camera, ClientMessage, Command, PointParameter, ServerMessage, State, Vec3, ViewSource};
use serde::Serialize;
use stream::FrameHeader;

use crate::{BenchError, Client, Incoming, ServerProcess};

/// A page sends at most one update an animation frame.
pub(crate) const ANIMATION_FRAME: Duration = Duration::from_micros(16_667);
/// How far the control point goes around its place, in light-local units.
pub(crate) const RADIUS: f64 = 0.25;

/// What to measure.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Updates of the drag.
    pub updates: u64,
}

/// Milliseconds of the middle and of the slow end of many.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Quantiles {
    /// Half are faster.
    pub p50_ms: f64,
    /// 95 in 100 are faster.
    pub p95_ms: f64,
}

/// What was measured.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// What was dragged.
    pub what: &'static str,
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Updates sent, one an animation frame.
    pub updates: u64,
    /// Frames decoded during the drag.
    pub frames: usize,
    /// Frames a second during the drag.
    pub frames_per_second: f64,
    /// From sending an update to having decoded the first frame that shows it or a later one.
    pub edit_to_decoded: Quantiles,
    /// Where the time of the newest update of each frame went.
    pub stages: Stages<Quantiles>,
    /// From letting go to having decoded the lossless picture.
    pub release_to_lossless_ms: f64,
    /// Bytes of a moving frame, the middle of all.
    pub frame_bytes_p50: usize,
}

/// The way of an update to the screen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Stages<T> {
    /// From the change in the session to the start of the render: the render before, and the open slot.
    pub wait: T,
    /// Of the render, with its read-back.
    pub render: T,
    /// Of the encoding.
    pub encode: T,
    /// All else: the update's and the frame's way through sockets and queues.
    pub send: T,
    /// Of the decoding, by the client.
    pub decode: T,
}

/// A frame of the drag.
#[derive(Clone, Copy, Debug)]
struct Shown {
    /// Milliseconds.
    stages: Stages<f64>,
    bytes: usize,
}

/// Starts `program serve` on data of its own, drags a control point of the demo scene's light in a circle, and
/// measures. `progress` is told how many updates have been sent.
pub fn run(program: &Path, options: Options, progress: impl Fn(u64)) -> Result<(Report, String), BenchError> {
    let data = tempfile::tempdir()?;
    let server = ServerProcess::start(program, data.path(), &["--scene", "demo:vases"])?;
    server.wait_until_ready()?;
    let mut client = Client::connect(&server.address, "main", "bench", None)?;
    open_view(&mut client, [options.width, options.height])?;

    let (light, start) = control_point(&client)?;
    let gesture = "bench".to_owned();
    let base_seq = client.welcome.seq;
    client.send(&ClientMessage::GestureBegin { gesture: gesture.clone(), light, base_seq })?;
    let mut drag = Drag::default();
    let began = Instant::now();
    for update in 1..=options.updates {
        let angle = std::f64::consts::TAU * update as f64 / options.updates as f64;
        let [x, y, z] = start;
        let position = [x + RADIUS * angle.sin(), y + RADIUS * (1.0 - angle.cos()), z];
        let command = Command::SetPoint { light, point: 2, parameter: position_of(position) };
        drag.sent.insert(update, Instant::now());
        client.send(&ClientMessage::GestureUpdate { gesture: gesture.clone(), update, command })?;
        let next = began + ANIMATION_FRAME * update as u32;
        while let Some(left) = next.checked_duration_since(Instant::now()).filter(|left| !left.is_zero()) {
            drag.take(&mut client, left)?;
        }
        progress(update);
    }
    while drag.latest_shown < options.updates {
        drag.take(&mut client, Duration::from_secs(1))?;
        if began.elapsed() > Duration::from_mins(10) {
            return Err(BenchError::Silent { what: "the last update's frame", within: began.elapsed() });
        }
    }
    let seconds = began.elapsed().as_secs_f64();
    let released = Instant::now();
    client.send(&ClientMessage::GestureCommit { gesture, op_id: "bench-commit".into() })?;
    client.wait_for("the lossless picture", |incoming| match incoming {
        Incoming::Frame(header, payload) if header.flags.settle && header.log_seq > base_seq => {
            decode(&payload).err().map_or(Some(Ok(())), |error| Some(Err(error)))
        }
        _ => None,
    })??;
    let release_to_lossless_ms = ms(released.elapsed());
    let report = drag.report(&options, seconds, release_to_lossless_ms);
    let chart = chart(&drag.shown, &report).map_err(|error| BenchError::Chart(error.to_string()))?;
    Ok((report, chart))
}

/// Waits for the first lossless picture too, so that nothing else is under way.
pub(crate) fn open_view(client: &mut Client, [width, height]: [u32; 2]) -> Result<(), BenchError> {
    let camera: Camera = client.welcome.camera.clone();
    client.send(&ClientMessage::OpenView {
        source: ViewSource::Own(camera),
        width,
        height,
        camera_revision: 1,
        settings: None,
    })?;
    client.wait_for("a first lossless picture", |incoming| {
        matches!(incoming, Incoming::Frame(header, _) if header.flags.settle).then_some(())
    })
}

/// The demo's light and where its third control point is.
pub(crate) fn control_point(client: &Client) -> Result<(u64, Vec3), BenchError> {
    let State::Snapshot(document) = &client.welcome.state else {
        return Err(BenchError::Refused("it gave no document".into()));
    };
    let bendy = document.lights.iter().find_map(|light| {
        let checked = CheckedLight::try_from(light.light.clone()).ok()?;
        Some((light.id, checked.light().points().get(2)?.position.to_array()))
    });
    bendy.ok_or_else(|| BenchError::Refused("its scene has no BendyLight".into()))
}

/// The parameter that moves a control point.
pub(crate) fn position_of(position: Vec3) -> PointParameter {
    light::parameters::POSITION.to(position.into()).into()
}

/// What is known of a drag while it goes on.
#[derive(Debug, Default)]
struct Drag {
    /// When each update was sent.
    sent: BTreeMap<u64, Instant>,
    /// The update that each live revision shows.
    update_of: BTreeMap<u32, u64>,
    /// The latest update that has been decoded.
    latest_shown: u64,
    /// Milliseconds from each update to its picture.
    latencies_ms: Vec<f64>,
    shown: Vec<Shown>,
}

impl Drag {
    /// Receives for at most `timeout`.
    fn take(&mut self, client: &mut Client, timeout: Duration) -> Result<(), BenchError> {
        match client.receive(timeout)? {
            Some(Incoming::Message(message)) => match *message {
                ServerMessage::GestureState(state) => {
                    if let Some(problem) = state.status.problem() {
                        return Err(BenchError::Refused(problem.message.clone()));
                    }
                    self.update_of.insert(state.live_revision, state.update);
                }
                ServerMessage::Error { message, .. } => return Err(BenchError::Refused(message)),
                _ => {}
            },
            Some(Incoming::Frame(header, payload)) => {
                let received = Instant::now();
                decode(&payload)?;
                let decoded = Instant::now();
                client.ack(&header)?;
                self.note(&header, payload.len(), decoded - received, decoded);
            }
            None => {}
        }
        Ok(())
    }

    fn note(&mut self, header: &FrameHeader, bytes: usize, decode: Duration, decoded: Instant) {
        let shows =
            self.update_of.range(..=header.live_revision).next_back().map_or(0, |(_, update)| *update);
        if shows <= self.latest_shown {
            return;
        }
        let first_new = self.latest_shown + 1;
        for update in first_new..=shows {
            self.latencies_ms.extend(self.sent.get(&update).map(|sent| ms(decoded - *sent)));
        }
        self.latest_shown = shows;
        let Some(sent) = self.sent.get(&shows) else { return };
        let us = |us: u32| f64::from(us) / 1000.0;
        let (wait, render, encode) = (us(header.wait_us), us(header.render_us), us(header.encode_us));
        let decode = ms(decode);
        // The header's wait counts from the oldest change that the frame shows first; the newest update's own wait is
        // what its way leaves of it.
        let wait = wait.min((ms(decoded - *sent) - render - encode - decode).max(0.0));
        let send = (ms(decoded - *sent) - wait - render - encode - decode).max(0.0);
        self.shown.push(Shown { stages: Stages { wait, render, encode, send, decode }, bytes });
    }

    fn report(&self, options: &Options, seconds: f64, release_to_lossless_ms: f64) -> Report {
        let stage =
            |of: fn(&Stages<f64>) -> f64| quantiles(self.shown.iter().map(|s| of(&s.stages)).collect());
        let mut bytes: Vec<_> = self.shown.iter().map(|shown| shown.bytes).collect();
        bytes.sort_unstable();
        Report {
            what: "control point 2 of demo:vases' light, dragged in a circle, on loopback",
            width: options.width,
            height: options.height,
            updates: options.updates,
            frames: self.shown.len(),
            frames_per_second: self.shown.len() as f64 / seconds,
            edit_to_decoded: quantiles(self.latencies_ms.clone()),
            stages: Stages {
                wait: stage(|s| s.wait),
                render: stage(|s| s.render),
                encode: stage(|s| s.encode),
                send: stage(|s| s.send),
                decode: stage(|s| s.decode),
            },
            release_to_lossless_ms,
            frame_bytes_p50: bytes.get(bytes.len() / 2).copied().unwrap_or(0),
        }
    }
}

pub(crate) fn decode(payload: &[u8]) -> Result<(), BenchError> {
    image::load_from_memory(payload)?;
    Ok(())
}

pub(crate) fn ms(duration: Duration) -> f64 {
    duration.as_secs_f64() * 1000.0
}

/// Of values in any order; 0 of none.
fn quantiles(mut values: Vec<f64>) -> Quantiles {
    values.sort_by(f64::total_cmp);
    let at = |share: f64| {
        let index = (share * values.len() as f64).ceil() as usize;
        values.get(index.saturating_sub(1)).copied().unwrap_or(0.0)
    };
    Quantiles { p50_ms: at(0.5), p95_ms: at(0.95) }
}

/// An SVG: a bar a frame, its stages stacked, and the quantiles of all updates as lines.
fn chart(shown: &[Shown], report: &Report) -> Result<String, Box<dyn std::error::Error>> {
    type Stage = (&'static str, RGBColor, fn(&Stages<f64>) -> f64);
    const STAGES: [Stage; 5] = [
        ("wait", RGBColor(0xb0, 0xb0, 0xb0), |s| s.wait),
        ("render", RGBColor(0x2f, 0x6d, 0xb5), |s| s.render),
        ("encode", RGBColor(0xe0, 0x8a, 0x1e), |s| s.encode),
        ("send", RGBColor(0x7a, 0x5c, 0xa8), |s| s.send),
        ("decode", RGBColor(0x3a, 0x9a, 0x5c), |s| s.decode),
    ];
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, (900, 420)).into_drawing_area();
        root.fill(&WHITE)?;
        let Quantiles { p50_ms, p95_ms } = report.edit_to_decoded;
        let total = |s: &Stages<f64>| STAGES.iter().map(|(_, _, of)| of(s)).sum::<f64>();
        let top = shown.iter().map(|s| total(&s.stages)).fold(p95_ms, f64::max) * 1.1 + 1.0;
        let caption = format!("edit to decoded frame: p50 {p50_ms:.0} ms, p95 {p95_ms:.0} ms");
        let mut plot = ChartBuilder::on(&root)
            .caption(caption, ("sans-serif", 20))
            .margin(12)
            .x_label_area_size(36)
            .y_label_area_size(56)
            .build_cartesian_2d(0.0..shown.len().max(1) as f64, 0.0..top)?;
        plot.configure_mesh().x_desc("frame of the drag").y_desc("ms").disable_x_mesh().draw()?;
        for (index, (name, color, _)) in STAGES.iter().enumerate() {
            let bar = |(frame, shown): (usize, &Shown)| {
                let bottom: f64 = STAGES[..index].iter().map(|(_, _, of)| of(&shown.stages)).sum();
                let height = STAGES[index].2(&shown.stages);
                let x = frame as f64;
                Rectangle::new([(x + 0.08, bottom), (x + 0.92, bottom + height)], color.filled())
            };
            let key = *color;
            plot.draw_series(shown.iter().enumerate().map(bar))?
                .label(*name)
                .legend(move |(x, y)| Rectangle::new([(x, y - 5), (x + 12, y + 5)], key.filled()));
        }
        for level in [p50_ms, p95_ms] {
            plot.draw_series(LineSeries::new([(0.0, level), (shown.len() as f64, level)], BLACK))?;
        }
        plot.configure_series_labels()
            .position(SeriesLabelPosition::UpperLeft)
            .background_style(WHITE.mix(0.85))
            .border_style(BLACK.mix(0.3))
            .draw()?;
        root.present()?;
    }
    Ok(svg)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_values_that_were_measured() {
        let hundred: Vec<f64> = (1..=100).rev().map(f64::from).collect();
        assert_eq!(quantiles(hundred), Quantiles { p50_ms: 50.0, p95_ms: 95.0 });
        assert_eq!(quantiles(vec![7.0]), Quantiles { p50_ms: 7.0, p95_ms: 7.0 });
        assert_eq!(quantiles(Vec::new()), Quantiles { p50_ms: 0.0, p95_ms: 0.0 });
    }
}
