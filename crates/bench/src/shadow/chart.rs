//! Chart of run time over error, with one row per setting.

use plotters::prelude::*;
use render::ShadowSettings;

use super::{SceneReport, ShadowBenchReport, ShadowRun};
use crate::BenchError;
use crate::chart::{self, Area, BLUE, ChartResult, FAINT, GREEN, ORANGE, PlotLayout, RED, VIOLET, range};

/// One color per scene, in the order of the scenes.
const COLORS: [RGBColor; 5] = [BLUE, RED, GREEN, ORANGE, VIOLET];

/// Setting that the runs vary: its title, a test that a run has the defaults of all other settings, and a label for its
/// value.
struct Knob {
    title: &'static str,
    of: fn(&ShadowSettings, &ShadowSettings) -> bool,
    label: fn(&ShadowRun) -> String,
}

const KNOBS: [Knob; 4] = [
    Knob {
        title: "resolution in texels",
        of: |s, d| *s == ShadowSettings { resolution: s.resolution, ..*d },
        label: |run| run.resolution.to_string(),
    },
    Knob {
        title: "error of a bent edge in texels",
        of: |s, d| *s == ShadowSettings { edge_error_texels: s.edge_error_texels, ..*d },
        label: |run| run.edge_error_texels.map_or("unsplit".into(), |texels| texels.to_string()),
    },
    Knob {
        title: "filter",
        of: |s, d| *s == ShadowSettings { filter: s.filter, ..*d },
        label: |run| run.filter.into(),
    },
    Knob {
        title: "mesh error in world units",
        of: |s, d| *s == ShadowSettings { mesh_error: s.mesh_error, ..*d },
        label: ShadowRun::mesh,
    },
];

/// An error: its title with its unit, and its value for a run.
struct Measure {
    title: &'static str,
    of: fn(&ShadowRun) -> f64,
}

const MEASURES: [Measure; 2] = [
    Measure { title: "edge displaced, p99 in pixels (6: lost)", of: |run| run.error.displacement_pixels.p99 },
    Measure { title: "radiance off edges, relative RMSE", of: |run| run.error.radiance_rmse },
];

/// Draws the SVG.
pub(super) fn draw(report: &ShadowBenchReport) -> Result<String, BenchError> {
    let ShadowBenchReport { width, height, adapter, .. } = report;
    let title = format!("bent shadows: run time against error, {width} x {height} pixels on {adapter}");
    chart::svg((1100, 1644), &title, |area| {
        let panels = area.split_evenly((KNOBS.len(), MEASURES.len()));
        // One scale per column, so that its panels can be compared.
        let ranges = MEASURES.map(|measure| {
            let errors = KNOBS.iter().flat_map(|knob| {
                report.scenes.iter().flat_map(|scene| points(scene, knob, &measure)).map(|point| point.1)
            });
            decades(range(errors))
        });
        let runs = report.scenes.iter().flat_map(|scene| &scene.runs);
        let slowest_ms = runs.map(milliseconds).fold(0.0, f64::max);
        for (index, area) in panels.iter().enumerate() {
            let (row, column) = (index / MEASURES.len(), index % MEASURES.len());
            panel(area, report, &KNOBS[row], &MEASURES[column], 1.15 * slowest_ms, ranges[column], index == 0)?;
        }
        Ok(())
    })
}

fn panel(
    area: &Area,
    report: &ShadowBenchReport,
    knob: &Knob,
    measure: &Measure,
    end_ms: f64,
    errors: (f64, f64),
    key: bool,
) -> ChartResult {
    let points: Vec<Vec<_>> = report.scenes.iter().map(|scene| points(scene, knob, measure)).collect();
    let mut plot = PlotLayout { caption: 15, margin: 10, below: 36, left: 76 }.plot(
        area,
        knob.title,
        0.0..end_ms,
        (errors.0..errors.1).log_scale(),
    )?;
    plot.configure_mesh()
        .x_desc("shadow map and lighting, ms")
        .y_desc(measure.title)
        .light_line_style(FAINT)
        .x_labels(12)
        .x_label_formatter(&|ms| format!("{ms:.0}"))
        .y_label_formatter(&|error| format!("{error}"))
        .draw()?;
    let mut labels: Vec<(i32, i32)> = Vec::new();
    for ((scene, points), color) in report.scenes.iter().zip(&points).zip(COLORS) {
        let line = points.iter().map(|point| (point.0, point.1));
        let series = plot.draw_series(LineSeries::new(line, color.mix(0.6)).point_size(3))?;
        if key {
            series.label(&scene.scene).legend(chart::swatch(color));
        }
        for (ms, error, text) in points {
            let (x, y) = plot.backend_coord(&(*ms, *error));
            // If runs lie close together, only the first has a label.
            if labels.iter().all(|(other_x, other_y)| (x - other_x).abs() > 30 || (y - other_y).abs() > 10) {
                let style = ("sans-serif", 11).into_font().color(&color);
                plot.draw_series([Text::new(text.clone(), (*ms, *error), style)])?;
                labels.push((x, y));
            }
        }
    }
    if key {
        chart::key(&mut plot, SeriesLabelPosition::UpperRight)?;
    }
    Ok(())
}

/// Returns the milliseconds, error and label of the runs that change only this setting, in the order of its values.
fn points(scene: &SceneReport, knob: &Knob, measure: &Measure) -> Vec<(f64, f64, String)> {
    let default = ShadowSettings::default();
    let mut turned: Vec<_> = scene.runs.iter().filter(|run| (knob.of)(&run.settings, &default)).collect();
    let edge_error = |run: &ShadowRun| run.settings.edge_error_texels.unwrap_or(f32::INFINITY);
    // All but one of these settings are equal in all runs.
    turned.sort_by(|a, b| {
        let by_edge = edge_error(b).total_cmp(&edge_error(a));
        by_edge
            .then(a.resolution.cmp(&b.resolution))
            .then((a.settings.filter as u8).cmp(&(b.settings.filter as u8)))
            .then(b.mesh_error.total_cmp(&a.mesh_error))
    });
    // An edge that was not found at all is drawn at the end of the window.
    let point = |run| (milliseconds(run), (measure.of)(run).clamp(1e-6, 6.0), (knob.label)(run));
    turned.into_iter().map(point).collect()
}

/// Returns the milliseconds of the stages that the settings affect.
fn milliseconds(run: &ShadowRun) -> f64 {
    run.stages.shadow_ms + run.stages.lighting_ms
}

/// Extends a range to whole decades, so that a logarithmic axis has numbers.
fn decades((low, high): (f64, f64)) -> (f64, f64) {
    (10_f64.powf(low.log10().floor()), 10_f64.powf((1.2 * high).log10().ceil()))
}
