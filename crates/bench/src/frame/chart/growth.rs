//! Time over what grows, with the error beside each point.

use plotters::prelude::*;

use super::super::{Axis, Grown, Point, Report};
use super::{Area, Drawn, color_of};

/// What one backend's line is drawn of.
type Of = fn(&Point) -> Option<Grown>;

/// A line of the backend that is measured, and one of wgpu where that is another.
pub(super) fn draw(area: &Area, Axis { axis, points }: &Axis, report: &Report) -> Drawn {
    let values = points.iter().map(|point| point.value as f64);
    let (least, most) = values.fold((f64::INFINITY, 0.0_f64), |(a, b), x| (a.min(x), b.max(x)));
    let all = points.iter().flat_map(|point| [Some(point.grown), point.by_wgpu]).flatten();
    let times = all.flat_map(|grown| [grown.frame.wall_ms.min, grown.frame.wall_ms.median]);
    let (fastest, slowest) = times.fold((f64::INFINITY, 0.0_f64), |(a, b), x| (a.min(x), b.max(x)));
    // A decade more than half of what there is leaves room for the labels.
    let x_range = (least / 1.6)..(most * 3.0).max(least * 4.0);
    let y_range = (fastest / 2.0).max(0.1)..slowest * 2.5;
    let mut plot = ChartBuilder::on(area)
        .caption(axis, ("sans-serif", 14))
        .margin(8)
        .x_label_area_size(28)
        .y_label_area_size(42)
        .build_cartesian_2d(x_range.log_scale(), y_range.log_scale())?;
    plot.configure_mesh()
        .light_line_style(BLACK.mix(0.05))
        .x_labels(4)
        .x_label_formatter(&|value| short(*value))
        .y_desc("wall ms, median")
        .y_label_formatter(&|ms| format!("{ms}"))
        .draw()?;
    let lines: [(&'static str, Of); 2] =
        [(report.backend, |point| Some(point.grown)), ("wgpu", |point| point.by_wgpu)];
    // What is measured alone needs no name.
    for (backend, of) in lines.into_iter().take(report.errors.len()) {
        let color = color_of(backend, report);
        let grown: Vec<_> =
            points.iter().filter_map(|point| Some((point.value as f64, of(point)?))).collect();
        let line = grown.iter().map(|(x, grown)| (*x, grown.frame.wall_ms.median));
        plot.draw_series(LineSeries::new(line, color.stroke_width(2)).point_size(3))?
            .label(backend)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 12, y)], color.stroke_width(2)));
        let label = |(x, grown): &(f64, Grown)| {
            let error = format!("{:.0e}", grown.error.radiance_rmse);
            Text::new(
                error,
                (*x, grown.frame.wall_ms.median * 1.35),
                ("sans-serif", 10).into_font().color(&color),
            )
        };
        plot.draw_series(grown.iter().map(label))?;
    }
    if report.errors.len() > 1 {
        plot.configure_series_labels()
            .position(SeriesLabelPosition::LowerRight)
            .background_style(WHITE.mix(0.85))
            .border_style(BLACK.mix(0.3))
            .draw()?;
    }
    Ok(())
}

/// Thousands and millions by their letter.
fn short(value: f64) -> String {
    match value {
        value if value >= 1e6 => format!("{}M", value / 1e6),
        value if value >= 1e3 => format!("{}k", value / 1e3),
        value => format!("{value}"),
    }
}
