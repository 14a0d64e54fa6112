//! `bendylights bend`: a spotlight as a BendyLight.

use std::path::PathBuf;
use std::sync::Arc;

use assets::Loaded;
use cli::answer;
use document::{BENT_SEGMENTS, axis_reach};
use light::{CheckedLight, Owner};
use protocol::light_file;

use crate::error::Error;
use crate::files;
use crate::render::{no_such_light, open_scene};

#[derive(clap::Args)]
#[command(after_help = "\
The BendyLight printed lights every point exactly as the spotlight does. Its control points lie on a straight line;
move them to bend the light. A spotlight with a range ends there. One without goes on without end, and its control
points reach to where its axis meets the scene, past the scene where it does not, or without a scene one unit far.

Examples:
  bendylights bend --scene room.glb --light lamp > bent.json
  echo '{\"type\": \"spot\"}' > spot.json
  bendylights bend spot.json --scene demo:vases --segments 4 > bent.json")]
pub struct Args {
    /// Light file with one spotlight [default: a light of the scene]
    #[arg(value_name = "LIGHT.json", required_unless_present = "scene")]
    light_file: Option<PathBuf>,
    /// Scene that the light shines on: a glTF file, or `demo:NAME`
    #[arg(long, value_name = "SCENE")]
    scene: Option<String>,
    /// Which of the scene's lights to bend, by its name [default: its first spotlight]
    #[arg(long, value_name = "NAME", requires = "scene", conflicts_with = "light_file")]
    light: Option<String>,
    /// Number of curve segments; a light of N segments has N + 2 control points
    #[arg(long, value_name = "N", default_value_t = BENT_SEGMENTS)]
    segments: usize,
}

pub fn run(args: &Args) -> Result<(), Error> {
    let mut loaded = args.scene.as_deref().map(open_scene).transpose()?;
    let (file, light) = match (&args.light_file, &mut loaded) {
        (Some(file), _) => (file.display().to_string(), files::read_one_light(file)?),
        (None, Some(loaded)) => {
            let scene = args.scene.clone().unwrap_or_default();
            let light = of_scene(&scene, loaded, args.light.as_deref())?;
            (scene, light)
        }
        (None, None) => unreachable!("one of them is required"),
    };
    if light.tube().is_some() {
        return Err(Error::BendOfBendy { file });
    }
    let light = light.light();
    let reach = loaded.map(|loaded| axis_reach(light, &scene::pose(loaded.scene)));
    let reach = reach.unwrap_or_else(|| light.transform().scale);
    let bendy =
        light::bend_to(light, args.segments, reach).map_err(|reason| Error::BadLight { file, reason })?;
    Ok(answer(&light_file::to_json(&bendy))?)
}

/// The light of that name, or the first spotlight.
fn of_scene(scene: &str, loaded: &Loaded, name: Option<&str>) -> Result<Arc<CheckedLight>, Error> {
    let lights = &loaded.contents.lights;
    let wanted = |light: &&Arc<CheckedLight>| match name {
        Some(name) => light.light().name() == name,
        None => light.light().owner() == Owner::Spot,
    };
    let names = || lights.iter().map(|light| light.light().name());
    match (lights.iter().find(wanted), name) {
        (Some(light), _) => Ok(Arc::clone(light)),
        (None, Some(name)) => Err(no_such_light(scene.into(), name, names())),
        (None, None) => Err(Error::NoSpot { scene: scene.into() }),
    }
}
