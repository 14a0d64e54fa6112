//! Point files: a JSON array of world positions `[x, y, z]`.

use glam::DVec3;

use crate::FileError;
use crate::error::from_json;

/// Reads a point file's text.
pub fn parse(text: &str) -> Result<Vec<DVec3>, FileError> {
    let points: Vec<[f64; 3]> = from_json(text)?;
    Ok(points.into_iter().map(DVec3::from).collect())
}
