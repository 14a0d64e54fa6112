//! `bendylights parameters`: lists all parameters that can be set.

use cli::print_answer;
use protocol::{Parameter, ParameterKind, parameter_table};

use crate::error::Error;
use crate::usage::{json_name, print_json};

#[derive(clap::Args)]
#[command(after_help = "\
Prints a line for each thing that can be set: what has it, its name in commands, light files and logs, its range or its
choices, its default, and what a change makes stale: nothing, the light's radiance in pictures, or its shadow map too.
With --json the table that the server gives at /parameters, with addresses for the command `set`.

Example:
  bendylights parameters --of bendy")]
pub struct Args {
    /// Only what this has: bendy, spot, omni, directional, point or camera
    #[arg(long, value_parser = ["bendy", "spot", "omni", "directional", "point", "camera"], value_name = "OWNER")]
    of: Option<String>,
}

pub fn run(args: &Args, as_json: bool) -> Result<(), Error> {
    let mut table = parameter_table();
    if let Some(owner) = &args.of {
        table.parameters.retain(|row| row.address.contains_key(owner));
    }
    if as_json {
        return Ok(print_json(&table)?);
    }
    let rows: Vec<[String; 5]> = table.parameters.iter().map(line).collect();
    let head = ["of", "name", "values", "default", "touches"].map(String::from);
    let width = |column: usize| rows.iter().chain([&head]).map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: [usize; 5] = std::array::from_fn(width);
    let text = |row: &[String; 5]| {
        let cells: Vec<String> = row.iter().zip(widths).map(|(cell, width)| format!("{cell:width$}")).collect();
        cells.join("  ").trim_end().to_owned()
    };
    let lines: Vec<String> = [&head].into_iter().chain(&rows).map(text).collect();
    Ok(print_answer(&lines.join("\n"))?)
}

fn line(row: &Parameter) -> [String; 5] {
    let owners: Vec<&str> = row.address.keys().map(String::as_str).collect();
    let mut defaults: Vec<String> = row.default.values().map(ToString::to_string).collect();
    defaults.dedup();
    let default = match (row.default.len(), &defaults[..]) {
        (_, []) => "-".into(),
        (_, [one]) => one.clone(),
        _ => row.default.iter().map(|(owner, value)| format!("{owner} {value}")).collect::<Vec<_>>().join(", "),
    };
    [owners.join(", "), row.name.clone(), values(&row.kind), default, json_name(row.touches)]
}

/// Formats the possible values of a parameter for people.
fn values(kind: &ParameterKind) -> String {
    match kind {
        ParameterKind::Number { unit, min, max, exclusive_min, exclusive_max, none, .. } => {
            let mut said = match (min.or(*exclusive_min), max.or(*exclusive_max)) {
                (Some(low), Some(high)) => format!("{low} to {high}"),
                (Some(low), None) => format!("from {low}"),
                (None, Some(high)) => format!("to {high}"),
                (None, None) => "any number".into(),
            };
            if exclusive_min.is_some() || exclusive_max.is_some() {
                said.push_str(", ends left out");
            }
            if !unit.is_empty() {
                said = format!("{said}, {unit}");
            }
            if let Some(none) = none {
                said = format!("{said}; null: {}", none.to_lowercase());
            }
            said
        }
        ParameterKind::Choice { choices } => {
            choices.iter().map(|choice| choice.name.as_str()).collect::<Vec<_>>().join(" | ")
        }
        ParameterKind::Color => "[r, g, b], linear".into(),
        ParameterKind::Vector { unit, .. } if unit.is_empty() => "[x, y, z]".into(),
        ParameterKind::Vector { unit, .. } => format!("[x, y, z], {unit}"),
        ParameterKind::Flag => "true or false".into(),
        ParameterKind::Rotation => "[x, y, z, w]".into(),
        ParameterKind::Text { max_bytes } => format!("text, at most {max_bytes} bytes"),
        ParameterKind::Links { .. } => "{include, exclude}, paths of nodes; null: all".into(),
        ParameterKind::PeriodicCurve { max_knots, min, max, none, .. } => {
            let none = none.to_lowercase();
            format!("[[degrees, {min} to {max}], ...], at most {max_knots} pairs; null: {none}")
        }
        ParameterKind::Projection => "a projection".into(),
    }
}
