//! Chart of the victim's frames beside each kind of other client, in SVG.

use plotters::prelude::*;

use super::judge::MAX_GAP_RATIO;
use super::{IsolationReport, RowReport};
use crate::BenchError;
use crate::chart::{self, Area, BLUE, ChartResult, FAINT, PlotLayout, WRONG};

/// Width of the picture in pixels, and heights of a row and of everything else.
const WIDTH: u32 = 1100;
const ROW: u32 = 26;
const REST: u32 = 110;
/// Longest gap on the axis, over the 95th percentile without the other client.
const TOP_GAP: f64 = 4000.0;

/// Draws one row each, with the victim's share of frames on the left and its longest gap on the right. Lines are the
/// bounds.
pub(super) fn draw(report: &IsolationReport) -> Result<String, BenchError> {
    let IsolationReport { width, height, rows, .. } = report;
    let title = format!("a drag at {width}x{height} beside one other client, over the same drag alone");
    chart::svg((WIDTH, REST + ROW * rows.len() as u32), &title, |area| {
        let (left, right) = area.split_horizontally(WIDTH * 6 / 10);
        shares(&left, report)?;
        gaps(&right, report)
    })
}

/// Returns the rows with their positions on the axis, the first at the top.
fn rows_of(report: &IsolationReport) -> impl Iterator<Item = (f64, &RowReport)> {
    let count = report.rows.len() as f64;
    report.rows.iter().enumerate().map(move |(index, row)| (count - index as f64, row))
}

fn color(passes: bool) -> ShapeStyle {
    if passes { BLUE.filled() } else { WRONG.filled() }
}

fn shares(area: &Area, report: &IsolationReport) -> ChartResult {
    let top = report.rows.len().max(1) as f64;
    let mut plot = PlotLayout { caption: 15, margin: 8, below: 24, left: 150 }.plot(
        area,
        "share of its frames; red misses a bound, a line is the share's",
        0.0..1.2,
        0.0..top,
    )?;
    plot.configure_mesh().disable_y_mesh().disable_y_axis().light_line_style(FAINT).draw()?;
    for (y, row) in rows_of(report) {
        let bar = [(0.0, y - 0.15), (row.share.clamp(0.0, 1.2), y - 0.85)];
        plot.draw_series([Rectangle::new(bar, color(row.passes))])?;
        plot.draw_series([PathElement::new(
            [(row.least_share, y - 0.05), (row.least_share, y - 0.95)],
            BLACK.stroke_width(2),
        )])?;
        let text = format!("{:.0} %", 100.0 * row.share);
        let x = row.share.clamp(0.0, 1.1) + 0.01;
        plot.draw_series([Text::new(text, (x, y - 0.25), ("sans-serif", 13))])?;
    }
    for (y, row) in rows_of(report) {
        let (_, at) = plot.backend_coord(&(0.0, y - 0.25));
        let (_, base) = area.get_base_pixel();
        area.draw(&Text::new(row.row.name, (8, at - base), ("sans-serif", 13)))?;
    }
    Ok(())
}

fn gaps(area: &Area, report: &IsolationReport) -> ChartResult {
    let top = report.rows.len().max(1) as f64;
    let mut plot = PlotLayout { caption: 15, margin: 8, below: 24, left: 0 }.plot(
        area,
        "longest gap over the usual p95; the line is the bound",
        (0.5..TOP_GAP).log_scale(),
        0.0..top,
    )?;
    plot.configure_mesh().disable_y_mesh().disable_y_axis().light_line_style(FAINT).draw()?;
    for (y, row) in rows_of(report) {
        let gap = if row.longest_gap_of_usual.is_finite() { row.longest_gap_of_usual } else { TOP_GAP };
        let bar = [(0.5, y - 0.15), (gap.clamp(0.5, TOP_GAP), y - 0.85)];
        plot.draw_series([Rectangle::new(bar, color(gap <= MAX_GAP_RATIO))])?;
        let text = format!("{gap:.1}");
        plot.draw_series([Text::new(text, (gap.clamp(0.5, TOP_GAP / 4.0) * 1.1, y - 0.25), ("sans-serif", 13))])?;
    }
    plot.draw_series([PathElement::new([(MAX_GAP_RATIO, 0.0), (MAX_GAP_RATIO, top)], BLACK.stroke_width(2))])?;
    Ok(())
}
