//! Chart of run time over error, in SVG.

use plotters::prelude::*;

use super::family::FAMILIES;
use super::report::{MeasuredMethod, SolverBenchReport};
use super::width::Precision;
use crate::BenchError;
use crate::chart::{self, BLUE, ChartResult, ORANGE, PlotLayout, range};

const WIDTHS: [(Precision, RGBColor, &str); 2] = [(Precision::F32, BLUE, "f32"), (Precision::F64, ORANGE, "f64")];
/// Height of a label and width of a letter, in pixels.
const LINE: i32 = 15;
const LETTER: i32 = 7;

type Plot<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<LogCoord<f64>, LogCoord<f64>>>;

/// Draws a marker for each method and precision, filled if the method gave no wrong answer. Also draws the Pareto front
/// of each precision.
pub(super) fn draw(report: &SolverBenchReport) -> Result<String, BenchError> {
    let methods = &report.methods;
    chart::svg((1000, 640), "", |area| {
        let (fastest, slowest) = range(methods.iter().map(|m| m.nanoseconds));
        let (least, most) = range(methods.iter().map(MeasuredMethod::error));
        let cases = report.inputs_per_family * FAMILIES.len() as u64;
        let caption = format!("Where is the curve square to a point? {cases} points, {} kinds", FAMILIES.len());
        let mut plot = PlotLayout { caption: 20, margin: 14, below: 44, left: 84 }.plot(
            area,
            &caption,
            (fastest * 0.85..slowest * 1.9).log_scale(),
            (least / 8.0..most * 8.0).log_scale(),
        )?;
        plot.configure_mesh()
            .x_desc("run time: nanoseconds a solve on one core, mean over the kinds")
            .y_desc("error in u, divided by the condition: p99.9")
            .x_label_formatter(&|ns| format!("{ns:.0}"))
            .y_label_formatter(&|error| format!("{error:.0e}"))
            .draw()?;
        for (precision, color, name) in WIDTHS {
            let of_width: Vec<_> = methods.iter().filter(|m| m.precision == precision).collect();
            let line = plot.draw_series(LineSeries::new(front(&of_width, slowest * 1.9), color.mix(0.5)))?;
            line.label(format!("{name}, and what is fastest for its error")).legend(chart::dot(color.filled()));
        }
        let hollow = WIDTHS[0].1.stroke_width(2);
        let failing = "hollow: some roots missed, made up, over the bars or no number";
        chart::note(&mut plot, failing, chart::dot(hollow))?;
        draw_markers(&mut plot, methods)?;
        draw_labels(&mut plot, methods)?;
        chart::key(&mut plot, SeriesLabelPosition::MiddleLeft)
    })
}

/// Returns the steps of the fastest method for each error, up to the time `end`.
fn front(methods: &[&MeasuredMethod], end: f64) -> Vec<(f64, f64)> {
    let mut best: Vec<_> = methods.iter().filter(|m| m.on_pareto_front).map(|m| (m.nanoseconds, m.error())).collect();
    best.sort_by(|x, y| x.0.total_cmp(&y.0));
    let until = best.iter().skip(1).map(|next| next.0).chain([end]);
    best.iter().zip(until).flat_map(|(&(from, error), until)| [(from, error), (until, error)]).collect()
}

fn draw_markers(plot: &mut Plot<'_, '_>, methods: &[MeasuredMethod]) -> ChartResult {
    for method in methods {
        let color = color(method);
        let style = if failures(method).is_empty() { color.filled() } else { color.stroke_width(2) };
        plot.draw_series([Circle::new((method.nanoseconds, method.error()), 5, style)])?;
    }
    Ok(())
}

/// Draws the name of each marker beside it, moved down if it would overlap another, with a line to its marker.
fn draw_labels(plot: &mut Plot<'_, '_>, methods: &[MeasuredMethod]) -> ChartResult {
    let mut markers: Vec<_> = methods.iter().map(|m| (plot.backend_coord(&(m.nanoseconds, m.error())), m)).collect();
    markers.sort_by_key(|((_, y), _)| *y);
    let area = plot.plotting_area().strip_coord_spec();
    let (left, top) = area.get_base_pixel();
    let positions: Vec<_> = markers.iter().map(|((x, y), _)| (x - left, y - top)).collect();
    // Left, right and top of each label.
    let mut taken: Vec<(i32, i32, i32)> = Vec::new();
    for ((x, y), method) in markers {
        let (marker, mut label) = ((x - left, y - top), (x - left + 14, y - top - 7));
        let name = name(method);
        let end = |label: (i32, i32)| label.0 + name.chars().map(|_| LETTER).sum::<i32>();
        let hides = |label: (i32, i32)| {
            let on = |at: &(i32, i32)| (label.0 - 6..end(label) + 6).contains(&at.0);
            let beside =
                |other: &(i32, i32, i32)| (other.2 - label.1).abs() < LINE && other.0 < end(label) && label.0 < other.1;
            positions.iter().any(|at| on(at) && (at.1 - label.1 - 7).abs() < 12) || taken.iter().any(beside)
        };
        while hides(label) {
            label.1 += 1;
        }
        taken.push((label.0, end(label), label.1));
        let style = ("sans-serif", 13).into_font().color(&color(method));
        area.draw(&Text::new(name.as_str(), label, style))?;
        let line = vec![marker, (label.0 - 2, label.1 + 7)];
        area.draw(&PathElement::new(line, color(method).mix(0.4)))?;
    }
    Ok(())
}

fn color(method: &MeasuredMethod) -> RGBColor {
    if method.precision == Precision::F32 { WIDTHS[0].1 } else { WIDTHS[1].1 }
}

fn name(method: &MeasuredMethod) -> String {
    let failures = failures(method);
    let separator = if failures.is_empty() { "" } else { ": " };
    format!("{:?}{separator}{failures}", method.method)
}

/// Formats the number of wrong answers of a method. The text is empty if there are none.
fn failures(method: &MeasuredMethod) -> String {
    let accuracy = &method.accuracy;
    let wrong = accuracy.missed + accuracy.spurious + accuracy.inaccurate;
    let counts = [(wrong, "wrong"), (accuracy.nan, "NaN")];
    let words = counts.iter().filter(|(count, _)| *count > 0).map(|(count, what)| {
        let percent = 100.0 * *count as f64 / accuracy.inputs as f64;
        if percent < 0.01 { format!("{count} {what}") } else { format!("{percent:.2} % {what}") }
    });
    words.collect::<Vec<_>>().join(", ")
}
