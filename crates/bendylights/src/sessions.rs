//! `bendylights sessions`: what is in a data folder.

use std::path::PathBuf;

use cli::answer;
use serde_json::json;
use store::{SessionRow, Store};

use crate::error::Error;

#[derive(clap::Args)]
#[command(after_help = "\
Prints a line a session: its name, its number of records, the hash of its document. With --json an array of objects with
name, seq, hash and epoch, which names the session's history.

Example:
  bendylights sessions --data bendylights-data")]
pub struct Args {
    /// Folder that `bendylights serve --data` was given
    #[arg(long, value_name = "DIR")]
    data: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> Result<(), Error> {
    let rows = Store::open(&args.data)?.sessions()?;
    Ok(answer(&if args.json { as_json(&rows) } else { as_table(&rows) })?)
}

fn as_json(rows: &[SessionRow]) -> String {
    let object = |row: &SessionRow| {
        json!({"name": row.name, "seq": row.seq, "hash": row.hash, "epoch": row.epoch}).to_string()
    };
    format!("[{}]", rows.iter().map(object).collect::<Vec<_>>().join(",\n "))
}

fn as_table(rows: &[SessionRow]) -> String {
    let longest = rows.iter().map(|row| row.name.len()).max().unwrap_or(0);
    let width = longest.max("session".len());
    let line = |name: &str, records: &str, hash: &str| format!("{name:width$}  {records:>8}  {hash}");
    let lines = rows.iter().map(|row| line(&row.name, &row.seq.to_string(), &row.hash));
    let lines: Vec<_> = std::iter::once(line("session", "records", "document")).chain(lines).collect();
    lines.join("\n")
}
