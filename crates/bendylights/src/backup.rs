//! `bendylights backup`: copies a data folder while a server uses it.

use std::path::PathBuf;

use cli::{print_answer, progress};
use serde_json::json;
use store::{Backup, back_up};

use crate::error::Error;
use crate::usage::DATA;

#[derive(clap::Args)]
#[command(after_help = "\
Copies sessions and scenes while the server goes on: all that it had acknowledged when the copy began is in it. The copy
is a data folder itself, to be served, or copied back by the same command. It appears whole or not at all. The server's
token is not in it; copy the file `token` too where the copy is to let in the same people.

Prints JSON: the sessions, records, files of scenes and bytes that are in it.

Examples:
  bendylights backup backups/monday
  bendylights serve --data backups/monday
  bendylights backup bendylights-data --data backups/monday")]
pub struct Args {
    /// Folder to make
    #[arg(value_name = "COPY")]
    to: PathBuf,
    /// Folder that `bendylights serve --data` was given, or an earlier copy
    #[arg(long, default_value = DATA, value_name = "DIR")]
    data: PathBuf,
}

pub fn run(args: &Args) -> Result<(), Error> {
    let bar = progress(0);
    let backed_up = back_up(&args.data, &args.to, |step, all| {
        bar.set_length(all);
        bar.inc(step);
    });
    bar.finish_and_clear();
    let Backup { sessions, records, files, bytes } = backed_up?;
    Ok(print_answer(&json!({"sessions": sessions, "records": records, "files": files, "bytes": bytes}).to_string())?)
}
