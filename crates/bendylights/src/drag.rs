//! `bendylights drag`: drags features of lights in a picture.

use std::path::PathBuf;
use std::time::Instant;

use ::drag::{WorkBudget, drag, drag_alternatives};
use assets::LoadedScene;
use cli::LIMITS;
use protocol::drag_file::{DragCamera, DragResult, FileDrag, NameOrIndex};
use raycast::Bvh;
use scene::{Camera, framing_camera};

use crate::error::{Error, choices, no_such_light};
use crate::files;
use crate::render::{lights_from, open_scene_with_lights};
use crate::usage::{print_notes, print_objects};

#[derive(clap::Args)]
#[command(after_help = "\
Takes a JSON array of drags:
  light    the light, by its name or its index
  kind     shadow, hotspot, highlight or diffuse: M is the surface seen at `from`, M' the one at `to`, and then
           shadow     what shadows M shadows M'
           hotspot    M' lies in the light where M did
           highlight  light arrives at M' along the mirror direction
           diffuse    light arrives at M' along the normal
  alternative  what follows: best (lands and changes least of what is lit), controlPoints, narrower (radii shrink by a fifth
           at most where the light would fold), wholeLight, pastCaster (control points past what throws the shadow alone),
           linkedCopy (a copy of the light as it was shines on what throws the shadow); null: what points and radii say [null]
  alternatives  true for all of them, the best first, in `alternatives` of the answer [false]
  points   indices of the control points that move, and nothing else; null moves the light as a whole [null]
  radii    keep; solve: those of the moving points change too; follow: those that would fold the light shrink [keep]
  camera   by its name or its index, or as an object; null: the first, or one that frames the scene [null]
  size     width and height of the picture in pixels
  from, to in pixels from its top left corner; centres of pixels are at .5
  pins     what is to stay as it is, an array of {kind, light, at, caster, hard}: at a world position on a surface, or on all
           of a node by its name or path
           look       how much light arrives, from where, and whether in shadow
           direction  the direction from which light arrives
           lit, shadowed  that it arrives, or that something stands in its way
           shadow     the shadow of the very point that throws it, of the node `caster` or of the first in the way
           coordinates  where it lies across the light, so that the same light path reaches it
           hard: true whatever is asked, or as far as that lets it [[]]
  sourceOutside   whether the source may not go through a surface [true with alternative(s), else false]
Each drag begins with the light of the file, whatever the others do.

Prints an array with an object for each: status (landed: within half a pixel; limited: as near as may be; refused),
limit, reason and pin where there is one, residualPx, changedShare (of the picture's pixels), pinnedChange (at the worst
point of pinned nodes), alternative, shadowedBy, iterations, seconds, fromWorld, toWorld, pivotWorld, the light, its copy
if it has one, and the solver with its version.

Example:
  bendylights drag demo:vases drags.json
  bendylights drag room.glb --lights key.json drags.json")]
pub struct Args {
    /// glTF file (.gltf or .glb), or `demo:NAME` as `bendylights scenes` lists them
    scene: String,
    /// Light file to use in place of the scene's own lights
    #[arg(long, value_name = "FILE")]
    lights: Option<PathBuf>,
    /// Drags, a JSON array; `-` reads standard input
    #[arg(value_name = "DRAGS.json", default_value = "-")]
    drags: PathBuf,
}

pub fn run(args: &Args) -> Result<(), Error> {
    let drags = files::read_drags(&args.drags)?;
    let LoadedScene { scene, contents, notes, .. } = open_scene_with_lights(&args.scene, args.lights.as_deref())?;
    print_notes(&notes);
    let whose_lights = lights_from(&args.scene, args.lights.as_deref());
    let lights = contents.lights;
    let bvh = Bvh::new(scene::pose(scene, 0.0));
    let file = args.drags.display().to_string();
    let objects: Result<Vec<String>, Error> = drags
        .iter()
        .enumerate()
        .map(|(index, file_drag)| {
            let names = || lights.iter().map(|light| light.light().name());
            let find = |wanted: &NameOrIndex| {
                wanted
                    .index_in(names())
                    .ok_or_else(|| no_such_light(whose_lights.clone(), &wanted.to_string(), names()))
            };
            let light = find(&file_drag.light)?;
            file_drag.pins.iter().flatten().try_for_each(|pin| find(&pin.light).map(|_| ()))?;
            if !file_drag.size.iter().all(|side| (1..=LIMITS.max_side).contains(side)) {
                return Err(Error::BadDrag { file: file.clone(), index, max_side: LIMITS.max_side });
            }
            let began = Instant::now();
            let camera = camera(&args.scene, &bvh, &contents.cameras, file_drag, |why| Error::DragCamera {
                file: file.clone(),
                index,
                why,
            })?;
            let domain = file_drag.to_domain(camera, |wanted| wanted.index_in(names()) == Some(light));
            let (light, work) = (&lights[light], WorkBudget::new(&|_| true));
            let solve_all = || drag_alternatives(&bvh, light, &domain, &[], &work);
            let alternatives = if file_drag.alternatives { solve_all() } else { Vec::new() };
            let best = alternatives.first().cloned().unwrap_or_else(|| drag(&bvh, light, &domain, &[]));
            let result = DragResult::new(&best, &alternatives, began.elapsed().as_secs_f64());
            Ok(serde_json::to_string(&result).expect("finite numbers and string keys"))
        })
        .collect();
    Ok(print_objects(&objects?)?)
}

/// Returns the camera of a drag.
fn camera(
    scene: &str,
    bvh: &Bvh,
    cameras: &[Camera],
    drag: &FileDrag,
    invalid: impl FnOnce(&'static str) -> Error,
) -> Result<Camera, Error> {
    let [width, height] = drag.size;
    let framing = || framing_camera(&bvh.posed.subject_bounds(), f64::from(width) / f64::from(height));
    Ok(match &drag.camera {
        None => cameras.first().cloned().unwrap_or_else(framing),
        Some(DragCamera::Own(own)) => {
            let camera = Camera::from((**own).clone());
            camera.check().map_err(invalid)?;
            camera
        }
        Some(DragCamera::Listed(wanted)) => {
            let names = || cameras.iter().map(|camera| camera.name.as_str());
            let found = wanted.index_in(names()).map(|index| cameras[index].clone());
            found.ok_or_else(|| Error::UnknownName {
                whose: scene.into(),
                what: "camera",
                name: wanted.to_string(),
                choices: choices(names()),
            })?
        }
    })
}
