//! Which picture of a scene is wanted: what `render` and `replay` are told alike.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use cli::{LIMITS, Size};
use light::{LightInstance, Reach};
use protocol::RenderRequest;
use render::Aov;
use scene::{Camera, framing_camera};

use crate::error::{Error, choices, no_such_light};
use crate::usage::whole;

/// The options.
#[derive(clap::Args)]
pub struct PictureArgs {
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
}

fn aov_names() -> impl TypedValueParser<Value = Aov> {
    PossibleValuesParser::new(Aov::NAMES).try_map(|name| name.parse::<Aov>())
}

impl From<&PictureArgs> for RenderRequest {
    fn from(args: &PictureArgs) -> Self {
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

impl PictureArgs {
    /// Whether nothing is asked for but what comes unasked.
    pub fn is_default(&self) -> bool {
        let Self { camera, size, samples, aov, light, fill, exposure } = self;
        camera.is_none()
            && size.is_none()
            && light.is_none()
            && (*samples, *aov, *fill, *exposure) == (1, Aov::Beauty, 1.0, 0.0)
    }

    /// What is taken in place of what was asked for.
    pub fn warning(&self) -> Option<String> {
        let aov = self.aov.name();
        (self.samples > 1 && !self.aov.takes_samples()).then(|| {
            format!("one sample a pixel was taken: an average of {aov} over an edge would mean nothing")
        })
    }

    /// The index of the light that the picture is of, among those of `whose`. `scene` is what has none.
    pub fn choose_light(&self, scene: &str, whose: &str, lights: &[LightInstance]) -> Result<usize, Error> {
        if lights.is_empty() && self.aov.is_of_light() {
            return Err(Error::NothingToShow { scene: scene.into(), aov: self.aov.name() });
        }
        let Some(wanted) = &self.light else { return Ok(0) };
        lights.iter().position(|light| light.light.light().name() == *wanted).ok_or_else(|| {
            no_such_light(whose.into(), wanted, lights.iter().map(|light| light.light.light().name()))
        })
    }
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
