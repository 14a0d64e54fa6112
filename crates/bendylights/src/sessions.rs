//! `bendylights sessions`: what is in a data folder.

use std::path::PathBuf;

use cli::answer;
use serde_json::json;
use store::{SessionRow, Store, StoreError};

use crate::error::Error;
use crate::usage::DATA;

#[derive(clap::Args)]
#[command(after_help = "\
Prints a line a session: its name, its number of records, the hash of its document. With --json an array of objects with
name, seq, hash and epoch, which names the session's history. Where a log cannot be read, the reason stands in place of
the hash, in JSON null.

Example:
  bendylights sessions")]
pub struct Args {
    /// Folder that `bendylights serve --data` was given
    #[arg(long, default_value = DATA, value_name = "DIR")]
    data: PathBuf,
}

pub fn run(args: &Args, as_json: bool) -> Result<(), Error> {
    let store = Store::open(&args.data)?;
    let listed = |row: SessionRow| {
        let hash = store.document_hash(&row);
        (row, hash)
    };
    let sessions: Vec<Listed> = store.sessions()?.into_iter().map(listed).collect();
    Ok(answer(&if as_json { to_json(&sessions) } else { to_table(&sessions) })?)
}

/// A session with the hash of its document, or why it has none.
type Listed = (SessionRow, Result<String, StoreError>);

fn to_json(sessions: &[Listed]) -> String {
    let object = |(row, hash): &Listed| {
        json!({"name": row.name, "seq": row.seq, "hash": hash.as_ref().ok(), "epoch": row.epoch}).to_string()
    };
    format!("[{}]", sessions.iter().map(object).collect::<Vec<_>>().join(",\n "))
}

fn to_table(sessions: &[Listed]) -> String {
    let longest = sessions.iter().map(|(row, _)| row.name.len()).max().unwrap_or(0);
    let width = longest.max("session".len());
    let line = |name: &str, records: &str, hash: &str| format!("{name:width$}  {records:>8}  {hash}");
    let lines = sessions.iter().map(|(row, hash)| {
        let hash = hash.as_ref().map_or_else(|why| format!("cannot be opened: {why}"), String::clone);
        line(&row.name, &row.seq.to_string(), &hash)
    });
    let lines: Vec<_> = std::iter::once(line("session", "records", "document")).chain(lines).collect();
    lines.join("\n")
}
