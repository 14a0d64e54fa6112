//! Chart of edit rates and opening times, in SVG.

use plotters::prelude::*;

use super::{IN_FLIGHT, LogBenchReport, OpeningTime};
use crate::BenchError;
use crate::chart::{self, Area, BLUE, ChartResult, FAINT, ORANGE, PlotLayout, range};

type Time = fn(&OpeningTime) -> f64;

/// Draws bars of rates on the left, and opening time over the length of the log on the right.
pub(super) fn draw(report: &LogBenchReport) -> Result<String, BenchError> {
    chart::svg((1000, 420), "", |area| {
        let panels = area.split_evenly((1, 2));
        rates(&panels[0], report)?;
        opening(&panels[1], &report.opening)
    })
}

fn rates(area: &Area, report: &LogBenchReport) -> ChartResult {
    let in_flight = format!("acknowledged, {IN_FLIGHT} under way");
    let bars = [
        ("acknowledged, one at a time", report.acknowledged_one_at_a_time),
        (in_flight.as_str(), report.acknowledged),
        ("undone", report.undone),
        ("replayed", report.replayed),
    ];
    let most = bars.iter().map(|(_, rate)| rate.per_second).fold(1.0, f64::max);
    let mut plot = PlotLayout { caption: 18, margin: 12, below: 36, left: 0 }.plot(
        area,
        "edits a second",
        (1.0..10.0 * most).log_scale(),
        0.0..bars.len() as f64,
    )?;
    plot.configure_mesh()
        .x_desc("a second")
        .light_line_style(FAINT)
        .disable_y_mesh()
        .disable_y_axis()
        .x_label_formatter(&|x| format!("{x:.0}"))
        .draw()?;
    for (index, (name, rate)) in bars.iter().enumerate() {
        let top = (bars.len() - index) as f64 - 0.45;
        let bar = [(1.0, top), (rate.per_second.max(1.0), top - 0.4)];
        plot.draw_series([Rectangle::new(bar, BLUE.filled())])?;
        let label = format!("{name}: {:.0}", rate.per_second);
        plot.draw_series([Text::new(label, (1.1, top + 0.3), ("sans-serif", 15))])?;
    }
    Ok(())
}

fn opening(area: &Area, opening: &[OpeningTime]) -> ChartResult {
    let times = opening.iter().flat_map(|o| [o.without_checkpoint_ms, o.reopened_ms]);
    let (least, most) = range(times);
    let longest = opening.iter().map(|o| o.records).max().unwrap_or(1) as f64;
    let mut plot = PlotLayout { caption: 18, margin: 12, below: 36, left: 56 }.plot(
        area,
        "opening a session",
        (1.0..1.5 * longest).log_scale(),
        (0.5 * least..2.0 * most.max(1.0)).log_scale(),
    )?;
    plot.configure_mesh()
        .x_desc("records in its log")
        .y_desc("ms")
        .light_line_style(FAINT)
        .x_label_formatter(&|x| format!("{x:.0}"))
        .draw()?;
    let lines: [(&str, RGBColor, Time); 2] = [
        ("without a checkpoint", ORANGE, |o| o.without_checkpoint_ms),
        ("as the server left it: checkpoints past 1000 records", BLUE, |o| o.reopened_ms),
    ];
    for (name, color, time) in lines {
        let line = opening.iter().map(|o| (o.records as f64, time(o)));
        plot.draw_series(LineSeries::new(line, color.stroke_width(2)).point_size(3))?
            .label(name)
            .legend(chart::line(color.stroke_width(2)));
    }
    chart::key(&mut plot, SeriesLabelPosition::UpperLeft)
}
