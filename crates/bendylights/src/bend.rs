//! `bendylights bend`: a spotlight as a BendyLight.

use std::path::PathBuf;

use cli::answer;
use protocol::light_file;

use crate::error::Error;
use crate::files;

#[derive(clap::Args)]
#[command(after_help = "\
The BendyLight printed lights every point exactly as the spotlight does. Its control points lie on a straight line;
move them to bend the light. A spotlight with a range ends there, one without goes on without end.

Example:
  echo '{\"type\": \"spot\", \"range\": 6}' > spot.json
  bendylights bend spot.json --segments 3 > bent.json")]
pub struct Args {
    /// Light file with one spotlight
    #[arg(value_name = "LIGHT.json")]
    light: PathBuf,
    /// Number of curve segments; a light of N segments has N + 2 control points
    #[arg(long, value_name = "N")]
    segments: usize,
}

pub fn run(args: &Args) -> Result<(), Error> {
    let file = args.light.display().to_string();
    let light = files::read_one_light(&args.light)?;
    if light.tube().is_some() {
        return Err(Error::BendOfBendy { file });
    }
    let bendy =
        light::bend(light.light(), args.segments).map_err(|reason| Error::BadLight { file, reason })?;
    Ok(answer(&light_file::to_json(&bendy))?)
}
