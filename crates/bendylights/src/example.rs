//! `bendylights example`: writes files to begin with.

use std::path::PathBuf;

use cli::{OutputFile, make_folder, print_answer};
use protocol::light_file;

use crate::error::Error;

#[derive(clap::Args)]
#[command(after_help = "\
Writes room.glb, a scene with a camera and a spotlight called `lamp`, and lights.json, a light file with a BendyLight
called `key`. They are yours to change and to give away. A file that is there already stays as it is, and is named.

Example:
  bendylights example example
  bendylights render example/room.glb --lights example/lights.json -o room.png
  bendylights bend --scene example/room.glb --light lamp > bent.json
  bendylights serve --scene example/room.glb")]
pub struct Args {
    /// Folder to write to; made where it is missing
    #[arg(value_name = "DIR")]
    folder: PathBuf,
}

pub fn run(args: &Args) -> Result<(), Error> {
    make_folder(Some(&args.folder))?;
    let light = light_file::to_json(&assets::example_light()) + "\n";
    for (name, bytes) in [("room.glb", assets::example_glb()), ("lights.json", light.into_bytes())] {
        let path = args.folder.join(name);
        if path.exists() {
            return Err(Error::FileExists { file: path });
        }
        OutputFile::create(&path)?.write(&bytes)?;
        print_answer(&path.display().to_string())?;
    }
    Ok(())
}
