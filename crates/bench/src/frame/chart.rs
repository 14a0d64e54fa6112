//! Chart of edits by stages, renderers side by side, and growth, in SVG.

mod growth;

use plotters::prelude::*;
use render::FrameStage;

use super::{BackendError, ComparedRenderer, EditReport, FrameBenchReport, FrameEdit};
use crate::BenchError;
use crate::chart::{self, Area, ChartResult, FAINT, PlotLayout};

/// One color per stage, in the order of the stages: the G-buffer and passes over it grey, shadow maps blue and violet,
/// lighting warm, the rest green.
const COLORS: [RGBColor; FrameStage::ALL.len()] = [
    RGBColor(0x9a, 0x9a, 0x9a),
    RGBColor(0x62, 0x62, 0x62),
    RGBColor(0xa9, 0xc9, 0xec),
    RGBColor(0x6f, 0xa3, 0xdc),
    RGBColor(0x3f, 0x7f, 0xc4),
    RGBColor(0x22, 0x5c, 0x9c),
    RGBColor(0x12, 0x35, 0x62),
    RGBColor(0x7a, 0x5c, 0xa8),
    RGBColor(0xf2, 0xc0, 0x6b),
    RGBColor(0xe0, 0x6a, 0x1e),
    RGBColor(0xa8, 0x3c, 0x14),
    RGBColor(0x8c, 0xc6, 0x9a),
    RGBColor(0x3a, 0x9a, 0x5c),
];

/// Width of the picture, and heights of its three parts.
const WIDTH: u32 = 1100;
const HEIGHTS: [u32; 3] = [440, 60, 300];
/// Height of a renderer's bar with its margin.
const BAR: u32 = 26;

pub(super) fn draw(report: &FrameBenchReport) -> Result<String, BenchError> {
    let contest = HEIGHTS[1] + BAR * report.side_by_side.len() as u32;
    let growth = if report.growth.is_empty() { 0 } else { HEIGHTS[2] };
    let size = (WIDTH, 30 + HEIGHTS[0] + contest + growth);
    // The adapter's name includes the version of its driver.
    let FrameBenchReport { scene, width, height, adapter, backend, .. } = report;
    let title = format!("{scene}, {width} x {height} pixels, {adapter}, {backend}");
    chart::svg(size, &title, |area| {
        let (edits, rest) = area.split_vertically(HEIGHTS[0]);
        let (side_by_side, rest) = rest.split_vertically(contest);
        by_stages(&edits, report)?;
        contestants(&side_by_side, report)?;
        if !report.growth.is_empty() {
            for (area, axis) in rest.split_evenly((1, report.growth.len())).iter().zip(&report.growth) {
                growth::draw(area, axis, report)?;
            }
        }
        Ok(())
    })
}

/// Draws one bar per edit and backend with its stages stacked, and a line across it at the time of the whole frame.
fn by_stages(area: &Area, report: &FrameBenchReport) -> ChartResult {
    let edits = &report.edits;
    let all = |edit: &EditReport| edit.stages.iter().map(|stage| stage.costs.wall_ms.p50).sum::<f64>();
    let top = edits.iter().map(|edit| all(edit).max(edit.frame.wall_ms.p50)).fold(1.0, f64::max);
    let mut plot = PlotLayout { caption: 15, margin: 12, below: 30, left: 56 }.plot(
        area,
        &caption(report),
        (0..FrameEdit::ALL.len() - 1).into_segmented(),
        0.0..1.08 * top,
    )?;
    plot.configure_mesh()
        .disable_x_mesh()
        .light_line_style(FAINT)
        .y_desc("wall ms, median")
        .x_label_style(("sans-serif", 13))
        .x_label_formatter(&|at| match at {
            SegmentValue::CenterOf(index) => FrameEdit::ALL[*index].name().into(),
            _ => String::new(),
        })
        .draw()?;
    // The bars of an edit are side by side, those of one backend at the same position.
    let groups = report.errors.len();
    let room = plot.plotting_area().dim_in_pixel().0 / FrameEdit::ALL.len() as u32;
    let place = |at: usize| (SegmentValue::Exact(at % FrameEdit::ALL.len()), (at / FrameEdit::ALL.len()) as u32);
    let width = (room - 24) / groups as u32;
    for (index, (stage, color)) in FrameStage::ALL.into_iter().zip(COLORS).enumerate() {
        let bar = |(at, edit): (usize, &EditReport)| {
            let bottom: f64 = edit.stages[..index].iter().map(|stage| stage.costs.wall_ms.p50).sum();
            let (left, group) = place(at);
            let right = SegmentValue::Exact(at % FrameEdit::ALL.len() + 1);
            let top = bottom + edit.stages[index].costs.wall_ms.p50;
            let mut bar = Rectangle::new([(left, bottom), (right, top)], color.filled());
            let from = 12 + group * width;
            bar.set_margin(0, 0, from + 3, room.saturating_sub(from + width) + 3);
            bar
        };
        plot.draw_series(edits.iter().enumerate().map(bar))?.label(stage.name()).legend(chart::swatch(color));
    }
    let whole = |(at, edit): (usize, &EditReport)| {
        let (left, group) = place(at);
        let (from, ms) = ((12 + group * width).cast_signed(), edit.frame.wall_ms.p50);
        let ends = [(from, 0), (from + width.cast_signed(), 0)];
        EmptyElement::at((left, ms)) + PathElement::new(ends, BLACK.stroke_width(2))
    };
    plot.draw_series(edits.iter().enumerate().map(whole))?;
    chart::key(&mut plot, SeriesLabelPosition::UpperRight)
}

/// Explains the bars of edits, with the error of each backend.
fn caption(report: &FrameBenchReport) -> String {
    let error = |one: &BackendError| format!("{} (error {:.1e})", one.backend, one.error.radiance_rmse);
    let errors: Vec<_> = report.errors.iter().map(error).collect();
    let whose = errors.join(", right ");
    let left = if errors.len() > 1 { "left " } else { "" };
    format!("a frame after each edit: its stages, each waited for; the line is the whole frame; {left}{whose}")
}

/// Returns the color of the measured backend, or of wgpu beside it.
fn color_of(backend: &str, report: &FrameBenchReport) -> RGBColor {
    if backend == report.backend { COLORS[3] } else { COLORS[9] }
}

/// Draws one bar per renderer up to its median, with a line at its minimum.
fn contestants(area: &Area, report: &FrameBenchReport) -> ChartResult {
    const LABELS: i32 = 190;
    let all: &[ComparedRenderer] = &report.side_by_side;
    let width = WIDTH.cast_signed();
    area.draw(&Text::new(
        "whole frames side by side, in turns: wall ms, the bar to the median, the line at the minimum",
        (14, 12),
        ("sans-serif", 15),
    ))?;
    let slowest = all.iter().map(|one| one.wall_ms.p50).fold(1.0, f64::max);
    let scale = f64::from(width - LABELS - 190) / slowest;
    for (one, row) in all.iter().zip(0..) {
        let top = 40 + row * BAR.cast_signed();
        let (median, min) = (one.wall_ms.p50, one.wall_ms.min);
        let x = |ms: f64| LABELS + (ms * scale) as i32;
        let color = one.backend.map_or(COLORS[0], |backend| color_of(backend, report));
        area.draw(&Text::new(one.what.clone(), (14, top + 4), ("sans-serif", 13)))?;
        area.draw(&Rectangle::new([(LABELS, top), (x(median), top + 18)], color.filled()))?;
        area.draw(&PathElement::new([(x(min), top), (x(min), top + 18)], BLACK.stroke_width(2)))?;
        let text = format!("{median:.1}, min {min:.1}; {:.2} of bent", one.to_bent.p50);
        area.draw(&Text::new(text, (x(median).min(width - 190) + 6, top + 4), ("sans-serif", 12)))?;
    }
    Ok(())
}
