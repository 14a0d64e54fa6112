//! `bendylights bend`: turns a straight light into a BendyLight.

use std::path::PathBuf;
use std::sync::Arc;

use assets::LoadedScene;
use cli::print_answer;
use document::{BendRequest, DEFAULT_BEND_SEGMENTS};
use glam::DVec3;
use light::{CheckedLight, MAX_SEGMENTS, ParameterOwner};
use protocol::light_file;
use raycast::Bvh;

use crate::error::{Error, no_such_light};
use crate::files;
use crate::render::open_scene;
use crate::usage::{print_notes, whole_number_parser};

#[derive(clap::Args)]
#[command(after_help = "\
A spotlight becomes the BendyLight that lights every point exactly as it does. Of an omni light that part is bent which
lies in a cone, from where the light stands to --toward. A directional light keeps its direction, and shines from before
--toward, with --scene from so far off that the cone holds the whole scene: within the cone it is as bright as it was,
along rays that now spread from one place, the less the narrower the cone is.

Control points lie on a straight line; move them to bend the light. A light with a range ends there. One without goes on
without end, and its control points reach to where its axis meets the scene, past the scene where it does not, or
without a scene one unit far. Without a scene a light that has no cone shines along its own -Z from where it stands,
unless --toward says where to.

Examples:
  bendylights bend --scene room.glb --light lamp > bent.json
  echo '{\"type\": \"spot\"}' > spot.json
  bendylights bend spot.json --scene demo:vases --segments 4 > bent.json
  echo '{\"type\": \"omni\", \"intensity\": 20, \"transform\": {\"translation\": [-1, 2, 1]}}' > bulb.json
  bendylights bend bulb.json --scene demo:vases --cone-angle 30 --toward 0.2,0.3,0 > bent.json")]
pub struct Args {
    /// Light file with one light of type spot, omni or directional [default: a light of the scene]
    #[arg(value_name = "LIGHT.json", required_unless_present = "scene")]
    light_file: Option<PathBuf>,
    /// Scene that the light shines on: a glTF file, or `demo:NAME`
    #[arg(long, value_name = "SCENE")]
    scene: Option<String>,
    /// Name of the scene's light to bend [default: its first spotlight, else its first light that is straight]
    #[arg(long, value_name = "NAME", requires = "scene", conflicts_with = "light_file")]
    light: Option<String>,
    /// Number of curve segments; a light of N segments has N + 2 control points
    #[arg(long, value_name = "N", default_value_t = DEFAULT_BEND_SEGMENTS, value_parser = whole_number_parser(1..=MAX_SEGMENTS))]
    segments: usize,
    /// Half angle of the cone in which an omni or directional light is bent, in degrees, less than 90 [default: 45]
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true)]
    cone_angle: Option<f64>,
    /// World position at which an omni or directional light shines then [default: the scene's middle]
    #[arg(long, value_name = "X,Y,Z", value_parser = position, allow_hyphen_values = true)]
    toward: Option<DVec3>,
}

pub fn run(args: &Args) -> Result<(), Error> {
    let loaded = args.scene.as_deref().map(open_scene).transpose()?;
    let (file, light, scene) = match (&args.light_file, loaded) {
        (Some(file), loaded) => {
            let light = files::read_one_light(file)?;
            (file.display().to_string(), light, loaded.map(|loaded| loaded.scene))
        }
        (None, Some(loaded)) => {
            let (name, loaded) = (args.scene.clone().unwrap_or_default(), loaded.with_default_light());
            let light = of_scene(&name, &loaded, args.light.as_deref())?;
            print_notes(&loaded.notes);
            (name, light, Some(loaded.scene))
        }
        (None, None) => unreachable!("one of them is required"),
    };
    let light = light.light();
    match light.owner() {
        ParameterOwner::Bendy => return Err(Error::BendOfBendy { file }),
        ParameterOwner::Spot if args.cone_angle.is_some() || args.toward.is_some() => {
            return Err(Error::HasCone { file });
        }
        _ => {}
    }
    let Args { segments, cone_angle, toward, .. } = *args;
    let request = BendRequest { segments, range: None, cone_angle, toward };
    let bending =
        scene.map_or(request, |scene| request.filled_in_from_scene(light, &Bvh::new(scene::pose(scene, 0.0))));
    let bendy = bending.bend(light).map_err(|reason| Error::BadLight { file, reason })?;
    Ok(print_answer(&light_file::to_json(&bendy))?)
}

/// Parses a world position.
fn position(text: &str) -> Result<DVec3, String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y, z]) if DVec3::new(x, y, z).is_finite() => Ok(DVec3::new(x, y, z)),
        _ => Err("write it as three numbers of world units, such as 0.5,1,-2".into()),
    }
}

/// Returns the light of that name. Without a name, returns the first spotlight, or the first straight light if
/// there is none.
fn of_scene(scene: &str, loaded: &LoadedScene, name: Option<&str>) -> Result<Arc<CheckedLight>, Error> {
    let lights = &loaded.contents.lights;
    let first = |wanted: &dyn Fn(&CheckedLight) -> bool| lights.iter().find(|light| wanted(light)).cloned();
    let Some(name) = name else {
        let spot = first(&|light| light.light().owner() == ParameterOwner::Spot);
        let straight = || first(&|light| light.light().owner() != ParameterOwner::Bendy);
        return spot.or_else(straight).ok_or_else(|| Error::NoneToBend { scene: scene.into() });
    };
    let names = lights.iter().map(|light| light.light().name());
    first(&|light| light.light().name() == name).ok_or_else(|| no_such_light(scene.into(), name, names))
}
