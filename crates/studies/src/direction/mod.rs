//! From where does light arrive: along the tube, along the path, as the paper prints it, or along a path that is smooth
//! at joints?
//!
//! Light model, section 3. The path's tangent is what visibility follows, so shading by anything else disagrees with
//! its own shadows where light grazes a surface. But curvature jumps at the joints of a spline, and the tangent of a
//! tapering tube's paths with it, which shows as an edge in the shading. Here both are measured, over a grid of bends
//! and tapers and in a picture.

mod chart;
mod grid;
mod law;
mod picture;
#[cfg(test)]
mod tests;

use std::io::Cursor;
use std::sync::Arc;

use image::{ImageFormat, RgbImage};
use light::{CheckedLight, Tube};
use scene::{Camera, Scene};
use serde::Serialize;

pub use grid::{AtCell, Cell};
pub use law::{LAWS, Law};
pub use picture::InPicture;

use self::picture::Stage;
use crate::StudyError;
use crate::timing::nanoseconds;

/// What `bendylights-studies direction` answers.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Report {
    /// What each law costs in f64 on one core.
    pub nanoseconds: Vec<Time>,
    /// The laws at a joint between a bent and a straight segment, over bend and taper.
    pub grid: Vec<Cell>,
    /// The laws in the picture.
    pub picture: Vec<InPicture>,
}

/// What a law costs.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Time {
    /// How the direction was found.
    pub law: Law,
    /// Nanoseconds a direction, the place in the tube being known.
    pub nanoseconds: f64,
}

/// A picture and the name of its file.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Such as `tube.png`.
    pub file_name: String,
    /// Its bytes, in sRGB.
    pub png: Vec<u8>,
}

/// Measures the laws, and shows them on `scene` under its first BendyLight, `size` pixels wide and high; `row_done` is
/// called once a row of the picture.
pub fn run(
    (scene, lights, camera): (&Scene, &[Arc<CheckedLight>], Option<&Camera>),
    size: [u32; 2],
    row_done: impl Fn() + Sync,
) -> Result<(Report, Vec<Picture>), StudyError> {
    let tube = lights.iter().find_map(|light| light.tube()).ok_or(StudyError::NoBendyLight)?;
    let stage = Stage::new((scene, camera), tube, size, row_done);
    let report = Report { nanoseconds: times(tube), grid: grid::grid(), picture: stage.measure() };
    let of_law = |law| Picture::new(format!("{law:?}.png").to_lowercase(), &stage.picture(law));
    let mut pictures = LAWS.map(of_law).to_vec();
    pictures.push(Picture::new("panels.png".into(), &stage.panels()));
    Ok((report, pictures))
}

impl Picture {
    fn new(file_name: String, image: &RgbImage) -> Self {
        let mut png = Cursor::new(Vec::new());
        image.write_to(&mut png, ImageFormat::Png).expect("memory takes a picture");
        Self { file_name, png: png.into_inner() }
    }
}

/// Angles over bend and taper as an SVG.
pub fn chart(report: &Report) -> Result<String, StudyError> {
    chart::chart(report).map_err(|error| StudyError::Chart(error.to_string()))
}

fn times(tube: &Tube<f64>) -> Vec<Time> {
    let places = (0..tube.n).flat_map(|segment| (0..500).map(move |k| (segment, f64::from(k) / 500.0)));
    let roots: Vec<_> = places.map(|(segment, u)| grid::at_edge(tube, segment, u, 7.0 * u)).collect();
    LAWS.map(|law| Time { law, nanoseconds: nanoseconds(&roots, |root| law.direction(tube, root)) }).to_vec()
}
