//! `bendylights render`: draws a picture of a scene.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use assets::LoadedScene;
use clap::ValueEnum;
use cli::{LIMITS, progress};
use document::SceneContents;
use light::{CheckedLight, LightId, LightInstance, SceneBounds, Tube};
use protocol::RenderRequest;
use reference::Reference;
use render::{Backend, Picture, PictureOrigin, Pixels, Renderer, ShadowSettings, View, ViewSlot};
use scene::PosedScene;

use crate::error::{Error, choices};
use crate::picture::{PictureArgs, choose_camera};
use crate::picture_files::{OutputPictures, PictureJob};
use crate::usage::{print_notes, whole_number_parser};
use crate::{files, gpu};

#[derive(clap::Args)]
#[command(after_help = "\
AOVs, what a picture shows:
  beauty      the lit scene, with a fill that keeps what no light reaches readable; --fill 0 takes it away
  depth       distance from the camera's plane, in world units
  normal      shading normal in the world
  position    place in the world
  t           place along the light's curve, 0 at its source to the number of segments
  vw          place across the light's tube, in radii
  direction   direction in the world from the surface to where the light comes from
  visibility  1 where the light reaches, 0 in its shadow
  wireframe   the triangles of the light's shadow map as the light sees them, bent straight; the camera is not used

EXR holds the linear values themselves, all quantities in one file: R G B A, Z, N.X, P.X and so on, and with --aov all those of each
light with its name before them, as key.visibility. In PNG the beauty is tone-mapped, after --exposure, and the others are made readable: near is
bright, directions and normals are shown as (x + 1) / 2, t as a ramp with a line at each joint, (v, w) by hue and
distance from the curve; a wireframe is drawn in white over t's ramp, darker outside the light.

Examples:
  bendylights render demo:vases -o vases.png
  bendylights render room.glb --lights key.json --camera 0 --size 1920x1080 --samples 64 -o room.exr
  bendylights render room.glb --lights key.json --fill 0 -o key-alone.exr
  bendylights render room.glb --lights key.json --aov visibility --light key -o shadow.png
  bendylights render room.glb --lights key.json --aov all -o room.exr
  bendylights render room.glb --lights key.json -o room.png -o room.exr
  bendylights render room.glb --lights key.json --backend reference -o truth.exr")]
pub struct Args {
    /// glTF file (.gltf or .glb), or `demo:NAME` as `bendylights scenes` lists them
    scene: String,
    /// Light file to use in place of the scene's own lights, or of the key of a scene without any: one
    /// light or an array of them
    #[arg(long, value_name = "FILE")]
    lights: Option<PathBuf>,
    #[command(flatten)]
    picture: PictureArgs,
    /// Backend that draws the picture
    #[arg(long, value_enum, default_value = "auto", value_name = "WHO")]
    backend: PictureBackend,
    /// Texels along each side of a shadow map, 16 or more; not for the reference [default: 2048]
    #[arg(long, value_name = "N", value_parser = whole_number_parser(0..=u32::MAX))]
    shadow_resolution: Option<u32>,
    /// Distance by which shadow casters may deviate from the scene, in world units, to be fewer triangles;
    /// not for the reference [default: 0]
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    shadow_mesh_error: Option<f64>,
    /// Picture to write, as PNG or EXR by its ending; may be given more than once, for several files of one drawing
    #[arg(short, required = true, value_name = "OUT.png|OUT.exr")]
    output: Vec<PathBuf>,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum PictureBackend {
    /// wgpu if there is a GPU, native otherwise
    Auto,
    /// The CPU, in single precision, with shadow maps; needs no graphics driver
    Native,
    /// The graphics driver, of a GPU or a software one, in single precision, with shadow maps
    Wgpu,
    /// The CPU, in double precision, following light along its curve: slow, and what the others are measured against
    Reference,
}

pub fn run(args: &Args) -> Result<(), Error> {
    if args.backend != PictureBackend::Reference {
        cli::restart_without_window_system();
    }
    let shadows = shadow_settings(args)?;
    let files = args.picture.files(&args.output)?;
    let LoadedScene { scene, contents, mut notes, name } = open_scene_with_lights(&args.scene, args.lights.as_deref())?;
    let lights = instances(contents.lights);
    let request = RenderRequest::from(&args.picture);
    let whose = lights_from(&args.scene, args.lights.as_deref());
    let light = args.picture.choose_light(&args.scene, &whose, &lights)?;
    if lights.is_empty() {
        let shown = if request.fill == 0.0 { "nothing" } else { "the fill only" };
        notes.push(format!("there are no lights, so the picture shows {shown}; --lights names a light file"));
    }
    notes.extend(args.picture.warning());
    notes.extend(lights.iter().flat_map(warnings));
    let posed = scene::pose(scene, 0.0);
    if args.backend != PictureBackend::Reference {
        notes.extend(left_out(&posed.bounds(), &lights));
    }
    let (wanted, aspect) = (request.camera.as_ref(), request.framing_aspect());
    let camera = choose_camera(&args.scene, wanted, aspect, &posed.subject_bounds(), &contents.cameras)?;
    let view = request.view(camera, light, LIMITS, ViewSlot::default());
    print_notes(&notes);
    let origin = PictureOrigin { scene: name.or_else(|| Some(args.scene.clone())), ..PictureOrigin::default() };
    let pictures = PictureJob { view, lights: &lights, wanted: args.picture.wanted(light, &lights), origin };
    match args.backend {
        PictureBackend::Auto => draw(&posed, &pictures, shadows, None, &files),
        PictureBackend::Native => draw(&posed, &pictures, shadows, Some(Backend::Native), &files),
        PictureBackend::Wgpu => draw(&posed, &pictures, shadows, Some(Backend::Wgpu), &files),
        PictureBackend::Reference => {
            let reference = Reference::new(posed);
            files.write(&pictures, |view, _| trace(&reference, view, &lights).map(Pixels::Raw))
        }
    }
}

/// Returns the shadow settings, or an error if they are given for a backend without shadow maps.
fn shadow_settings(args: &Args) -> Result<ShadowSettings, Error> {
    let default = ShadowSettings::default();
    let settings = ShadowSettings {
        resolution: args.shadow_resolution.unwrap_or(default.resolution),
        mesh_error: args.shadow_mesh_error.unwrap_or(default.mesh_error),
        ..default
    };
    let given = [
        (args.shadow_resolution.is_some(), "--shadow-resolution"),
        (args.shadow_mesh_error.is_some(), "--shadow-mesh-error"),
    ];
    match (args.backend, given.into_iter().find(|(is_given, _)| *is_given)) {
        (PictureBackend::Reference, Some((_, option))) => Err(Error::NoShadowMaps(option)),
        _ => Ok(settings),
    }
}

/// Draws pictures of a scene into files, on the best device if `backend` is `None`.
pub fn draw(
    scene: &Arc<PosedScene>,
    pictures: &PictureJob,
    shadows: ShadowSettings,
    backend: Option<Backend>,
    files: &OutputPictures,
) -> Result<(), Error> {
    let mut renderer = Renderer::new(&gpu::open(backend)?)?;
    renderer.set_shadow_settings(shadows)?;
    renderer.set_scene(scene)?;
    files.write(pictures, |view, needs| {
        let bar = progress(0);
        let pixels = renderer.render_for_files(view, pictures.lights, needs, |progress| {
            bar.set_length(progress.total);
            bar.set_position(progress.done);
        });
        bar.finish_and_clear();
        Ok(pixels?)
    })
}

/// Renders with the reference, rounded to the precision of files.
fn trace(reference: &Reference, view: &View, lights: &[LightInstance]) -> Result<Picture, Error> {
    let bar = progress(view.height.into());
    let frame = reference.render(view, lights, || bar.inc(1));
    bar.finish_and_clear();
    let frame = frame?;
    let pixels = frame.pixels.iter().map(|pixel| pixel.map(|x| x as f32)).collect();
    Ok(Picture { width: frame.width, height: frame.height, pixels })
}

/// Returns notes on the lights that a picture leaves out.
pub fn left_out(reach: &SceneBounds, lights: &[LightInstance]) -> Vec<String> {
    reach
        .undrawable_of(lights.iter().map(|instance| &*instance.light))
        .iter()
        .map(|why| format!("a light is left out: {why}"))
        .collect()
}

/// Returns notes on a light that is usable but has a problem.
fn warnings(instance: &LightInstance) -> Vec<String> {
    let warnings = instance.light.tube().map(Tube::warnings).unwrap_or_default();
    let name = instance.light.light().name();
    warnings.iter().map(|warning| format!("light `{name}`: {warning}")).collect()
}

/// Loads the scene of a file, or the demo of that name, with notes on content that was left out.
pub fn open_scene(name: &str) -> Result<LoadedScene, Error> {
    if name.starts_with("http://") || name.starts_with("https://") {
        return Err(Error::RemoteScene { address: name.into() });
    }
    let Some(demo) = name.strip_prefix("demo:") else { return Ok(assets::load(Path::new(name))?) };
    let no_such = || Error::UnknownName {
        whose: "bendylights".into(),
        what: "demo scene",
        name: demo.into(),
        choices: choices(assets::DEMO_NAMES.iter().map(|(name, _)| *name)),
    };
    assets::demo(demo).ok_or_else(no_such)
}

/// Loads a scene with the lights of a file. Without a file, the scene has its own lights, or the default key if
/// it has none.
pub fn open_scene_with_lights(name: &str, lights: Option<&Path>) -> Result<LoadedScene, Error> {
    let loaded = open_scene(name)?;
    let Some(file) = lights else { return Ok(loaded.with_default_light()) };
    let lights = files::read_lights(file)?;
    Ok(LoadedScene { contents: SceneContents { lights, ..loaded.contents }, ..loaded })
}

/// Returns the file or scene that the lights come from, for messages.
pub fn lights_from(scene: &str, file: Option<&Path>) -> String {
    file.map_or(scene.into(), |file| file.display().to_string())
}

/// Numbers lights by their index.
pub fn instances(lights: Vec<Arc<CheckedLight>>) -> Vec<LightInstance> {
    let numbered = lights.into_iter().zip(0..);
    numbered.map(|(light, number)| LightInstance { id: LightId(number), light }).collect()
}
