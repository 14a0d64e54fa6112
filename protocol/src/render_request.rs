//! What a picture is asked to be, by `bendylights render` and by `GET /sessions/S/render`: parameters, defaults, limits and
//! refusals of both.

use std::collections::BTreeMap;

use scene::{Aov, Camera, DEFAULT_ASPECT, UnknownAov, View, ViewSlot};
use serde::Deserialize;
use serde_json::Value;
use thiserror::Error;

use crate::ErrorCode;
use crate::error::excerpt;

/// How large a picture may be asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RenderLimits {
    /// Pixels along a side.
    pub max_side: u32,
    /// Samples a pixel.
    pub max_samples: u32,
}

impl RenderLimits {
    /// Over HTTP, where others wait.
    pub const HTTP: Self = Self { max_side: 4096, max_samples: 64 };
    /// On the command line. The side is that of the largest texture that every GPU of WebGPU's default limits holds.
    pub const COMMAND_LINE: Self = Self { max_side: 8192, max_samples: 4096 };

    /// Reads width and height in pixels: `1920x1080`.
    pub fn parse_size(self, text: &str) -> Result<[u32; 2], RenderRefusal> {
        let side = |text: &str| text.parse().ok().filter(|side: &u32| *side > 0 && !text.starts_with('+'));
        let sides = text.split_once('x').and_then(|(width, height)| Some([side(width)?, side(height)?]));
        let max_side = self.max_side;
        let unread = || RenderRefusal::Size { text: text.chars().take(20).collect(), max_side };
        self.check_size(sides.ok_or_else(unread)?)
    }

    /// Checks that neither side is too long.
    pub fn check_size(self, size: [u32; 2]) -> Result<[u32; 2], RenderRefusal> {
        let max_side = self.max_side;
        if size.iter().any(|side| *side > max_side) {
            return Err(RenderRefusal::TooLarge { max_side });
        }
        Ok(size)
    }

    /// Checks a number of samples a pixel.
    pub fn check_samples(self, samples: u32) -> Result<u32, RenderRefusal> {
        let max_samples = self.max_samples;
        match samples {
            0 => Err(RenderRefusal::NoSamples { max_samples }),
            _ if samples > max_samples => Err(RenderRefusal::TooManySamples { max_samples }),
            _ => Ok(samples),
        }
    }
}

/// A camera that a picture is asked of.
#[derive(Clone, Debug, PartialEq)]
pub enum CameraChoice {
    /// One that is there, as it is named.
    Named(String),
    /// The asker's own.
    Own(Box<crate::Camera>),
}

/// What a picture is asked to be. Which camera and which light a name means depends on where they are.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderRequest {
    /// The camera; by default the first, or one that frames the scene.
    pub camera: Option<CameraChoice>,
    /// Width and height in pixels; by default of the camera's shape, about as many as 640x360.
    pub size: Option<[u32; 2]>,
    /// What the picture shows.
    pub aovs: Aovs,
    /// Samples a pixel.
    pub samples: u32,
    /// The light that AOVs of a light are of, as it is named; by default the first, of all AOVs each.
    pub light: Option<String>,
    /// How much of the scene's fill the beauty has.
    pub fill: f64,
    /// Stops by which a PNG of the beauty is brightened; an EXR holds the radiance itself.
    pub exposure: f64,
}

impl Default for RenderRequest {
    fn default() -> Self {
        let aovs = Aovs::Listed(vec![Aov::Beauty]);
        Self { camera: None, size: None, aovs, samples: 1, light: None, fill: 1.0, exposure: 0.0 }
    }
}

/// Which quantities are asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Aovs {
    /// These, each once and one at least.
    Listed(Vec<Aov>),
    /// All that a camera sees, those of a light for each light.
    All,
}

impl Aovs {
    /// What stands for all of them.
    pub const ALL: &str = "all";

    /// Reads names with commas between, or `all`.
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

    /// Each of them.
    pub fn each(&self) -> &[Aov] {
        match self {
            Self::Listed(aovs) => aovs,
            Self::All => &[
                Aov::Beauty,
                Aov::Depth,
                Aov::Normal,
                Aov::Position,
                Aov::T,
                Aov::Vw,
                Aov::Direction,
                Aov::Visibility,
            ],
        }
    }

    /// The names of the quantities.
    pub fn names(&self) -> String {
        let names: Vec<&str> = self.each().iter().map(|aov| aov.name()).collect();
        names.join(", ")
    }
}

impl RenderRequest {
    /// Checks how much of the fill the beauty is to have.
    pub fn check_fill(factor: f64) -> Result<f64, RenderRefusal> {
        if View::FILL_RANGE.contains(&factor) {
            Ok(factor)
        } else {
            Err(RenderRefusal::Fill(factor.to_string()))
        }
    }

    /// Reads the same.
    pub fn parse_fill(text: &str) -> Result<f64, RenderRefusal> {
        let refused = || RenderRefusal::Fill(text.chars().take(20).collect());
        Self::check_fill(text.parse().map_err(|_| refused())?)
    }

    /// Checks by how many stops a picture is to be brightened.
    pub fn check_exposure(stops: f64) -> Result<f64, RenderRefusal> {
        if View::EXPOSURE_RANGE.contains(&stops) {
            Ok(stops)
        } else {
            Err(RenderRefusal::Exposure(stops.to_string()))
        }
    }

    /// Reads the same.
    pub fn parse_exposure(text: &str) -> Result<f64, RenderRefusal> {
        let refused = || RenderRefusal::Exposure(text.chars().take(20).collect());
        Self::check_exposure(text.parse().map_err(|_| refused())?)
    }

    /// Width over height of the picture, for a camera that is made to frame the scene.
    pub fn framing_aspect(&self) -> f64 {
        self.size.map_or(DEFAULT_ASPECT, |[width, height]| f64::from(width) / f64::from(height))
    }

    /// The view of its first quantity, from `camera` and of the light of index `light`.
    pub fn view(&self, camera: Camera, light: usize, limits: RenderLimits, slot: ViewSlot) -> View {
        let size = self.size.unwrap_or_else(|| camera.projection.default_size(limits.max_side));
        let Self { samples, fill, exposure, .. } = *self;
        let aov = self.aovs.each()[0];
        View { samples, aov, light, fill, exposure, slot, ..View::beauty(camera, size) }
    }

    /// Refuses a light where no quantity is of one, and a drawing of a light's map beside what a camera sees.
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

/// The parameters of `GET /sessions/S/render`, as they come.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RenderParameters {
    /// A name, an id, or a camera as JSON.
    pub camera: Option<String>,
    /// As [`RenderLimits::parse_size`] reads it.
    pub size: Option<String>,
    /// As [`Aovs::parse`] reads them.
    pub aov: Option<String>,
    /// As [`RenderRequest::samples`].
    pub samples: Option<u32>,
    /// As [`RenderRequest::light`].
    pub light: Option<String>,
    /// As [`RenderRequest::fill`].
    pub fill: Option<f64>,
    /// As [`RenderRequest::exposure`].
    pub exposure: Option<f64>,
    /// The record after which the document is shown; by default the latest.
    pub at: Option<u64>,
    /// The lights that shine: ids or names, as a JSON array or with commas between; by default all.
    pub lights: Option<String>,
    /// What is set for this picture alone: a JSON object of addresses and values.
    pub set: Option<String>,
    /// What a PNG has where nothing is seen.
    #[serde(default)]
    pub background: RenderBackground,
    /// What files the picture comes as: `png`, `exr`, or both with a comma between.
    pub format: Option<String>,
}

/// What a PNG has where nothing is seen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum RenderBackground {
    /// Black.
    #[default]
    Black,
    /// Nothing.
    Transparent,
}

/// What file a picture comes as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RenderFormat {
    /// For people.
    Png,
    /// Linear values.
    Exr,
}

impl RenderParameters {
    /// What they ask for, within the limits of HTTP.
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

    /// The files that are asked for, each once and one at least.
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

    /// The lights that shine, as they are called, where not all do.
    pub fn lights(&self) -> Result<Option<Vec<String>>, RenderRefusal> {
        let Some(text) = self.lights.as_deref() else { return Ok(None) };
        if text.trim_start().starts_with('[') {
            return json_parameter("lights", text).map(Some);
        }
        let names = text.split(',').map(str::trim).filter(|name| !name.is_empty());
        Ok(Some(names.map(str::to_owned).collect()))
    }

    /// What is set for this picture alone, by its addresses.
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

/// What a parameter holds as JSON.
fn json_parameter<T: serde::de::DeserializeOwned>(
    what: &'static str,
    text: &str,
) -> Result<T, RenderRefusal> {
    crate::parse_body(text).map_err(|why| RenderRefusal::Json { what, why: why.to_string() })
}

/// Why a picture is not made.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum RenderRefusal {
    /// Something else than a size.
    #[error("the size is `{text}`: write it as WIDTHxHEIGHT in pixels, each from 1 to {max_side}")]
    Size {
        /// The start of what came.
        text: String,
        /// Pixels along a side at most.
        max_side: u32,
    },
    /// A side over the limit.
    #[error("each side of a picture has 1 to {max_side} pixels: make it smaller")]
    TooLarge {
        /// Pixels along a side at most.
        max_side: u32,
    },
    /// No sample at all.
    #[error("a pixel has 1 to {max_samples} samples: ask for more than 0")]
    NoSamples {
        /// Samples a pixel at most.
        max_samples: u32,
    },
    /// Samples over the limit.
    #[error("a pixel has 1 to {max_samples} samples: ask for fewer")]
    TooManySamples {
        /// Samples a pixel at most.
        max_samples: u32,
    },
    /// A factor that the fill cannot have.
    #[error("the fill's factor is `{0}`: give a number from {start} to {end}", start = View::FILL_RANGE.start(), end = View::FILL_RANGE.end())]
    Fill(String),
    /// Stops that an exposure cannot have.
    #[error("the exposure is `{0}`: give a number of stops from {start} to {end}", start = View::EXPOSURE_RANGE.start(), end = View::EXPOSURE_RANGE.end())]
    Exposure(String),
    /// A light that nothing which is asked for is of.
    #[error(
        "{0} is not of one light: leave `light` out, or ask for t, vw, direction, visibility or wireframe"
    )]
    OfNoLight(String),
    /// A wireframe beside other quantities.
    #[error("a wireframe is the light's view and not the camera's: ask for it alone")]
    NotOfCamera,
    /// Another kind of file.
    #[error("the format is `{0}`: give png, exr, or png,exr")]
    Format(String),
    /// A parameter that is not the JSON that it has to be.
    #[error("`{what}`: {why}")]
    Json {
        /// The parameter's name.
        what: &'static str,
        /// What is wrong with it.
        why: String,
    },
    /// More than one request may hold.
    #[error(
        "the pictures have more than {limit_mib} MiB before they are compressed: ask for fewer pixels, AOVs or lights"
    )]
    TooMuch {
        /// How much they may have.
        limit_mib: usize,
    },
    /// A quantity that pictures do not show.
    #[error(transparent)]
    Aov(#[from] UnknownAov),
}

impl RenderRefusal {
    /// The code that programs act on.
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

    /// What is refused has the number that is allowed in its sentence, which each place that takes pictures has of its own.
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
    fn what_is_left_out_has_its_default() {
        assert_eq!(RenderParameters::default().request(), Ok(RenderRequest::default()));
    }
}
