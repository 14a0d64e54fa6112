//! Charts of time over a growing quantity, with the error at each point.

use plotters::prelude::*;

use super::super::{FrameBenchReport, GrowthAxis, GrowthCosts, GrowthPoint};
use super::color_of;
use crate::chart::{self, Area, ChartResult, FAINT, PlotLayout, range};

/// Selects the costs of one backend.
type CostOf = fn(&GrowthPoint) -> Option<GrowthCosts>;

/// Draws a line for the measured backend, and one for wgpu if that is another.
pub(super) fn draw(area: &Area, GrowthAxis { axis, points }: &GrowthAxis, report: &FrameBenchReport) -> ChartResult {
    let (least, most) = range(points.iter().map(|point| point.value as f64));
    let all = points.iter().flat_map(|point| [Some(point.grown), point.by_wgpu]).flatten();
    let (fastest, slowest) = range(all.flat_map(|grown| [grown.frame.wall_ms.min, grown.frame.wall_ms.p50]));
    // The margin leaves room for the labels.
    let x_range = (least / 1.6)..(most * 3.0).max(least * 4.0);
    let y_range = (fastest / 2.0).max(0.1)..slowest * 2.5;
    let mut plot = PlotLayout { caption: 14, margin: 8, below: 28, left: 42 }.plot(
        area,
        axis,
        x_range.log_scale(),
        y_range.log_scale(),
    )?;
    plot.configure_mesh()
        .light_line_style(FAINT)
        .x_labels(4)
        .x_label_formatter(&|value| short(*value))
        .y_desc("wall ms, median")
        .y_label_formatter(&|ms| format!("{ms}"))
        .draw()?;
    let lines: [(&'static str, CostOf); 2] =
        [(report.backend, |point| Some(point.grown)), ("wgpu", |point| point.by_wgpu)];
    // A single backend needs no name.
    for (backend, of) in lines.into_iter().take(report.errors.len()) {
        let color = color_of(backend, report);
        let grown: Vec<_> = points.iter().filter_map(|point| Some((point.value as f64, of(point)?))).collect();
        let line = grown.iter().map(|(x, grown)| (*x, grown.frame.wall_ms.p50));
        plot.draw_series(LineSeries::new(line, color.stroke_width(2)).point_size(3))?
            .label(backend)
            .legend(chart::line(color.stroke_width(2)));
        let label = |(x, grown): &(f64, GrowthCosts)| {
            let error = format!("{:.0e}", grown.error.radiance_rmse);
            Text::new(error, (*x, grown.frame.wall_ms.p50 * 1.35), ("sans-serif", 10).into_font().color(&color))
        };
        plot.draw_series(grown.iter().map(label))?;
    }
    if report.errors.len() > 1 {
        chart::key(&mut plot, SeriesLabelPosition::LowerRight)?;
    }
    Ok(())
}

/// Formats thousands with a k and millions with an M.
fn short(value: f64) -> String {
    match value {
        value if value >= 1e6 => format!("{}M", value / 1e6),
        value if value >= 1e3 => format!("{}k", value / 1e3),
        value => format!("{value}"),
    }
}
