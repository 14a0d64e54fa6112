//! Chart of run time over error, with one dot per pose.

use plotters::prelude::*;

use super::{SHAPES, SweepReport};
use crate::BenchError;
use crate::chart::{self, BLUE, ORANGE, PlotLayout, WRONG};

const COLORS: [RGBColor; 2] = [ORANGE, BLUE];
/// Error as which smaller ones are drawn. A picture that is entirely dark has an error of 0.
const LEAST_ERROR: f64 = 1e-6;

/// Draws one panel per shape: the time of each pose's picture and the error of its radiance. Red rings mark poses with
/// wrong pixels.
pub(super) fn draw(report: &SweepReport) -> Result<String, BenchError> {
    let SweepReport { width, height, .. } = report;
    let title = format!("random lights over random scenes, {width}x{height}: run time against error of radiance");
    chart::svg((900, 640), &title, |area| {
        for (panel, (shape, _)) in area.split_evenly((2, 2)).iter().zip(SHAPES) {
            let mut plot = PlotLayout { caption: 17, margin: 10, below: 34, left: 58 }.plot(
                panel,
                shape,
                (1.0..2e3).log_scale(),
                (LEAST_ERROR..1e-2).log_scale(),
            )?;
            plot.configure_mesh()
                .x_desc("ms of the picture")
                .y_desc("relative RMSE")
                .y_label_formatter(&|error| format!("{error:.0e}"))
                .draw()?;
            let poses: Vec<_> = report.poses.iter().filter(|pose| pose.shape == shape).collect();
            let rows = report.rows.iter().filter(|row| row.shape == shape);
            for ((index, row), color) in rows.enumerate().zip(COLORS) {
                let at = |index: usize, pose: &super::SweepPose| {
                    let drawn = &pose.by[index];
                    (drawn.frame_ms, drawn.radiance_rmse.max(LEAST_ERROR))
                };
                let label =
                    format!("{}: {} pixels wrong of {:.0} thousand", row.backend, row.wrong, row.stable as f64 / 1e3);
                plot.draw_series(poses.iter().map(|pose| Circle::new(at(index, pose), 2, color.filled())))?
                    .label(label)
                    .legend(chart::dot(color.filled()));
                let wrong = poses.iter().filter(|pose| pose.by[index].wrong > 0);
                plot.draw_series(wrong.map(|pose| Circle::new(at(index, pose), 5, WRONG.stroke_width(2))))?;
            }
            chart::key(&mut plot, SeriesLabelPosition::UpperRight)?;
        }
        Ok(())
    })
}
