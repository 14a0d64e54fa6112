//! `bendylights export`: writes a session's edit log to a file, with or without its scenes.

use std::path::PathBuf;

use cli::OutputFile;
use store::Store;

use crate::bundle;
use crate::error::Error;
use crate::usage::DATA;

#[derive(clap::Args)]
#[command(after_help = "\
Writes JSON Lines: a header, each record of the log, and checkpoints that say what the document's hash is there. The
server may be running. Scenes are not in the log: they are files in DIR/assets, named by their SHA-256. A file whose name
ends in .zip becomes a bundle of the log and the scenes that it loads.

Examples:
  bendylights export main -o main.jsonl
  bendylights export main -o main.zip")]
pub struct Args {
    /// Name of the session
    session: String,
    /// Folder that `bendylights serve --data` was given
    #[arg(long, default_value = DATA, value_name = "DIR")]
    data: PathBuf,
    /// Log file or bundle to write
    #[arg(short, value_name = "LOG.jsonl|LOG.zip")]
    output: PathBuf,
}

pub fn run(args: &Args) -> Result<(), Error> {
    let store = Store::open(&args.data)?;
    let output = OutputFile::create(&args.output)?;
    output.write_with(|file| {
        if bundle::is_wanted(&args.output) {
            return bundle::write(&store, &args.session, &args.output, file);
        }
        Ok(store.export(&args.session, file)?)
    })
}
