//! Measures the same drag for views of two sizes, with and without other clients that watch.

use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use image::RgbImage;
use plotters::prelude::*;
use serde::Serialize;

use crate::chart::{self, Area, BLUE, ChartResult, GREY, PlotLayout};
use crate::circle::{GESTURE, decode, drag_in_a_circle, open_view};
use crate::{BenchError, Client, Incoming, Quantiles, ServerProcess};

/// Sizes of views in pixels, and numbers of clients with one view each. One client drags, the others watch.
const SIZES: [[u32; 2]; 2] = [[686, 382], [1280, 720]];
const VIEWERS: [usize; 2] = [1, 4];

/// Result of a drag at one view size with a number of viewers.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct SessionCase {
    /// Pixels of each view.
    pub width: u32,
    /// Pixels of each view.
    pub height: u32,
    /// Clients, each with a view of its own; one of them drags.
    pub viewers: usize,
    /// Frames per second of the client that drags.
    pub frames_per_second: f64,
    /// Mean frames per second of the clients that watch; `null` if there are none.
    pub watched_frames_per_second: Option<f64>,
    /// Time from sending an update to having decoded the first frame that shows it or a later one, in the client that
    /// drags.
    pub edit_to_decoded_ms: Quantiles,
    /// Median bytes of a moving frame of the client that drags.
    pub frame_bytes_p50: usize,
    /// Bytes per second of the frames of the client that drags.
    pub bytes_per_second: f64,
}

pub(crate) fn measure(server: &ServerProcess, updates: u64) -> Result<Vec<SessionCase>, BenchError> {
    let cases = SIZES.iter().flat_map(|size| VIEWERS.iter().map(move |viewers| (*size, *viewers)));
    cases.map(|(size, viewers)| measure_one(server, size, viewers, updates)).collect()
}

fn measure_one(
    server: &ServerProcess,
    size: [u32; 2],
    viewers: usize,
    updates: u64,
) -> Result<SessionCase, BenchError> {
    let mut clients = (0..viewers)
        .map(|_| {
            let mut client = Client::connect(&server.address, "main", "bench", None)?;
            open_view(&mut client, size, None)?;
            Ok(client)
        })
        .collect::<Result<Vec<Client>, BenchError>>()?;
    let mut dragger = clients.pop().ok_or_else(|| BenchError::Refused("it has nobody who drags".into()))?;
    let is_over = &AtomicBool::new(false);
    let (drag, watched) = thread::scope(|scope| {
        let watchers: Vec<_> = clients.into_iter().map(|client| scope.spawn(move || watch(client, is_over))).collect();
        let dragged = drag_in_a_circle(&mut dragger, updates);
        is_over.store(true, Ordering::Relaxed);
        let watched: Result<Vec<f64>, BenchError> = watchers
            .into_iter()
            .map(|watcher| watcher.join().map_err(|_| BenchError::Refused("a client panicked".into()))?)
            .collect();
        Ok::<_, BenchError>((dragged?, watched?))
    })?;
    dragger.cancel_gesture(GESTURE)?;
    let watched_frames_per_second = (!watched.is_empty()).then(|| watched.iter().sum::<f64>() / watched.len() as f64);
    Ok(SessionCase {
        width: size[0],
        height: size[1],
        viewers,
        frames_per_second: drag.shown.len() as f64 / drag.seconds,
        watched_frames_per_second,
        edit_to_decoded_ms: drag.edit_to_decoded_ms(),
        frame_bytes_p50: drag.frame_bytes_p50(),
        bytes_per_second: drag.shown.iter().map(|shown| shown.bytes).sum::<usize>() as f64 / drag.seconds,
    })
}

/// Receives and decodes frames until the drag is over. Returns frames per second.
fn watch(mut client: Client, is_over: &AtomicBool) -> Result<f64, BenchError> {
    let (began, mut frames, mut picture) = (Instant::now(), 0, RgbImage::new(0, 0));
    while !is_over.load(Ordering::Relaxed) {
        if let Some(Incoming::Frame(header, tiles)) = client.receive(Duration::from_millis(20))? {
            decode(&header, &tiles, &mut picture)?;
            client.ack(&header)?;
            frames += 1;
        }
    }
    Ok(f64::from(frames) / began.elapsed().as_secs_f64())
}

/// Draws two bars per case, p50 and p95, with the frames per second above them.
pub(crate) fn draw(area: &Area, cases: &[SessionCase]) -> ChartResult {
    const BARS: [(&str, RGBColor, f64); 2] = [("p50", BLUE, 0.1), ("p95", GREY, 0.5)];
    let top = cases.iter().map(|case| case.edit_to_decoded_ms.p95).fold(1.0, f64::max) * 1.25;
    let mut plot = PlotLayout { caption: 20, margin: 12, below: 36, left: 56 }.plot(
        area,
        "edit to decoded frame, by size and viewers",
        0.0..cases.len().max(1) as f64,
        0.0..top,
    )?;
    plot.configure_mesh().y_desc("ms").disable_x_mesh().disable_x_axis().draw()?;
    for (name, color, from) in BARS {
        let ms = |case: &SessionCase| {
            if name == "p50" { case.edit_to_decoded_ms.p50 } else { case.edit_to_decoded_ms.p95 }
        };
        let bar = |(k, case): (usize, &SessionCase)| {
            let x = k as f64 + from;
            Rectangle::new([(x, 0.0), (x + 0.35, ms(case))], color.filled())
        };
        plot.draw_series(cases.iter().enumerate().map(bar))?.label(name).legend(chart::swatch(color));
    }
    let label = |(k, case): (usize, &SessionCase)| {
        let SessionCase { width, height, viewers, frames_per_second, .. } = case;
        let of = if *viewers == 1 { "viewer" } else { "viewers" };
        let text = format!("{width}x{height}, {viewers} {of}, {frames_per_second:.0}/s");
        Text::new(text, (k as f64 + 0.06, case.edit_to_decoded_ms.p95 + 0.06 * top), ("sans-serif", 14))
    };
    plot.draw_series(cases.iter().enumerate().map(label))?;
    chart::key(&mut plot, SeriesLabelPosition::UpperLeft)
}
