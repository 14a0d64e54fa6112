//! The laws over bend and taper as an SVG.

use plotters::prelude::*;

use super::Report;
use super::grid::{AtCell, TAPERS};
use super::law::Law;

/// A panel: its title, the law it is about, and the angle of it that is drawn.
type Panel = (&'static str, Law, fn(&AtCell) -> f64);

const PANELS: [Panel; 4] = [
    ("\"tube\": off the path", Law::Tube, |at| at.off_path_deg),
    ("eq. 9 as printed: off the path", Law::Printed, |at| at.off_path_deg),
    ("\"path\": jump at a joint", Law::Path, |at| at.joint_jump_deg),
    ("\"path\" blended: off the path near a joint", Law::Blended, |at| at.off_path_deg),
];
/// Light to dark with the taper.
const COLORS: [RGBColor; 4] = [
    RGBColor(0x7f, 0xb8, 0xe8),
    RGBColor(0x2f, 0x6d, 0xb5),
    RGBColor(0x7a, 0x5c, 0xa8),
    RGBColor(0xb0, 0x2a, 0x4e),
];
/// Degrees.
const LEAST: f64 = 0.01;

/// Four panels of degrees over `R kappa`, a curve a taper, with the time that each law takes.
pub fn chart(report: &Report) -> Result<String, Box<dyn std::error::Error>> {
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, (1100, 800)).into_drawing_area();
        root.fill(&WHITE)?;
        let title = "Direction of light over bend and taper, largest angle at the tube's edge";
        let root = root.titled(title, ("sans-serif", 20))?;
        for (area, panel) in root.split_evenly((2, 2)).iter().zip(PANELS) {
            draw_panel(area, panel, report)?;
        }
        root.present()?;
    }
    Ok(svg)
}

fn draw_panel(
    area: &DrawingArea<SVGBackend<'_>, plotters::coord::Shift>,
    (title, law, angle): Panel,
    report: &Report,
) -> Result<(), Box<dyn std::error::Error>> {
    let time = report.nanoseconds.iter().find(|time| time.law == law).map_or(0.0, |time| time.nanoseconds);
    let mut plot = ChartBuilder::on(area)
        .caption(format!("{title} ({time:.0} ns)"), ("sans-serif", 16))
        .margin(12)
        .x_label_area_size(36)
        .y_label_area_size(60)
        .build_cartesian_2d(0.0..1.0, (LEAST..180.0).log_scale())?;
    plot.configure_mesh()
        .x_desc("R kappa")
        .y_desc("degrees")
        .y_label_formatter(&|degrees| format!("{degrees}"))
        .draw()?;
    // Without taper all but nothing differs, and a logarithm has no zero.
    for (&taper, color) in TAPERS[1..].iter().zip(COLORS) {
        let curve = report.grid.iter().filter(|cell| cell.taper == taper).flat_map(|cell| {
            let at = cell.laws.iter().filter(|at| at.law == law);
            at.map(|at| (cell.r_kappa, angle(at).max(LEAST)))
        });
        plot.draw_series(LineSeries::new(curve, color.stroke_width(2)))?
            .label(format!("|R'| / |P'| = {taper}"))
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 16, y)], color.stroke_width(2)));
    }
    plot.configure_series_labels()
        .position(SeriesLabelPosition::LowerRight)
        .background_style(WHITE.mix(0.85))
        .border_style(BLACK.mix(0.3))
        .draw()?;
    Ok(())
}
