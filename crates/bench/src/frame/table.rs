//! Formats a report as tables for a terminal.

use std::fmt::Write;

use super::{BackendError, Costs, EditReport, FrameBenchReport, FrameEdit, GrowthPoint, PictureError, StageCosts};

impl FrameBenchReport {
    /// Formats the report as tables for a terminal: the costs of edits by stages, the renderers side by side, and the
    /// growth of frame times.
    pub fn table(&self) -> String {
        let mut text = String::new();
        let parts = [edits, contestants, growth];
        parts.into_iter().try_for_each(|part| part(&mut text, self)).expect("writing to a string does not fail");
        text
    }
}

fn edits(text: &mut String, report: &FrameBenchReport) -> std::fmt::Result {
    let FrameBenchReport { scene, triangles, width, height, adapter, backend, .. } = report;
    writeln!(text, "{scene}, {triangles} triangles, {width}x{height}; {adapter}, {backend}")?;
    writeln!(
        text,
        "wall ms of the whole frame (minimum, median), its CPU ms (median), and wall ms of its stages (median):"
    )?;
    for (edits, BackendError { backend, error }) in report.edits.chunks(FrameEdit::ALL.len()).zip(&report.errors) {
        group(text, backend, edits)?;
        let PictureError { width, height, compared, radiance_rmse } = error;
        writeln!(
            text,
            "{backend}'s error against the reference, {width}x{height}: {radiance_rmse:.1e} over {compared} pixels"
        )?;
    }
    Ok(())
}

/// Writes the edits of one backend.
fn group(text: &mut String, backend: &str, edits: &[EditReport]) -> std::fmt::Result {
    write!(text, "{backend:14}{:>8}{:>8}{:>8}", "min", "median", "cpu")?;
    for StageCosts { stage, .. } in edits.first().map_or(&[][..], |edit| &edit.stages) {
        write!(text, "{stage:>10}")?;
    }
    writeln!(text, "{:>8}", "encode")?;
    for edit in edits {
        let Costs { wall_ms, cpu_ms } = edit.frame;
        write!(text, "{:14}{:8.1}{:8.1}{:8.1}", edit.edit.name(), wall_ms.min, wall_ms.p50, cpu_ms.p50)?;
        for stage in &edit.stages {
            let ms = if stage.runs == 0 { "-".into() } else { format!("{:.1}", stage.costs.wall_ms.p50) };
            write!(text, "{ms:>10}")?;
        }
        writeln!(text, "{:8.1}", edit.encode.wall_ms.p50)?;
    }
    Ok(())
}

fn contestants(text: &mut String, report: &FrameBenchReport) -> std::fmt::Result {
    writeln!(text, "side by side, wall ms:")?;
    writeln!(text, "{:24}{:>8}{:>8}{:>8}{:>24}", "", "min", "median", "cpu", "of bent: min, median")?;
    for one in &report.side_by_side {
        let cpu = one.cpu_ms.map_or("-".into(), |cpu_ms| format!("{:.1}", cpu_ms.p50));
        let (wall_ms, to_bent) = (one.wall_ms, one.to_bent);
        write!(text, "{:24}{:8.1}{:8.1}{cpu:>8}", one.what, wall_ms.min, wall_ms.p50)?;
        writeln!(text, "{:16.2}{:8.2}", to_bent.min, to_bent.p50)?;
    }
    Ok(())
}

fn growth(text: &mut String, report: &FrameBenchReport) -> std::fmt::Result {
    for axis in &report.growth {
        let beside = if report.errors.len() > 1 { "; the same by wgpu" } else { "" };
        writeln!(text, "{}: wall ms (minimum, median), error against the reference{beside}", axis.axis)?;
        for GrowthPoint { value, grown, by_wgpu, .. } in &axis.points {
            write!(text, "{value:>14}")?;
            for grown in [Some(grown), by_wgpu.as_ref()].into_iter().flatten() {
                let (wall_ms, error) = (grown.frame.wall_ms, grown.error.radiance_rmse);
                write!(text, "{:10.1}{:10.1}{error:12.1e}", wall_ms.min, wall_ms.p50)?;
            }
            writeln!(text)?;
        }
    }
    Ok(())
}
