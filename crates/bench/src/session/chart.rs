//! Chart of the drags side by side, and the cases below them, in SVG.

use plotters::prelude::*;

use super::{BackendDrag, LatencyStages, SessionBenchReport};
use crate::chart::{self, Area, BLUE, ChartResult, FAINT, GREEN, GREY, ORANGE, PlotLayout, VIOLET};
use crate::circle::ShownFrame;
use crate::{BenchError, Quantiles, cases};

type StageSeries = (&'static str, RGBColor, fn(&LatencyStages<f64>) -> f64);

const STAGES: [StageSeries; 5] = [
    ("wait", GREY, |s| s.wait),
    ("render", BLUE, |s| s.render),
    ("encode", ORANGE, |s| s.encode),
    ("send", VIOLET, |s| s.send),
    ("decode", GREEN, |s| s.decode),
];

/// Size of the picture in pixels, and heights of the legend of the stages and of the drags.
const SIZE: (u32, u32) = (1100, 800);
const KEY: u32 = 26;
const DRAGS: u32 = 400;
/// Minimum width in pixels of a bar that gets a gap to the next.
const WIDE: f64 = 4.0;

/// Draws the frames of each drag of the report, in the order of the report.
pub(super) fn draw(shown: &[&[ShownFrame]], report: &SessionBenchReport) -> Result<String, BenchError> {
    let SessionBenchReport { scene, width, height, .. } = report;
    let title = format!("{scene}, {width} x {height} pixels: edit to decoded frame");
    chart::svg(SIZE, &title, |area| {
        let (above, rest) = area.split_vertically(KEY);
        let (drags, below) = rest.split_vertically(DRAGS);
        key(&above)?;
        let slow = report.drags.iter().map(|drag| drag.edit_to_decoded_ms.p95);
        let top = shown.iter().copied().flatten().map(total).chain(slow).fold(0.0, f64::max) * 1.1 + 1.0;
        let areas = drags.split_evenly((1, shown.len().max(1)));
        for ((area, shown), drag) in areas.iter().zip(shown).zip(&report.drags) {
            one(area, shown, drag, top)?;
        }
        cases::draw(&below, &report.cases)
    })
}

fn total(shown: &ShownFrame) -> f64 {
    STAGES.iter().map(|(_, _, of)| of(&shown.stages)).sum()
}

/// Draws the legend of the stages. Inside a plot it would hide bars.
fn key(area: &Area) -> ChartResult {
    for ((name, color, _), x) in STAGES.iter().zip((68..).step_by(100)) {
        area.draw(&Rectangle::new([(x, 8), (x + 12, 18)], color.filled()))?;
        area.draw(&Text::new(*name, (x + 18, 6), ("sans-serif", 14)))?;
    }
    Ok(())
}

/// Draws one bar per frame with its stages stacked, and the quantiles of all updates as lines, up to `top`
/// milliseconds.
fn one(area: &Area, shown: &[ShownFrame], drag: &BackendDrag, top: f64) -> ChartResult {
    let BackendDrag { backend, frames_per_second, edit_to_decoded_ms, .. } = drag;
    let Quantiles { p50, p95, .. } = *edit_to_decoded_ms;
    let caption = format!("{backend}: p50 {p50:.0} ms, p95 {p95:.0} ms, {frames_per_second:.0} frames/s");
    let frames = shown.len().max(1) as f64;
    let mut plot =
        PlotLayout { caption: 18, margin: 12, below: 36, left: 56 }.plot(area, &caption, 0.0..frames, 0.0..top)?;
    plot.configure_mesh().disable_x_mesh().light_line_style(FAINT).x_desc("frame of the drag").y_desc("ms").draw()?;
    let is_wide = f64::from(plot.plotting_area().dim_in_pixel().0) >= WIDE * frames;
    let beside = if is_wide { 0.08 } else { 0.0 };
    for (index, (_, color, of)) in STAGES.iter().enumerate() {
        let bar = |(frame, shown): (usize, &ShownFrame)| {
            let bottom: f64 = STAGES[..index].iter().map(|(_, _, of)| of(&shown.stages)).sum();
            let (left, right) = (frame as f64 + beside, (frame + 1) as f64 - beside);
            Rectangle::new([(left, bottom), (right, bottom + of(&shown.stages))], color.filled())
        };
        plot.draw_series(shown.iter().enumerate().map(bar))?;
    }
    for level in [p50, p95] {
        plot.draw_series(LineSeries::new([(0.0, level), (frames, level)], BLACK))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the chart of drags with one frame each, which has only a render of the given milliseconds.
    fn chart_of(drags: &[(&'static str, f64)]) -> String {
        let frame = |render| ShownFrame { stages: LatencyStages { render, ..LatencyStages::default() }, bytes: 0 };
        let shown: Vec<[ShownFrame; 1]> = drags.iter().map(|(_, ms)| [frame(*ms)]).collect();
        let drags = drags.iter().map(|&(backend, _)| BackendDrag { backend, ..BackendDrag::default() });
        let report = SessionBenchReport { drags: drags.collect(), ..SessionBenchReport::default() };
        let shown: Vec<&[ShownFrame]> = shown.iter().map(|shown| &shown[..]).collect();
        draw(&shown, &report).expect("drawn")
    }

    /// Returns the heights in pixels of the bars of renders, which are higher than the boxes of the legends.
    fn heights(svg: &str) -> Vec<f64> {
        let rects = svg.split("<rect ").filter(|rect| rect.contains("fill=\"#2F6DB5\""));
        let height = |rect: &str| rect.split_once(" height=\"")?.1.split_once('"')?.0.parse().ok();
        rects.filter_map(height).filter(|height| *height > 15.0).collect()
    }

    #[test]
    fn bars_of_both_backends_are_as_high_as_their_times() {
        let both = chart_of(&[("native", 25.0), ("wgpu", 100.0)]);
        assert!(both.contains("native: p50") && both.contains("wgpu: p50"));
        let [native, wgpu] = heights(&both)[..] else { panic!("{both}") };
        // Half a pixel at each end of a bar.
        let is_scaled = |low: f64, high: f64| (4.0 * low - high).abs() <= 4.0 + 1.0;
        assert!(is_scaled(native, wgpu), "{native} {wgpu}");
        // A chart with a single drag has an axis of its own.
        let [alone] = heights(&chart_of(&[("native", 25.0)]))[..] else { panic!("one bar") };
        assert!(!is_scaled(alone, wgpu), "{alone} {wgpu}");
    }
}
