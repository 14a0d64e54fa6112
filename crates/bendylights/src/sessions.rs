//! `bendylights sessions`: lists the sessions of a data folder.

use std::path::PathBuf;

use cli::print_answer;
use serde_json::json;
use store::{SessionSummary, Store, StoreError};

use crate::error::Error;
use crate::usage::DATA;

#[derive(clap::Args)]
#[command(after_help = "\
Prints a line a session: its name, its number of records, the hash of its document, and its title where that is not its
name. Those that are archived are left out without --archived. With --json an array of objects with name, title, seq,
hash, epoch, which names the session's history, archived, and, in milliseconds since 1970, madeMs and changedMs. Where a
log cannot be read, the reason stands in place of the hash, in JSON null.

Example:
  bendylights sessions")]
pub struct Args {
    /// Folder that `bendylights serve --data` was given
    #[arg(long, default_value = DATA, value_name = "DIR")]
    data: PathBuf,
    /// List archived sessions too
    #[arg(long)]
    archived: bool,
}

pub fn run(args: &Args, as_json: bool) -> Result<(), Error> {
    let store = Store::open(&args.data)?;
    let listed = |session: SessionSummary| {
        let hash = store.session(&session.name).and_then(|row| store.document_hash(&row));
        (session, hash)
    };
    let wanted = store.sessions()?.into_iter().filter(|session| args.archived || !session.is_archived);
    let sessions: Vec<Listed> = wanted.map(listed).collect();
    Ok(print_answer(&if as_json { to_json(&sessions) } else { to_table(&sessions) })?)
}

/// Session, with the hash of its document, or the reason that it has none.
type Listed = (SessionSummary, Result<String, StoreError>);

fn to_json(sessions: &[Listed]) -> String {
    let object = |(session, hash): &Listed| {
        let SessionSummary { name, title, epoch, seq, is_archived, made_ms, changed } = session;
        let changed_ms = changed.as_ref().map(|change| change.time_ms);
        json!({"name": name, "title": title, "seq": seq, "hash": hash.as_ref().ok(), "epoch": epoch,
            "archived": is_archived, "madeMs": made_ms, "changedMs": changed_ms})
        .to_string()
    };
    format!("[{}]", sessions.iter().map(object).collect::<Vec<_>>().join(",\n "))
}

fn to_table(sessions: &[Listed]) -> String {
    let longest = sessions.iter().map(|(session, _)| session.name.len()).max().unwrap_or(0);
    let width = longest.max("session".len());
    let line = |name: &str, records: &str, hash: &str| format!("{name:width$}  {records:>8}  {hash}");
    let lines = sessions.iter().map(|(session, hash)| {
        let hash = hash.as_ref().map_or_else(|why| format!("cannot be opened: {why}"), String::clone);
        let line = line(&session.name, &session.seq.to_string(), &hash);
        if session.title == session.name { line } else { format!("{line}  {}", session.title) }
    });
    let lines: Vec<_> = std::iter::once(line("session", "records", "document")).chain(lines).collect();
    lines.join("\n")
}
