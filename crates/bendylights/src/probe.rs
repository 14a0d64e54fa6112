//! `bendylights probe`: reports why a pixel is lit or not.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::Arc;

use assets::LoadedScene;
use cli::{Size, print_answer};
use glam::DVec2;
use protocol::{CameraChoice, Probed, ProbedLight, Vec3};
use raycast::Bvh;
use reference::Reference;
use scene::View;

use crate::error::Error;
use crate::picture::choose_camera;
use crate::render::{instances, open_scene_with_lights};
use crate::usage::{json_name, print_notes};

#[derive(clap::Args)]
#[command(after_help = "\
Prints a JSON object, all positions and directions in the world:
  seen     the node there by its path, the material's name, position, normal, depth, and the radiance of the scene's fill;
           null where there is only background
  lights   every light, by its index:
    state       lit, or the first of these that keeps it from being so:
                disabled    shines nowhere: disabledBy is off, or dark, where it has no intensity or colour
                unlinked    does not light the node
                outside     does not reach there: outside of its tube, cone, window or range
                faded       leaves nothing of its light there
                facingAway  comes from behind the surface
                shadowed    meets something before: shadowedBy has the first from the source on, its path and position
    place       t, v and w there, the radius of tube or cone, pathLength: how far its light has come, and the direction to
                where it comes from; null outside
    irradiance  on a surface square to the light, were nothing in the way
    radiance    what it adds to the pixel, and its share of what all lights add
    path        the way of its light from the source, points so dense that straight lines do for the curve

Examples:
  bendylights probe demo:vases --size 640x360 430.5 265.5
  bendylights probe room.glb --lights key.json --camera 0 --size 1920x1080 960 540 --table")]
pub struct Args {
    /// glTF file (.gltf or .glb), or `demo:NAME` as `bendylights scenes` lists them
    scene: String,
    /// Light file to use in place of the scene's own lights
    #[arg(long, value_name = "FILE")]
    lights: Option<PathBuf>,
    /// Camera by its name or its index from 0 [default: the first, or one that frames the scene]
    #[arg(long, value_name = "NAME|INDEX")]
    camera: Option<String>,
    /// Width and height of the picture in pixels, each at most 8192
    #[arg(long, value_name = "WxH")]
    size: Size,
    /// Print a table for people in place of JSON
    #[arg(long)]
    table: bool,
    /// Pixels from the picture's left; a pixel's centre is at .5
    #[arg(value_name = "X", allow_negative_numbers = true)]
    x: f64,
    /// Pixels from the picture's top
    #[arg(value_name = "Y", allow_negative_numbers = true)]
    y: f64,
}

pub fn run(args: &Args) -> Result<(), Error> {
    let LoadedScene { scene, contents, notes, .. } = open_scene_with_lights(&args.scene, args.lights.as_deref())?;
    print_notes(&notes);
    let lights = instances(contents.lights);
    let posed = scene::pose(scene, 0.0);
    let Size { width, height } = args.size;
    let aspect = f64::from(width) / f64::from(height);
    let wanted = args.camera.clone().map(CameraChoice::Named);
    let camera = choose_camera(&args.scene, wanted.as_ref(), aspect, &posed.subject_bounds(), &contents.cameras)?;
    let reference = Reference::for_point_queries(Arc::new(Bvh::new(posed)));
    let view = View::beauty(camera, [width, height]);
    let probe = reference.probe(&view, DVec2::new(args.x, args.y), &lights, &BTreeSet::new())?;
    let probed = Probed::new(&probe, &reference.bvh.posed, |_| None);
    let text = if args.table {
        table(&probed)
    } else {
        serde_json::to_string(&probed).expect("finite numbers and string keys")
    };
    Ok(print_answer(&text)?)
}

/// Formats a line for the visible surface, and one for each light.
fn table(probed: &Probed) -> String {
    let Some(seen) = &probed.seen else { return "nothing is seen there".into() };
    let material = seen.material.as_ref().map_or(String::new(), |name| format!(", of {name}"));
    let mut lines = vec![
        plain(&format!("{}{material} at {}", seen.node, vector(seen.position))),
        format!("{:<20} {:<10} {:>6}  {:<24} {:>10}  why", "light", "state", "share", "t (v, w)", "length"),
    ];
    lines.extend(probed.lights.iter().map(|light| plain(&row(light))));
    lines.join("\n")
}

fn row(light: &ProbedLight) -> String {
    let state = json_name(light.state);
    let coords = light.place.map(|coords| format!("{:.4} ({:.4}, {:.4})", coords.t, coords.v, coords.w));
    let length = light.place.and_then(|coords| coords.path_length).map(|length| format!("{length:.4}"));
    let caster = light.shadowed_by.as_ref();
    let why = caster.map(|caster| format!("{} at {}", caster.node, vector(caster.position)));
    let why = why.or(light.disabled_by.map(|by| format!("{by:?}").to_lowercase()));
    let (coords, length) = (coords.unwrap_or_default(), length.unwrap_or_default());
    let share = 100.0 * light.share;
    let line =
        format!("{:<20} {state:<10} {share:>5.1}%  {coords:<24} {length:>10}  {}", light.name, why.unwrap_or_default());
    line.trim_end().into()
}

fn vector([x, y, z]: Vec3) -> String {
    format!("[{x:.4}, {y:.4}, {z:.4}]")
}

/// Replaces control characters in names from files, because a terminal would interpret them.
fn plain(line: &str) -> String {
    line.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}
