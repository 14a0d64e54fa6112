//! `bendylights scenes`: lists the demo scenes.

use cli::print_answer;

use crate::error::Error;

pub fn run() -> Result<(), Error> {
    let lines: Vec<String> =
        assets::DEMO_NAMES.iter().map(|(name, description)| format!("demo:{name}  {description}")).collect();
    Ok(print_answer(&lines.join("\n"))?)
}
