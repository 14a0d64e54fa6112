//! `bendylights import`: makes a session from a log file or a bundle.

use std::path::PathBuf;

use cli::print_answer;
use document::AssetHash;
use store::{Assets, SessionRow, Store};

use crate::error::Error;
use crate::usage::DATA;
use crate::{bundle, files, known_scenes, replay};

#[derive(clap::Args)]
#[command(after_help = "\
The log is replayed first: one that has gaps, does not fit together or gives another document than it says is refused,
and nothing is left of it. Scenes that it loads must be demos, in DIR/assets, or in the bundle.

Examples:
  bendylights import main.jsonl --name main-again
  bendylights import main.zip")]
pub struct Args {
    /// Log file or bundle that `bendylights export` wrote
    #[arg(value_name = "LOG.jsonl|LOG.zip")]
    log: PathBuf,
    /// Data folder to put the session into; made where it is missing
    #[arg(long, default_value = DATA, value_name = "DIR")]
    data: PathBuf,
    /// Name of the session [default: the one in the log]
    #[arg(long)]
    name: Option<String>,
}

pub fn run(args: &Args) -> Result<(), Error> {
    let row = if files::is_bundle(&args.log) {
        bundle::import(&args.log, &args.data, args.name.as_deref())?
    } else {
        import_log(args)?
    };
    Ok(print_answer(&format!("{}: {} records", row.name, row.seq))?)
}

fn import_log(args: &Args) -> Result<SessionRow, Error> {
    let assets = Assets::in_folder(&args.data);
    let is_here = |asset: &AssetHash| known_scenes::is_available(&assets, asset);
    if Store::open(&args.data).is_err() {
        // The log is read before the folder is made, because a refused log must make no folder.
        let (log, bar) = files::open_log(&args.log)?;
        let checked = store::check_log(log, args.name.as_deref(), &is_here);
        bar.finish_and_clear();
        checked.map_err(|reason| replay::refused(&args.log, reason))?;
    }
    let (log, bar) = files::open_log(&args.log)?;
    let mut store = Store::create(&args.data)?;
    let imported = store.import(log, args.name.as_deref(), &is_here);
    bar.finish_and_clear();
    imported.map_err(|reason| replay::refused(&args.log, reason))
}
