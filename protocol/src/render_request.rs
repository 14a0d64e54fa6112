//! Requests for pictures by `bendylights render` and `GET /sessions/S/render`: parameters, defaults, limits and
//! errors of both.

use std::collections::BTreeMap;

use scene::{Aov, Camera, DEFAULT_ASPECT, UnknownAov, View, ViewSlot};
use serde::Deserialize;
use serde_json::Value;
use thiserror::Error;

use crate::ErrorCode;
use crate::error::{excerpt, from_json};

/// Limits of a requested picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RenderLimits {
    /// Maximum pixels a side.
    pub max_side: u32,
    /// Maximum samples per pixel.
    pub max_samples: u32,
}

impl RenderLimits {
    /// Limits over HTTP, where other clients wait.
    pub const HTTP: Self = Self { max_side: 4096, max_samples: 64 };
    /// Limits on the command line. The maximum side is that of the largest texture within WebGPU's default
    /// limits.
    pub const COMMAND_LINE: Self = Self { max_side: 8192, max_samples: 4096 };

    /// Parses width and height in pixels: `1920x1080`.
    pub fn parse_size(self, text: &str) -> Result<[u32; 2], RenderRefusal> {
        let side = |text: &str| text.parse().ok().filter(|side: &u32| *side > 0 && !text.starts_with('+'));
        let sides = text.split_once('x').and_then(|(width, height)| Some([side(width)?, side(height)?]));
        let max_side = self.max_side;
        let unread = || RenderRefusal::Size { text: text.chars().take(20).collect(), max_side };
        self.check_size(sides.ok_or_else(unread)?)
    }

    /// Returns the size, or an error if a side is too long.
    pub fn check_size(self, size: [u32; 2]) -> Result<[u32; 2], RenderRefusal> {
        let max_side = self.max_side;
        if size.iter().any(|side| *side > max_side) {
            return Err(RenderRefusal::TooLarge { max_side });
        }
        Ok(size)
    }

    /// Returns the number of samples per pixel, or an error if it is out of range.
    pub fn check_samples(self, samples: u32) -> Result<u32, RenderRefusal> {
        let max_samples = self.max_samples;
        match samples {
            0 => Err(RenderRefusal::NoSamples { max_samples }),
            _ if samples > max_samples => Err(RenderRefusal::TooManySamples { max_samples }),
            _ => Ok(samples),
        }
    }
}

/// Camera of a requested picture.
#[derive(Clone, Debug, PartialEq)]
pub enum CameraChoice {
    /// Existing camera, by its name or id.
    Named(String),
    /// Camera given in the request.
    Own(Box<crate::Camera>),
}

/// Request for a picture. Names of cameras and lights are resolved later, in the scene or document.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderRequest {
    /// Camera. Default: the first, or one that frames the scene.
    pub camera: Option<CameraChoice>,
    /// Width and height in pixels. Default: the camera's aspect ratio, with about as many pixels as 640x360.
    pub size: Option<[u32; 2]>,
    pub aovs: Aovs,
    /// Samples per pixel.
    pub samples: u32,
    /// Light of the AOVs that belong to a light, by name or id. Default: the first light, or each light for
    /// `all`.
    pub light: Option<String>,
    /// Factor of the scene's fill light in the beauty.
    pub fill: f64,
    /// Stops by which a PNG of the beauty is brightened. An EXR holds the radiance itself.
    pub exposure: f64,
}

impl Default for RenderRequest {
    fn default() -> Self {
        let aovs = Aovs::Listed(vec![Aov::Beauty]);
        Self { camera: None, size: None, aovs, samples: 1, light: None, fill: 1.0, exposure: 0.0 }
    }
}

/// Requested AOVs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Aovs {
    /// List of AOVs, without duplicates and not empty.
    Listed(Vec<Aov>),
    /// All AOVs of a camera. Those that belong to a light are drawn for each light.
    All,
}

impl Aovs {
    /// Text that requests all AOVs.
    pub const ALL: &str = "all";

    /// Parses names separated by commas, or `all`.
    pub fn parse(text: &str) -> Result<Self, UnknownAov> {
        if text == Self::ALL {
            return Ok(Self::All);
        }
        let mut aovs = Vec::new();
        for name in text.split(',') {
            let aov = name.trim().parse()?;
            if !aovs.contains(&aov) {
                aovs.push(aov);
            }
        }
        Ok(Self::Listed(aovs))
    }

    /// Returns the requested AOVs, in order.
    pub fn each(&self) -> &[Aov] {
        match self {
            Self::Listed(aovs) => aovs,
            Self::All => {
                &[Aov::Beauty, Aov::Depth, Aov::Normal, Aov::Position, Aov::T, Aov::Vw, Aov::Direction, Aov::Visibility]
            }
        }
    }

    /// Returns the names, separated by commas.
    pub fn names(&self) -> String {
        let names: Vec<&str> = self.each().iter().map(|aov| aov.name()).collect();
        names.join(", ")
    }
}

impl RenderRequest {
    /// Returns the factor of the fill light, or an error if it is out of range.
    pub fn check_fill(factor: f64) -> Result<f64, RenderRefusal> {
        if View::FILL_RANGE.contains(&factor) { Ok(factor) } else { Err(RenderRefusal::Fill(factor.to_string())) }
    }

    /// Parses and checks the factor of the fill light.
    pub fn parse_fill(text: &str) -> Result<f64, RenderRefusal> {
        let refused = || RenderRefusal::Fill(text.chars().take(20).collect());
        Self::check_fill(text.parse().map_err(|_| refused())?)
    }

    /// Returns the exposure in stops, or an error if it is out of range.
    pub fn check_exposure(stops: f64) -> Result<f64, RenderRefusal> {
        if View::EXPOSURE_RANGE.contains(&stops) { Ok(stops) } else { Err(RenderRefusal::Exposure(stops.to_string())) }
    }

    /// Parses and checks the exposure in stops.
    pub fn parse_exposure(text: &str) -> Result<f64, RenderRefusal> {
        let refused = || RenderRefusal::Exposure(text.chars().take(20).collect());
        Self::check_exposure(text.parse().map_err(|_| refused())?)
    }

    /// Returns width over height of the picture, for a camera that is made to frame the scene.
    pub fn framing_aspect(&self) -> f64 {
        self.size.map_or(DEFAULT_ASPECT, |[width, height]| f64::from(width) / f64::from(height))
    }

    /// Returns the view of the first AOV. `light` is the index of the AOV's light.
    pub fn view(&self, camera: Camera, light: usize, limits: RenderLimits, slot: ViewSlot) -> View {
        let size = self.size.unwrap_or_else(|| camera.projection.default_size(limits.max_side));
        let Self { samples, fill, exposure, .. } = *self;
        let aov = self.aovs.each()[0];
        View { samples, aov, light, fill, exposure, slot, ..View::beauty(camera, size) }
    }

    /// Returns an error if a light is given but no AOV belongs to a light, or if a wireframe is requested
    /// beside AOVs of the camera.
    pub fn check_quantities(&self) -> Result<(), RenderRefusal> {
        let aovs = self.aovs.each();
        if aovs.len() > 1 && aovs.contains(&Aov::Wireframe) {
            return Err(RenderRefusal::NotOfCamera);
        }
        if self.light.is_some() && !self.aovs.each().iter().any(|aov| aov.is_per_light()) {
            return Err(RenderRefusal::OfNoLight(self.aovs.names()));
        }
        Ok(())
    }
}

/// Query parameters of `GET /sessions/S/render`, unparsed.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RenderParameters {
    /// Name, id, or camera in JSON.
    pub camera: Option<String>,
    /// Text for [`RenderLimits::parse_size`].
    pub size: Option<String>,
    /// Text for [`Aovs::parse`].
    pub aov: Option<String>,
    /// Value of [`RenderRequest::samples`].
    pub samples: Option<u32>,
    /// Value of [`RenderRequest::light`].
    pub light: Option<String>,
    /// Value of [`RenderRequest::fill`].
    pub fill: Option<f64>,
    /// Value of [`RenderRequest::exposure`].
    pub exposure: Option<f64>,
    /// Sequence number of the record after which the document is drawn. Default: the latest.
    pub at: Option<u64>,
    /// Ids or names of the lights that shine, as a JSON array or separated by commas. Default: all lights.
    pub lights: Option<String>,
    /// Parameters to set for this picture only: a JSON object of addresses and values.
    pub set: Option<String>,
    /// Background of a PNG.
    #[serde(default)]
    pub background: RenderBackground,
    /// File formats: `png`, `exr`, or both separated by a comma.
    pub format: Option<String>,
}

/// Background of a PNG, where no surface is visible.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum RenderBackground {
    #[default]
    Black,
    Transparent,
}

/// File format of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RenderFormat {
    /// Tone-mapped picture for people.
    Png,
    /// Linear values.
    Exr,
}

impl RenderParameters {
    /// Parses and checks the request, within the limits of HTTP.
    pub fn request(&self) -> Result<RenderRequest, RenderRefusal> {
        let (limits, default) = (RenderLimits::HTTP, RenderRequest::default());
        Ok(RenderRequest {
            size: self.size.as_deref().map(|size| limits.parse_size(size)).transpose()?,
            samples: self.samples.map_or(Ok(default.samples), |samples| limits.check_samples(samples))?,
            fill: self.fill.map_or(Ok(default.fill), RenderRequest::check_fill)?,
            exposure: self.exposure.map_or(Ok(default.exposure), RenderRequest::check_exposure)?,
            aovs: self.aov.as_deref().map_or(Ok(default.aovs), Aovs::parse)?,
            camera: self.camera.as_deref().map(choose_camera).transpose()?,
            light: self.light.clone(),
        })
    }

    /// Returns the requested file formats, without duplicates and not empty.
    pub fn formats(&self) -> Result<Vec<RenderFormat>, RenderRefusal> {
        let mut formats = Vec::new();
        for name in self.format.as_deref().unwrap_or("png").split(',') {
            let format = match name.trim() {
                "png" => RenderFormat::Png,
                "exr" => RenderFormat::Exr,
                other => return Err(RenderRefusal::Format(excerpt(other))),
            };
            if !formats.contains(&format) {
                formats.push(format);
            }
        }
        Ok(formats)
    }

    /// Returns the names or ids of the lights that shine, or `None` if all do.
    pub fn lights(&self) -> Result<Option<Vec<String>>, RenderRefusal> {
        let Some(text) = self.lights.as_deref() else { return Ok(None) };
        if text.trim_start().starts_with('[') {
            return json_parameter("lights", text).map(Some);
        }
        let names = text.split(',').map(str::trim).filter(|name| !name.is_empty());
        Ok(Some(names.map(str::to_owned).collect()))
    }

    /// Returns the parameters to set for this picture only, by address.
    pub fn set(&self) -> Result<BTreeMap<String, Value>, RenderRefusal> {
        self.set.as_deref().map_or_else(|| Ok(BTreeMap::new()), |text| json_parameter("set", text))
    }
}

fn choose_camera(text: &str) -> Result<CameraChoice, RenderRefusal> {
    if text.trim_start().starts_with('{') {
        return json_parameter("camera", text).map(|camera| CameraChoice::Own(Box::new(camera)));
    }
    Ok(CameraChoice::Named(text.into()))
}

/// Parses the JSON of parameter `what`.
fn json_parameter<T: serde::de::DeserializeOwned>(what: &'static str, text: &str) -> Result<T, RenderRefusal> {
    from_json(text).map_err(|why| RenderRefusal::Json { what, why: why.to_string() })
}

/// Error of a requested picture.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum RenderRefusal {
    /// The size cannot be parsed.
    #[error("the size is `{text}`: write it as WIDTHxHEIGHT in pixels, each from 1 to {max_side}")]
    Size {
        /// Start of the given text.
        text: String,
        /// Maximum pixels a side.
        max_side: u32,
    },
    /// A side is too long.
    #[error("each side of a picture has 1 to {max_side} pixels: make it smaller")]
    TooLarge {
        /// Maximum pixels a side.
        max_side: u32,
    },
    /// The number of samples is 0.
    #[error("a pixel has 1 to {max_samples} samples: ask for more than 0")]
    NoSamples {
        /// Maximum samples per pixel.
        max_samples: u32,
    },
    /// The number of samples is too large.
    #[error("a pixel has 1 to {max_samples} samples: ask for fewer")]
    TooManySamples {
        /// Maximum samples per pixel.
        max_samples: u32,
    },
    /// The factor of the fill light is not a number in its range.
    #[error("the fill's factor is `{0}`: give a number from {start} to {end}", start = View::FILL_RANGE.start(), end = View::FILL_RANGE.end())]
    Fill(String),
    /// The exposure is not a number in its range.
    #[error("the exposure is `{0}`: give a number of stops from {start} to {end}", start = View::EXPOSURE_RANGE.start(), end = View::EXPOSURE_RANGE.end())]
    Exposure(String),
    /// A light is given, but no requested AOV belongs to a light.
    #[error("{0} is not of one light: leave `light` out, or ask for t, vw, direction, visibility or wireframe")]
    OfNoLight(String),
    /// A wireframe is requested beside other AOVs.
    #[error("a wireframe is the light's view and not the camera's: ask for it alone")]
    NotOfCamera,
    /// The file format is unknown.
    #[error("the format is `{0}`: give png, exr, or png,exr")]
    Format(String),
    /// A parameter is not the expected JSON.
    #[error("`{what}`: {why}")]
    Json {
        /// Name of the parameter.
        what: &'static str,
        why: String,
    },
    /// The pictures exceed the memory of one request.
    #[error(
        "the pictures have more than {limit_mib} MiB before they are compressed: ask for fewer pixels, AOVs or lights"
    )]
    TooMuch { limit_mib: usize },
    /// The AOV is unknown.
    #[error(transparent)]
    Aov(#[from] UnknownAov),
}

impl RenderRefusal {
    /// Returns the code for programs.
    pub fn code(&self) -> ErrorCode {
        match self {
            Self::Size { .. }
            | Self::NoSamples { .. }
            | Self::Fill(_)
            | Self::Exposure(_)
            | Self::OfNoLight(_)
            | Self::NotOfCamera
            | Self::Format(_)
            | Self::Json { .. } => ErrorCode::BadMessage,
            Self::TooLarge { .. } | Self::TooManySamples { .. } | Self::TooMuch { .. } => ErrorCode::TooLarge,
            Self::Aov(_) => ErrorCode::Render,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each caller has its own limits. The message of a refusal names the limit of its caller.
    #[test]
    fn limits_are_held_and_named() {
        for limits in [RenderLimits::HTTP, RenderLimits::COMMAND_LINE] {
            let RenderLimits { max_side, max_samples } = limits;
            assert_eq!(limits.parse_size(&format!("{max_side}x1")), Ok([max_side, 1]));
            for text in [format!("{}x1", max_side + 1), "0x1".into(), "+1x1".into(), "640".into()] {
                let refusal = limits.parse_size(&text).expect_err(&text);
                assert!(refusal.to_string().contains(&format!("1 to {max_side}")), "{refusal}");
            }
            assert_eq!(limits.check_samples(max_samples), Ok(max_samples));
            for samples in [0, max_samples + 1] {
                let refusal = limits.check_samples(samples).expect_err("refused");
                assert!(refusal.to_string().contains(&format!("1 to {max_samples}")), "{refusal}");
            }
        }
        for factor in ["-1", "NaN", "1000001", "none"] {
            let refusal = RenderRequest::parse_fill(factor).expect_err(factor);
            assert!(refusal.to_string().contains("from 0 to 1000000"), "{refusal}");
        }
        for stops in ["-32.5", "NaN", "33", "inf", "bright"] {
            let refusal = RenderRequest::parse_exposure(stops).expect_err(stops);
            assert!(refusal.to_string().contains("from -32 to 32"), "{refusal}");
        }
    }

    #[test]
    fn parameters_left_out_have_their_defaults() {
        assert_eq!(RenderParameters::default().request(), Ok(RenderRequest::default()));
    }
}
