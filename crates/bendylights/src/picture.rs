//! Options that select a picture of a scene, for `render` and `replay`.

use std::path::PathBuf;

use clap::ValueEnum;
use cli::{LIMITS, Size};
use light::{LightInstance, SceneBounds};
use protocol::{Aovs, CameraChoice, RenderRequest};
use render::{Background, WantedPicture, wanted_pictures};
use scene::{Camera, framing_camera};

use crate::error::{Error, choices, no_such_light};
use crate::picture_files::OutputPictures;
use crate::usage::whole_number_parser;

/// Options of a picture.
#[derive(clap::Args)]
pub struct PictureArgs {
    /// Camera by its name or its index from 0 [default: the first, or one that frames the scene]
    #[arg(long, value_name = "NAME|INDEX")]
    camera: Option<String>,
    /// Width and height in pixels, each at most 8192 [default: 640x360, or as many pixels in the camera's own shape]
    #[arg(long, value_name = "WxH")]
    size: Option<Size>,
    /// Samples a pixel, for beauty and visibility; 1 takes each pixel's centre, 16 or more smooth the edges
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = whole_number_parser(1..=LIMITS.max_samples))]
    samples: u32,
    /// AOVs of the picture: beauty, depth, normal, position, t, vw, direction, visibility or wireframe. An EXR
    /// holds several, with commas between, or all of them
    #[arg(long, default_value = "beauty", value_name = "NAMES|all", value_parser = Aovs::parse)]
    aov: Aovs,
    /// The light that t, vw, direction, visibility and wireframe are of [default: the first; with all AOVs each]
    #[arg(long, value_name = "NAME")]
    light: Option<String>,
    /// Background of a PNG, where nothing is seen
    #[arg(long, value_enum, default_value = "black")]
    background: BackgroundArg,
    /// Factor of the fill in the beauty: 0 leaves the lights' own radiance, 1 is as the scene has it, at most
    /// 1000000
    #[arg(long, default_value_t = 1.0, value_name = "FACTOR", value_parser = RenderRequest::parse_fill, allow_negative_numbers = true)]
    fill: f64,
    /// Stops by which a PNG of the beauty is brightened before it is tone-mapped, -32 to 32; an EXR
    /// holds the radiance itself
    #[arg(long, default_value_t = 0.0, value_name = "STOPS", value_parser = RenderRequest::parse_exposure, allow_negative_numbers = true)]
    exposure: f64,
}

/// [`Background`] as an option.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum BackgroundArg {
    /// Black
    Black,
    /// Nothing: an alpha
    Transparent,
}

impl From<&PictureArgs> for RenderRequest {
    fn from(args: &PictureArgs) -> Self {
        Self {
            camera: args.camera.clone().map(CameraChoice::Named),
            size: args.size.map(|Size { width, height }| [width, height]),
            aovs: args.aov.clone(),
            samples: args.samples,
            light: args.light.clone(),
            fill: args.fill,
            exposure: args.exposure,
        }
    }
}

impl PictureArgs {
    /// Returns true if all options have their defaults.
    pub fn is_default(&self) -> bool {
        self.background == BackgroundArg::Black && RenderRequest::from(self) == RenderRequest::default()
    }

    /// Returns a note if `--samples` has no effect on some of the AOVs.
    pub fn warning(&self) -> Option<String> {
        let single = self.aov.each().iter().filter(|aov| !aov.can_be_multisampled()).map(|aov| aov.name());
        let single: Vec<&str> = single.filter(|_| self.samples > 1).collect();
        (!single.is_empty()).then(|| {
            let aovs = single.join(", ");
            format!("one sample a pixel was taken: an average of {aovs} over an edge would mean nothing")
        })
    }

    /// Opens the files that pictures with these options can be written to.
    pub fn files(&self, paths: &[PathBuf]) -> Result<OutputPictures, Error> {
        let background = match self.background {
            BackgroundArg::Black => Background::Black,
            BackgroundArg::Transparent => Background::Transparent,
        };
        OutputPictures::create(paths, &self.aov, background)
    }

    /// Returns the pictures to draw under these lights. `light` is the index of the chosen one.
    pub fn wanted(&self, light: usize, lights: &[LightInstance]) -> Vec<WantedPicture> {
        let of_each = self.aov == Aovs::All && self.light.is_none();
        wanted_pictures(self.aov.each(), (!of_each).then_some(light), lights)
    }

    /// Returns the index of the AOVs' light among `lights`. Errors name `whose` for the owner of the lights, or
    /// `scene` if there are none.
    pub fn choose_light(&self, scene: &str, whose: &str, lights: &[LightInstance]) -> Result<usize, Error> {
        RenderRequest::from(self).check_quantities()?;
        if let (Aovs::Listed(aovs), []) = (&self.aov, lights)
            && let Some(aov) = aovs.iter().find(|aov| aov.is_per_light())
        {
            return Err(Error::NothingToShow { scene: scene.into(), aov: aov.name() });
        }
        let Some(wanted) = &self.light else { return Ok(0) };
        lights
            .iter()
            .position(|light| light.light.light().name() == *wanted)
            .ok_or_else(|| no_such_light(whose.into(), wanted, lights.iter().map(|light| light.light.light().name())))
    }
}

/// Returns the camera of that name or index among those of `scene`. Default: the first, or one that frames the
/// scene in a picture with width over height `aspect`.
pub fn choose_camera(
    scene: &str,
    wanted: Option<&CameraChoice>,
    aspect: f64,
    reach: &SceneBounds,
    cameras: &[Camera],
) -> Result<Camera, Error> {
    let wanted = match wanted {
        None => return Ok(cameras.first().cloned().unwrap_or_else(|| framing_camera(reach, aspect))),
        Some(CameraChoice::Own(camera)) => return Ok((**camera).clone().into()),
        Some(CameraChoice::Named(wanted)) => wanted,
    };
    let named = cameras.iter().find(|camera| camera.name == *wanted);
    let indexed = || cameras.get(wanted.parse::<usize>().ok()?);
    named.or_else(indexed).cloned().ok_or_else(|| Error::UnknownName {
        whose: scene.into(),
        what: "camera",
        name: wanted.into(),
        choices: choices(cameras.iter().map(|camera| camera.name.as_str())),
    })
}
