//! How long it takes until an edit is on the screen, and where the time goes.

use std::path::Path;
use std::time::Instant;

use plotters::prelude::*;
use protocol::ClientMessage;
use render::Backend;
use serde::Serialize;

use crate::cases::{self, Case};
use crate::circle::{Drag, GESTURE, Shown, decode, drag_in_a_circle, ms, open_view, quantiles};
pub use crate::circle::{Quantiles, Stages};
use crate::{BenchError, Client, Incoming, ServerProcess};

/// What to measure.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Updates of the drag.
    pub updates: u64,
    /// Who draws shadows and lights; as the server chooses where nobody says.
    pub backend: Option<Backend>,
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
    /// The same drag in views of two sizes, alone and watched.
    pub cases: Vec<Case>,
}

/// Starts `program serve` on data of its own, drags a control point of the demo scene's light in a circle, and
/// measures. `progress` is told how many updates have been sent.
pub fn run(program: &Path, options: Options, progress: impl Fn(u64)) -> Result<(Report, String), BenchError> {
    let data = tempfile::tempdir()?;
    let backend = options.backend.map_or("auto", Backend::name);
    let server =
        ServerProcess::start(program, data.path(), &["--scene", "demo:vases", "--backend", backend])?;
    server.wait_until_ready()?;
    let mut client = Client::connect(&server.address, "main", "bench", None)?;
    open_view(&mut client, [options.width, options.height])?;

    let base_seq = client.welcome.seq;
    let (mut drag, seconds) = drag_in_a_circle(&mut client, options.updates, progress)?;
    let released = Instant::now();
    let gesture = GESTURE.into();
    client.send(&ClientMessage::GestureCommit { gesture, op_id: "bench-commit".into() })?;
    client.wait_for("the lossless picture", |incoming| match incoming {
        Incoming::Frame(header, tiles) if header.flags.settle && header.log_seq > base_seq => {
            Some(decode(&header, &tiles, &mut drag.picture))
        }
        _ => None,
    })??;
    let release_to_lossless_ms = ms(released.elapsed());
    // It would be drawn for too.
    drop(client);
    let cases = cases::measure(&server, options.updates)?;
    let report = report(&drag, &options, seconds, release_to_lossless_ms, cases);
    let chart = chart(&drag.shown, &report).map_err(|error| BenchError::Chart(error.to_string()))?;
    Ok((report, chart))
}

fn report(
    drag: &Drag,
    options: &Options,
    seconds: f64,
    release_to_lossless_ms: f64,
    cases: Vec<Case>,
) -> Report {
    let stage = |of: fn(&Stages<f64>) -> f64| quantiles(drag.shown.iter().map(|s| of(&s.stages)).collect());
    let bytes = drag.frame_bytes();
    Report {
        what: "control point 2 of demo:vases' light, dragged in a circle, on loopback",
        width: options.width,
        height: options.height,
        updates: options.updates,
        frames: drag.shown.len(),
        frames_per_second: drag.shown.len() as f64 / seconds,
        edit_to_decoded: drag.edit_to_decoded(),
        stages: Stages {
            wait: stage(|s| s.wait),
            render: stage(|s| s.render),
            encode: stage(|s| s.encode),
            send: stage(|s| s.send),
            decode: stage(|s| s.decode),
        },
        release_to_lossless_ms,
        frame_bytes_p50: bytes.get(bytes.len() / 2).copied().unwrap_or(0),
        cases,
    }
}

/// An SVG: a bar a frame, its stages stacked, and the quantiles of all updates as lines; below it the cases.
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
        let root = SVGBackend::with_string(&mut svg, (900, 760)).into_drawing_area();
        root.fill(&WHITE)?;
        let (frames, below) = root.split_vertically(420);
        cases::draw(&below, &report.cases)?;
        let Quantiles { p50_ms, p95_ms } = report.edit_to_decoded;
        let total = |s: &Stages<f64>| STAGES.iter().map(|(_, _, of)| of(s)).sum::<f64>();
        let top = shown.iter().map(|s| total(&s.stages)).fold(p95_ms, f64::max) * 1.1 + 1.0;
        let caption = format!("edit to decoded frame: p50 {p50_ms:.0} ms, p95 {p95_ms:.0} ms");
        let mut plot = ChartBuilder::on(&frames)
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
