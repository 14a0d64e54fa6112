//! Measures a drag while the server renders stills for other clients.

use std::path::Path;
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use image::RgbImage;
use render::Backend;
use serde::Serialize;

use crate::circle::{ANIMATION_FRAME, decode, ms, open_view, time_until};
use crate::dragged::DragCircle;
use crate::{BenchError, Client, Incoming, Response, ServerProcess};

/// Options of the benchmark of a drag beside stills.
#[derive(Clone, Copy, Debug)]
pub struct StillsBenchOptions {
    /// Width and height of the view in pixels.
    pub view: [u32; 2],
    /// Duration of each drag.
    pub drag: Duration,
    /// Number of stills.
    pub stills: usize,
    /// Width and height of a still in pixels.
    pub still: [u32; 2],
    /// Samples per pixel of a still.
    pub samples: u32,
    /// Backend that draws shadows and lights; the server selects it if `None`.
    pub backend: Option<Backend>,
}

/// Frame rate and gaps between frames of a drag.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct FramePace {
    /// Frames decoded per second.
    pub frames_per_second: f64,
    /// Median gap between two frames.
    pub usual_gap_ms: f64,
    pub longest_gap_ms: f64,
}

/// Results of the benchmark of a drag beside stills.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct StillsBenchReport {
    /// The drag without other work: before the stills, and after all have finished.
    pub alone: [FramePace; 2],
    /// The drag while the server renders stills.
    pub beside: FramePace,
    /// Frame rate during the stills, as a share of the mean frame rate without them.
    pub rate_kept: f64,
    /// Longest gap during the stills, as a multiple of the mean of the median gaps without them.
    pub longest_gap_of_usual: f64,
    /// Number of slices of drawing time that the slowest still had had when the drag ended.
    pub least_turns: f64,
    /// Number of stills that finished before the drag.
    pub finished_early: usize,
    /// Seconds from the first request until all stills are answered with a picture.
    pub all_finished_s: f64,
}

/// Starts `program serve` with new data, drags in one session, and drags again while stills are rendered, each in a
/// session of its own.
pub fn run(program: &Path, options: &StillsBenchOptions) -> Result<StillsBenchReport, BenchError> {
    let server = ServerProcess::start_with_new_data(program, "demo:vases", options.backend)?;
    for still in 0..options.stills {
        let session = format!(r#"{{"name": "{}", "scene": "demo:vases"}}"#, session_of(still));
        created(&server.post("/sessions", session.as_bytes())?)?;
    }
    let mut client = viewer(&server, options)?;
    let before = drag(&mut client, "before", options.drag)?;
    let requested = Instant::now();
    let stills = ask(&server, options);
    wait_for_turns(&server, &stills)?;
    let beside = drag(&mut client, "beside", options.drag)?;
    let least_turns = server.metric("bendylights_least_still_turns", "")?;
    let finished_early = stills.iter().filter(|still| still.is_finished()).count();
    // This client reads nothing from here on, and a server closes the connection of a silent client.
    drop(client);
    for still in stills {
        still.join().map_err(|_| BenchError::Refused("a still's request panicked".into()))??;
    }
    let all_finished_s = requested.elapsed().as_secs_f64();
    let after = drag(&mut viewer(&server, options)?, "after", options.drag)?;

    let mean = |of: fn(&FramePace) -> f64| f64::midpoint(of(&before), of(&after));
    Ok(StillsBenchReport {
        alone: [before, after],
        beside,
        rate_kept: beside.frames_per_second / mean(|pace| pace.frames_per_second),
        longest_gap_of_usual: beside.longest_gap_ms / mean(|pace| pace.usual_gap_ms),
        least_turns,
        finished_early,
        all_finished_s,
    })
}

/// Connects a client and waits until its view is at rest.
fn viewer(server: &ServerProcess, options: &StillsBenchOptions) -> Result<Client, BenchError> {
    let mut client = Client::connect(&server.address, "main", "bench", None)?;
    open_view(&mut client, options.view, None)?;
    Ok(client)
}

/// Returns the session of a still. Each still has its own, because the server limits the stills of one session that run
/// at once.
fn session_of(still: usize) -> String {
    format!("still-{still}")
}

/// Requests all stills at once, each on a connection of its own.
fn ask(server: &ServerProcess, options: &StillsBenchOptions) -> Vec<JoinHandle<Result<(), BenchError>>> {
    let ([width, height], samples) = (options.still, options.samples);
    let still = |still| {
        let server = server.address.clone();
        let path = format!("/sessions/{}/render?size={width}x{height}&samples={samples}", session_of(still));
        thread::spawn(move || created(&server.get(&path)?))
    };
    (0..options.stills).map(still).collect()
}

/// Waits until each still has had a slice of the renderer's time.
fn wait_for_turns(server: &ServerProcess, stills: &[JoinHandle<Result<(), BenchError>>]) -> Result<(), BenchError> {
    let within = Duration::from_mins(2);
    let until = Instant::now() + within;
    // The least is over the stills in the queue: those that are still to come count too.
    let have_come = || {
        let queued = server.metric("bendylights_render_queue", "urgency=\"still\"")?;
        let finished = stills.iter().filter(|still| still.is_finished()).count();
        Ok::<_, BenchError>(queued + finished as f64 >= stills.len() as f64)
    };
    while !(have_come()? && server.metric("bendylights_least_still_turns", "")? >= 1.0) {
        if Instant::now() > until {
            return Err(BenchError::Silent { what: "a turn of each still", within });
        }
        thread::sleep(Duration::from_millis(50));
    }
    Ok(())
}

fn created(response: &Response) -> Result<(), BenchError> {
    if matches!(response.status, 200 | 201) { Ok(()) } else { Err(BenchError::Refused(response.text())) }
}

/// Drags the control point of the demo in circles for `time`, and measures its frames.
fn drag(client: &mut Client, gesture: &str, time: Duration) -> Result<FramePace, BenchError> {
    let circle = DragCircle::of(client)?;
    client.begin_gesture(gesture, circle.light)?;
    let (began, mut update) = (Instant::now(), 0);
    let (mut shown, mut picture) = (Vec::<Instant>::new(), RgbImage::new(0, 0));
    while began.elapsed() < time {
        update += 1;
        client.update_gesture(gesture, update, circle.command(0.05 * update as f64))?;
        while let Some(left) = time_until(began + ANIMATION_FRAME * update as u32) {
            if let Some(Incoming::Frame(header, tiles)) = client.receive(left)? {
                decode(&header, &tiles, &mut picture)?;
                client.ack(&header)?;
                shown.push(Instant::now());
            }
        }
    }
    client.cancel_gesture(gesture)?;
    // The next drag begins with a view at rest.
    client.wait_until_settled("the lossless picture")?;
    let until = began + time;
    // A gap that is still open at the end counts up to the end.
    let ends = shown.iter().skip(1).copied().chain([until]);
    let mut gaps: Vec<f64> = shown.iter().zip(ends).map(|(from, to)| ms(to.saturating_duration_since(*from))).collect();
    gaps.sort_by(f64::total_cmp);
    let (Some(usual), Some(longest)) = (gaps.get(gaps.len() / 2), gaps.last()) else {
        return Err(BenchError::Silent { what: "a frame of the drag", within: time });
    };
    Ok(FramePace {
        frames_per_second: shown.len() as f64 / time.as_secs_f64(),
        usual_gap_ms: *usual,
        longest_gap_ms: *longest,
    })
}
