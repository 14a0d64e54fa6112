//! `bendylights-studies drags`: drags that reach the cursor, in comparison with a slow solver.

use std::path::{Path, PathBuf};

use assets::LoadedScene;
use bench::drag::{TrialKind, TrialScene};
use cli::{OutputFile, Size, print_note, progress};
use studies::StudyError;
use studies::drags::{self, DragStudyOptions, DragStudyReport, ReportCell};

use super::print_json;

/// The demo, and scenes of other authors beside the checkout.
const SCENES: [&str; 4] = [
    "demo:vases",
    "../shared/assets/scenes/vases_bowl.glb",
    "../shared/assets/scenes/bedroom.glb",
    "../shared/assets/scenes/outdoor.glb",
];

#[derive(clap::Args)]
#[command(after_help = "\
Makes random drags in random lights over each scene: of shadows, hotspots, highlights and the sides of surfaces that are
turned most to the light; of whole lights (rigid) and of control points (deforming); small ones, under a tenth of the
picture's width, and large ones. Each begins on that feature as it is seen and ends on a surface that is seen and lies in the
light. All are given to a slow solver with dozens of restarts too, which shares nothing with the product's: what it lands was
feasible.

Prints JSON, and a table on standard error; for each scene and kind, and for all scenes together:
  landed            drags that say that they landed
  limited, refused  the others, by limit and reason
  missed, missedBy  those that did not land and are feasible, and by limit and reason
  landedOfFeasible  landed, of landed and missed
  slowOfLanded      of those that landed, the share that the slow solver landed too
  wrong             those that say that they landed, and by the reference's pick, its shadow and the light's `locate` did not
  broken            hard pins that do not hold, by the reference's visibility and the light's `locate`
  infeasible        drags that land without their pins, and that neither solver lands with them
  infeasibleNamed   of these, the ones that the product says a pin limits
  worstOff          how far the equation is off at the cursor, at most: pixels of shadow and hotspot, else degrees
  p50Ms, p95Ms      a drag's time, with its picks

Examples:
  bendylights-studies drags --drags 100 --failures failures
  bendylights drag demo:vases --lights failures/NAME.light.json failures/NAME.drags.json     one of them again
  bendylights-studies drags --pins 3")]
pub struct Args {
    /// glTF files, or `demo:NAME` [default: the demo, and three in ../shared/assets/scenes as far as they are there]
    scenes: Vec<String>,
    /// Drags of each of the sixteen kinds in each scene
    #[arg(long, default_value_t = 50, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    drags: u32,
    /// Another number, other drags
    #[arg(long, default_value_t = 1, value_name = "S")]
    seed: u64,
    /// Pins of each drag, of random kinds, half of them hard; they hold as it begins
    #[arg(long, default_value_t = 0, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=16))]
    pins: u32,
    /// Width and height of the picture in pixels
    #[arg(long, default_value = "686x382", value_name = "WxH")]
    size: Size,
    /// Folder for drags that did not land though they could: light file, drag file, and a light that lands
    #[arg(long, value_name = "DIR")]
    failures: Option<PathBuf>,
}

pub fn run(args: &Args) -> Result<(), StudyError> {
    cli::make_folder(args.failures.as_deref())?;
    let defaults = || SCENES.map(String::from).to_vec();
    let scenes = if args.scenes.is_empty() { defaults() } else { args.scenes.clone() };
    let options = DragStudyOptions { drags: args.drags as usize, seed: args.seed, pins: args.pins as usize };
    let bar = progress((scenes.len() * TrialKind::all().count() * options.drags) as u64);
    let (mut cells, mut all) = (Vec::new(), Vec::new());
    for scene in &scenes {
        let Some(LoadedScene { scene: surfaces, contents, .. }) = open(scene)? else {
            bar.suspend(|| print_note(&format!("skipped {scene}: there is no such scene here")));
            continue;
        };
        bar.set_message(scene.clone());
        let stage = TrialScene::new(scene, surfaces, &contents.cameras, [args.size.width, args.size.height]);
        let (outcomes, failures) = drags::run(&stage, options, || bar.inc(1));
        if let Some(folder) = &args.failures {
            failures.iter().try_for_each(|failure| write(folder, failure))?;
        }
        cells.extend(TrialKind::all().map(|kind| ReportCell::of(&drags::file_name_of(scene), kind, outcomes.iter())));
        all.extend(outcomes);
    }
    bar.finish_and_clear();
    cells.extend(TrialKind::all().map(|kind| ReportCell::of("all", kind, all.iter())));
    let report = DragStudyReport { drags: options.drags, seed: options.seed, pins: options.pins, cells };
    report.table().lines().for_each(print_note);
    Ok(print_json(&report)?)
}

/// Opens a scene. Returns `None` if there is no such file.
fn open(name: &str) -> Result<Option<LoadedScene>, StudyError> {
    if let Some(demo) = name.strip_prefix("demo:") {
        return Ok(assets::demo(demo));
    }
    let file = Path::new(name);
    Ok(if file.is_file() { Some(assets::load(file)?) } else { None })
}

fn write(folder: &Path, failure: &drags::DragFailure) -> Result<(), StudyError> {
    let file = |kind: &str, text: String| -> Result<(), StudyError> {
        Ok(OutputFile::create(&folder.join(format!("{}.{kind}.json", failure.name)))?.write(text.as_bytes())?)
    };
    file("light", failure.light.clone())?;
    file("drags", failure.drags.to_string())?;
    file("found", serde_json::to_string_pretty(&failure.found).expect("plain data with string keys"))
}
