//! `bendylights render`: a scene as a picture.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use assets::Loaded;
use clap::ValueEnum;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use cli::{LIMITS, Output, Size, progress, say};
use document::SceneContents;
use light::{CheckedLight, LightId, LightInstance, Reach, Tube};
use protocol::RenderRequest;
use reference::Reference;
use render::{Aov, Picture, PictureFormat, Renderer, ShadowSettings, View, ViewSlot};
use scene::{Camera, PosedScene, framing_camera};

use crate::error::Error;
use crate::usage::whole;
use crate::{files, gpu};

#[derive(clap::Args)]
#[command(after_help = "\
AOVs, what a picture shows:
  beauty      the lit scene, with a fill that keeps what no light reaches readable; --fill 0 takes it away
  depth       distance from the camera's plane, in world units
  normal      shading normal in the world
  t           place along the light's curve, 0 at its source to the number of segments
  vw          place across the light's tube, in radii
  direction   direction in the world from the surface to where the light comes from
  visibility  1 where the light reaches, 0 in its shadow
  wireframe   the triangles of the light's shadow map as the light sees them, bent straight; the camera is not used

EXR holds the linear values themselves. In PNG the beauty is tone-mapped, after --exposure, and the others are made readable: near is
bright, directions and normals are shown as (x + 1) / 2, t as a ramp with a line at each joint, (v, w) by hue and
distance from the curve; a wireframe is drawn in white over t's ramp, darker outside the light.

Examples:
  bendylights render demo:vases -o vases.png
  bendylights render room.glb --lights key.json --camera 0 --size 1920x1080 --samples 64 -o room.exr
  bendylights render room.glb --lights key.json --fill 0 -o key-alone.exr
  bendylights render room.glb --lights key.json --aov visibility --light key -o shadow.png
  bendylights render room.glb --lights key.json --backend reference -o truth.exr")]
pub struct Args {
    /// glTF file (.gltf or .glb), or `demo:NAME` as `bendylights scenes` lists them
    scene: String,
    /// Light file to use in place of the scene's own lights, or of the key of a scene without any: one light or an array of them
    #[arg(long, value_name = "FILE")]
    lights: Option<PathBuf>,
    /// Camera by its name or its index from 0 [default: the first, or one that frames the scene]
    #[arg(long, value_name = "NAME|INDEX")]
    camera: Option<String>,
    /// Width and height in pixels, each at most 8192 [default: 640x360, or as many pixels in the camera's own shape]
    #[arg(long, value_name = "WxH")]
    size: Option<Size>,
    /// Samples a pixel, for beauty and visibility; 1 takes each pixel's centre, 16 or more smooth the edges
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = whole(1..=LIMITS.max_samples))]
    samples: u32,
    /// What the picture shows
    #[arg(long, default_value = "beauty", value_name = "NAME", value_parser = aov_names())]
    aov: Aov,
    /// The light that t, vw, direction, visibility and wireframe are of [default: the first]
    #[arg(long, value_name = "NAME")]
    light: Option<String>,
    /// How much of the fill the beauty has: 0 leaves the lights' own radiance, 1 is as the scene has it, at most 1000000
    #[arg(long, default_value_t = 1.0, value_name = "FACTOR", value_parser = RenderRequest::parse_fill, allow_negative_numbers = true)]
    fill: f64,
    /// Stops by which a PNG of the beauty is brightened before it is tone-mapped, -32 to 32; an EXR holds the radiance itself
    #[arg(long, default_value_t = 0.0, value_name = "STOPS", value_parser = RenderRequest::parse_exposure, allow_negative_numbers = true)]
    exposure: f64,
    /// What draws the picture
    #[arg(long, value_enum, default_value = "gpu")]
    backend: Backend,
    /// Texels along each side of a shadow map, 16 or more; backend gpu only [default: 2048]
    #[arg(long, value_name = "N", value_parser = whole(0..=u32::MAX))]
    shadow_resolution: Option<u32>,
    /// How far what casts shadows may stray from the scene, in world units, to be fewer triangles; backend gpu only [default: 0]
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    shadow_mesh_error: Option<f64>,
    /// Picture to write, as PNG or EXR by its ending
    #[arg(short, value_name = "OUT.png|OUT.exr")]
    output: PathBuf,
}

#[derive(Clone, Copy, ValueEnum)]
enum Backend {
    /// The graphics device, in single precision, with shadow maps
    Gpu,
    /// The processor, in double precision, following light along its curve: slow, and what the GPU is measured against
    Reference,
}

fn aov_names() -> impl TypedValueParser<Value = Aov> {
    PossibleValuesParser::new(Aov::NAMES).try_map(|name| name.parse::<Aov>())
}

/// The picture format that the file's name says.
pub fn picture_format(path: &Path) -> Result<PictureFormat, Error> {
    match path.extension().unwrap_or_default().to_ascii_lowercase().to_str() {
        Some("png") => Ok(PictureFormat::Png),
        Some("exr") => Ok(PictureFormat::Exr),
        _ => Err(Error::UnknownFormat(path.into())),
    }
}

impl From<&Args> for RenderRequest {
    fn from(args: &Args) -> Self {
        Self {
            camera: args.camera.clone(),
            size: args.size.map(|Size { width, height }| [width, height]),
            aov: args.aov,
            samples: args.samples,
            light: args.light.clone(),
            fill: args.fill,
            exposure: args.exposure,
        }
    }
}

pub fn run(args: &Args) -> Result<(), Error> {
    if let Backend::Gpu = args.backend {
        cli::without_window_system();
    }
    let shadows = shadow_settings(args)?;
    let format = picture_format(&args.output)?;
    let output = Output::create(&args.output)?;
    let Loaded { scene, contents, mut notes, .. } = open_lit(&args.scene, args.lights.as_deref())?;
    let lights = instances(contents.lights);
    if lights.is_empty() && args.aov.is_of_light() {
        return Err(Error::NothingToShow { scene: args.scene.clone(), aov: args.aov.name() });
    }
    if lights.is_empty() {
        let shown = if args.fill == 0.0 { "nothing" } else { "the fill only" };
        notes.push(format!("there are no lights, so the picture shows {shown}; --lights names a light file"));
    }
    if args.samples > 1 && !args.aov.takes_samples() {
        let aov = args.aov.name();
        notes.push(format!(
            "one sample a pixel was taken: an average of {aov} over an edge would mean nothing"
        ));
    }
    notes.extend(lights.iter().flat_map(warnings));
    let posed = scene::pose(scene);
    if matches!(args.backend, Backend::Gpu) {
        notes.extend(left_out(&posed.reach(), &lights));
    }
    let request = RenderRequest::from(args);
    let (wanted, aspect) = (request.camera.as_deref(), request.framing_aspect());
    let camera = choose_camera(&args.scene, wanted, aspect, (&posed.reach(), &contents.cameras))?;
    let view = request.view(camera, choose_light(args, &lights)?, LIMITS, ViewSlot::default());
    for note in &notes {
        say(&format!("note: {note}"));
    }
    let picture = match args.backend {
        Backend::Gpu => draw(&posed, &view, &lights, shadows, format)?,
        Backend::Reference => trace(posed, &view, &lights)?.into_file(&view, &lights, format)?,
    };
    Ok(output.write(&picture)?)
}

/// What is asked of shadow maps, where the backend has them.
fn shadow_settings(args: &Args) -> Result<ShadowSettings, Error> {
    let default = ShadowSettings::default();
    let settings = ShadowSettings {
        resolution: args.shadow_resolution.unwrap_or(default.resolution),
        mesh_error: args.shadow_mesh_error.unwrap_or(default.mesh_error),
        ..default
    };
    match args.backend {
        Backend::Reference if args.shadow_resolution.is_some() => {
            Err(Error::NoShadowMaps("--shadow-resolution"))
        }
        Backend::Reference if args.shadow_mesh_error.is_some() => {
            Err(Error::NoShadowMaps("--shadow-mesh-error"))
        }
        _ => Ok(settings),
    }
}

fn draw(
    scene: &Arc<PosedScene>,
    view: &View,
    lights: &[LightInstance],
    shadows: ShadowSettings,
    format: PictureFormat,
) -> Result<Vec<u8>, Error> {
    let mut renderer = Renderer::new(gpu::open()?)?;
    renderer.set_shadow_settings(shadows)?;
    renderer.set_scene(scene)?;
    let bar = progress(0);
    let picture = renderer.render_file(view, lights, format, |progress| {
        bar.set_length(progress.of);
        bar.set_position(progress.done);
    });
    bar.finish_and_clear();
    Ok(picture?)
}

/// The reference's picture, rounded to what files hold.
fn trace(scene: Arc<PosedScene>, view: &View, lights: &[LightInstance]) -> Result<Picture, Error> {
    let bar = progress(view.height.into());
    let frame = Reference::new(scene).render(view, lights, || bar.inc(1));
    bar.finish_and_clear();
    let frame = frame?;
    let pixels = frame.pixels.iter().map(|pixel| pixel.map(|x| x as f32)).collect();
    Ok(Picture { width: frame.width, height: frame.height, pixels })
}

/// The lights that a picture is made without.
pub fn left_out(reach: &Reach, lights: &[LightInstance]) -> Vec<String> {
    reach
        .left_out(lights.iter().map(|instance| &*instance.light))
        .iter()
        .map(|why| format!("a light is left out: {why}"))
        .collect()
}

/// What should be known of a light that is usable all the same.
fn warnings(instance: &LightInstance) -> Vec<String> {
    let warnings = instance.light.tube().map(Tube::warnings).unwrap_or_default();
    let name = instance.light.light().name();
    warnings.iter().map(|warning| format!("light `{name}`: {warning}")).collect()
}

/// The scene of a file, or the demo of that name, with notes of what was left out.
pub fn open_scene(name: &str) -> Result<Loaded, Error> {
    if name.starts_with("http://") || name.starts_with("https://") {
        return Err(Error::RemoteScene { address: name.into() });
    }
    let Some(demo) = name.strip_prefix("demo:") else { return Ok(assets::load(Path::new(name))?) };
    let no_such = || Error::NoSuch {
        whose: "bendylights".into(),
        what: "demo scene",
        name: demo.into(),
        choices: choices(assets::DEMO_NAMES.iter().map(|(name, _)| *name)),
    };
    assets::demo(demo).ok_or_else(no_such)
}

/// The same with the lights of a file in place of its own, or with its own or the key that a scene without any gets.
pub fn open_lit(name: &str, lights: Option<&Path>) -> Result<Loaded, Error> {
    let loaded = open_scene(name)?;
    let Some(file) = lights else { return Ok(loaded.lit()) };
    let lights = files::read_lights(file)?;
    Ok(Loaded { contents: SceneContents { lights, ..loaded.contents }, ..loaded })
}

/// Lights as pictures take them, by their index.
pub fn instances(lights: Vec<Arc<CheckedLight>>) -> Vec<LightInstance> {
    let numbered = lights.into_iter().zip(0..);
    numbered.map(|(light, number)| LightInstance { id: LightId(number), light }).collect()
}

/// The camera of that name or index among those of `scene`; by default the first, or one that frames it in a picture of that
/// width over height.
pub fn choose_camera(
    scene: &str,
    wanted: Option<&str>,
    aspect: f64,
    (reach, cameras): (&Reach, &[Camera]),
) -> Result<Camera, Error> {
    let Some(wanted) = wanted else {
        return Ok(cameras.first().cloned().unwrap_or_else(|| framing_camera(reach, aspect)));
    };
    let named = cameras.iter().find(|camera| camera.name == wanted);
    let indexed = || cameras.get(wanted.parse::<usize>().ok()?);
    named.or_else(indexed).cloned().ok_or_else(|| Error::NoSuch {
        whose: scene.into(),
        what: "camera",
        name: wanted.into(),
        choices: choices(cameras.iter().map(|camera| camera.name.as_str())),
    })
}

fn choose_light(args: &Args, lights: &[LightInstance]) -> Result<usize, Error> {
    let Some(wanted) = &args.light else { return Ok(0) };
    lights.iter().position(|light| light.light.light().name() == *wanted).ok_or_else(|| {
        let whose = args.lights.as_ref().map_or(args.scene.clone(), |file| file.display().to_string());
        no_such_light(whose, wanted, lights.iter().map(|light| light.light.light().name()))
    })
}

/// That a scene or a file has no light of that name, and which it has.
pub fn no_such_light<'a>(whose: String, name: &str, names: impl Iterator<Item = &'a str>) -> Error {
    Error::NoSuch { whose, what: "light", name: name.into(), choices: choices(names) }
}

/// What there is to choose from, as the end of a sentence.
pub fn choices<'a>(names: impl Iterator<Item = &'a str>) -> String {
    const SHOWN: usize = 12;
    let names: Vec<_> = names.map(|name| format!("`{name}`")).collect();
    match names.len() {
        0 => "it has none".into(),
        n if n > SHOWN => format!("choose one of {} and {} more", names[..SHOWN].join(", "), n - SHOWN),
        _ => format!("choose one of {}", names.join(", ")),
    }
}
