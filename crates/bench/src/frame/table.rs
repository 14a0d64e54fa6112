//! A report as tables for a terminal.

use std::fmt::Write;

use super::{Report, StageCosts};

/// Edits by stages, contestants, growth.
pub(super) fn of(report: &Report) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = edits(&mut text, report)
        .and_then(|()| contestants(&mut text, report))
        .and_then(|()| growth(&mut text, report));
    text
}

fn edits(text: &mut String, report: &Report) -> std::fmt::Result {
    let Report { scene, triangles, width, height, adapter, backend, .. } = report;
    writeln!(text, "{scene}, {triangles} triangles, {width}x{height}; {adapter}, {backend}")?;
    writeln!(
        text,
        "wall ms of the whole frame (minimum, median), its CPU ms (median), and wall ms of its stages (median):"
    )?;
    write!(text, "{:14}{:>8}{:>8}{:>8}", "", "min", "median", "cpu")?;
    let stages = report.edits.first().map_or(&[][..], |edit| &edit.stages);
    for StageCosts { stage, .. } in stages {
        write!(text, "{stage:>10}")?;
    }
    writeln!(text, "{:>8}", "encode")?;
    for edit in &report.edits {
        let frame = edit.frame;
        write!(
            text,
            "{:14}{:8.1}{:8.1}{:8.1}",
            edit.edit.name(),
            frame.wall_ms.min,
            frame.wall_ms.median,
            frame.cpu_ms.median
        )?;
        for stage in &edit.stages {
            if stage.runs == 0 {
                write!(text, "{:>10}", "-")?;
            } else {
                write!(text, "{:10.1}", stage.costs.wall_ms.median)?;
            }
        }
        writeln!(text, "{:8.1}", edit.encode.wall_ms.median)?;
    }
    Ok(())
}

fn contestants(text: &mut String, report: &Report) -> std::fmt::Result {
    writeln!(text, "side by side, wall ms:")?;
    writeln!(text, "{:24}{:>8}{:>8}{:>8}{:>24}", "", "min", "median", "cpu", "of bent: min, median")?;
    for one in &report.side_by_side {
        let cpu = one.cpu_ms.map_or("-".into(), |cpu_ms| format!("{:.1}", cpu_ms.median));
        let (wall_ms, to_bent) = (one.wall_ms, one.to_bent);
        write!(text, "{:24}{:8.1}{:8.1}{cpu:>8}", one.what, wall_ms.min, wall_ms.median)?;
        writeln!(text, "{:16.2}{:8.2}", to_bent.min, to_bent.median)?;
    }
    Ok(())
}

fn growth(text: &mut String, report: &Report) -> std::fmt::Result {
    for axis in &report.growth {
        writeln!(text, "{}: wall ms (minimum, median), error against the reference", axis.axis)?;
        for point in &axis.points {
            let (wall_ms, error) = (point.frame.wall_ms, point.error.radiance_rmse);
            writeln!(text, "{:>14}{:10.1}{:10.1}{error:12.1e}", point.value, wall_ms.min, wall_ms.median)?;
        }
    }
    Ok(())
}
