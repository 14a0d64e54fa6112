//! Chart of the distances between cursor and feature, and of the times, in SVG.

use drag::Feature;
use plotters::prelude::*;

use super::measured::{DragError, LANDED_PX, MeasuredTrial};
use super::trial::FEATURES;
use crate::BenchError;
use crate::chart::{self, Area, BLUE, ChartResult, FAINT, GREEN, ORANGE, PlotLayout, RED};

/// One color per feature, in the order of the features.
const COLORS: [RGBColor; 4] = [BLUE, ORANGE, RED, GREEN];

/// Range of the axes in pixels, percent and milliseconds; values outside of it are drawn at the edge.
const PX: (f64, f64) = (1e-3, 1e3);
const PERCENT: (f64, f64) = (0.5, 1e2);
const MS: (f64, f64) = (1e-3, 1e3);

/// Draws shares of drags over pixels at the top, over the lost part of the picture below, and over milliseconds at the
/// bottom, those of whole lights on the left, of control points on the right.
pub(super) fn draw(all: &[MeasuredTrial]) -> Result<String, BenchError> {
    chart::svg((1000, 1140), "", |area| {
        let panels = area.split_evenly((3, 2));
        for (deforms, name) in [(false, "the whole light moves"), (true, "chosen control points move")] {
            let of_kind: Vec<&MeasuredTrial> = all.iter().filter(|made| made.kind.deforms == deforms).collect();
            let column = usize::from(deforms);
            let title = format!("how far from the cursor does it end? {name}");
            panel(&panels[column], (&title, "pixels"), PX, &of_kind, |one| Some(one.px), column == 0)?;
            let title = format!("what does a landed one spoil? {name}");
            let lost = |one: &DragError| Some(100.0 * (1.0 - one.picture?.kept?));
            panel(&panels[2 + column], (&title, "% of what was lit"), PERCENT, &of_kind, lost, false)?;
            let title = format!("how long does it take? {name}");
            panel(&panels[4 + column], (&title, "milliseconds"), MS, &of_kind, |one| Some(one.ms), false)?;
        }
        Ok(())
    })
}

/// Draws shares of drags: thick lines for the product, dashed ones for the least change of the light, thin ones for the
/// paper.
fn panel(
    area: &Area,
    (title, unit): (&str, &str),
    (least, most): (f64, f64),
    all: &[&MeasuredTrial],
    of: fn(&DragError) -> Option<f64>,
    key: bool,
) -> ChartResult {
    let mut plot = PlotLayout { caption: 15, margin: 12, below: 36, left: 52 }.plot(
        area,
        title,
        (least..most).log_scale(),
        0.0..100.0,
    )?;
    plot.configure_mesh()
        .x_desc(unit)
        .y_desc("% of drags, at most so much")
        .light_line_style(FAINT)
        .x_label_formatter(&|x| format!("{x}"))
        .y_label_formatter(&|y| format!("{y:.0}"))
        .draw()?;
    if unit == "pixels" {
        plot.draw_series(LineSeries::new([(LANDED_PX, 0.0), (LANDED_PX, 100.0)], BLACK.mix(0.5)))?;
    }
    for (feature, color) in FEATURES.into_iter().zip(COLORS) {
        let values = |side: fn(&MeasuredTrial) -> &DragError| {
            let of_feature = all.iter().filter(|made| made.kind.feature == feature);
            of_feature.filter_map(|made| of(side(made))).collect::<Vec<f64>>()
        };
        let paper = cumulative(values(|made| &made.paper), (least, most));
        plot.draw_series(LineSeries::new(paper, color.mix(0.8)))?;
        let least_change = cumulative(values(|made| &made.least_change), (least, most));
        plot.draw_series(DashedLineSeries::new(least_change, 6, 4, color.stroke_width(1)))?;
        let ours = cumulative(values(|made| &made.ours), (least, most));
        let series = plot.draw_series(LineSeries::new(ours, color.stroke_width(3)))?;
        if key {
            series.label(name(feature)).legend(chart::line(color.stroke_width(3)));
        }
    }
    if key {
        chart::note(&mut plot, "dashed: least change of the light", chart::line(BLACK.mix(0.4)))?;
        chart::note(&mut plot, "thin: the paper's formulas", chart::line(BLACK.mix(0.8)))?;
        chart::key(&mut plot, SeriesLabelPosition::MiddleLeft)?;
    }
    Ok(())
}

fn name(feature: Feature) -> &'static str {
    match feature {
        Feature::Shadow => "shadow",
        Feature::Hotspot => "hotspot",
        Feature::Highlight => "highlight",
        Feature::Diffuse => "most turned to the light",
    }
}

/// Returns the steps of a curve that shows, for each value, the percentage of values up to it. Infinite values count as
/// none of these.
fn cumulative(mut values: Vec<f64>, (least, most): (f64, f64)) -> Vec<(f64, f64)> {
    values.sort_by(f64::total_cmp);
    let count = values.len().max(1) as f64;
    let mut steps = vec![(least, 0.0)];
    for (index, value) in values.into_iter().enumerate().take_while(|(_, value)| *value < most) {
        let x = value.max(least);
        steps.push((x, 100.0 * index as f64 / count));
        steps.push((x, 100.0 * (index + 1) as f64 / count));
    }
    let last = steps[steps.len() - 1].1;
    steps.push((most, last));
    steps
}
